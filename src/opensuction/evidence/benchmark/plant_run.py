"""One compensator carried out on one plant: by the whole controller on a twin, or on a model.

A twin runs the whole controller with its governor, scored as the paper scores (laser minus
reference). A model plant runs the compensator on an ideal servo, scored without sensor noise.

A compensator on an ideal servo: the head follows its command, and nothing is noisy or late.

What is left is compensator against plant; any model of hysteresis can be that plant, because a
compensator never sees the tip. Nobody is on such a machine, and no governor watches it.
"""

from collections.abc import Callable
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from opensuction.control import compensation, motion_profile
from opensuction.control.backlash_inverse import HeadState
from opensuction.control.compensation import Branches, Compensation, CompensationKind
from opensuction.control.motion_profile import HeadLimits
from opensuction.controller import machine_profile, setup
from opensuction.controller.calibration import PLAIN_PD, Calibration, adapted, learn, passed
from opensuction.evidence.benchmark.benchmark_plant import (
    BENCH_STROKE,
    KEPT,
    NOTHING,
    Disturbance,
    Model,
    Plant,
    Twin,
    delay,
    disturb_tip,
    disturb_transmission,
    wide_recording,
)
from opensuction.evidence.benchmark.benchmark_plant import noise_mm as laser_noise_mm
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.identification.estimator import modified_dahl as estimator
from opensuction.identification.estimator import prandtl_ishlinskii as play_estimator
from opensuction.identification.estimator import servo
from opensuction.identification.estimator.adaptation import unchanged
from opensuction.identification.estimator.gap_measurement import TRUSTED
from opensuction.identification.judgement import recommendation
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array
from opensuction.procedure.cycle import cycle
from opensuction.procedure.cycle import plan as plans
from opensuction.procedure.cycle.demand import INWARDS, NOT_ANNOUNCED_S, OUTWARDS
from opensuction.procedure.cycle.plan import Excitation, Plan
from opensuction.procedure.planning import planner
from opensuction.procedure.planning.clinical import Template
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.cycle.equipment import EVERY, with_lines
from opensuction.session.cycle.resolution import ResolvedCycle
from opensuction.simulation import outcome, self_calibration
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import AT_START, Injection
from opensuction.simulation.rig import Identification, Rig
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault


class Course(NamedTuple):
    """Course of the tip's reference, a sample a tick: the way in, the dwell and the way out."""

    demand: Array
    """Reference, its velocity, direction of the next motion and time until it; shape (n, 4)."""
    insertion_tick: int
    """Tick at which the tip begins to move in; before it the gap may be crossed."""


def cycle_course(plan: Plan) -> Course:
    """The demand of one cycle of known travel, as the procedure announces it (`Demand`)."""
    motion = plan.motion
    in_s = float(motion_profile.staged_duration_s(plans.way_in(motion, motion.park_mm)))
    way_out = plans.way_out(motion, motion.target_mm, motion.withdrawal_mm_per_s)
    leaving_s = plan.preload_s + in_s + plan.dwell_s
    total_s = leaving_s + float(motion_profile.duration_s(way_out))
    demand = np.empty((round(total_s / DT_S) + 1, 4))
    _fill(plan, plan.preload_s + in_s, demand)
    return Course(demand, round(plan.preload_s / DT_S))


@compiled
def _fill(plan: Plan, arrived_s: float, demand: Array) -> None:
    """Write the rows of `Course.demand`. arrived_s: when the reference reaches the target."""
    motion = plan.motion
    way_in = plans.way_in(motion, motion.park_mm)
    way_out = plans.way_out(motion, motion.target_mm, motion.withdrawal_mm_per_s)
    leaving_s = arrived_s + plan.dwell_s
    for tick in range(demand.shape[0]):
        now_s = tick * DT_S
        direction, starts_in_s = INWARDS, 0.0
        reference, velocity = motion.park_mm, 0.0
        if now_s < plan.preload_s:
            starts_in_s = plan.preload_s - now_s
        elif now_s < leaving_s:
            reference, velocity = motion_profile.staged_at(way_in, now_s - plan.preload_s)
            left_s = leaving_s - now_s
            if now_s >= arrived_s:
                starts_in_s = NOT_ANNOUNCED_S
            if left_s <= plan.gap_lead_s:
                direction, starts_in_s = OUTWARDS, left_s
        else:
            reference, velocity = motion_profile.at(way_out, now_s - leaving_s)
            direction = OUTWARDS
        demand[tick, 0] = reference
        demand[tick, 1] = velocity
        demand[tick, 2] = direction
        demand[tick, 3] = starts_in_s


@compiled
def lead(
    chosen: Compensation,
    heads_mm: Branches | None,
    limits: HeadLimits,
    start: HeadState,
    demand: Array,
    dt_s: float,
) -> Array:
    """Head positions under a compensator at the end of each tick, mm, shape (n,).

    A command is where the head shall be when its tick ends; by then the reference is that of the
    next tick. heads_mm: branches of the compensation. limits: of the head, which follows the
    command no faster. demand: as `Course.demand`.
    """
    heads = np.empty(demand.shape[0])
    state, head, velocity = start, start.head_mm, 0.0
    for tick in range(demand.shape[0]):
        state = compensation.step(
            chosen,
            heads_mm,
            state,
            demand[tick, 0],
            demand[tick, 1],
            demand[tick, 2],
            demand[tick, 3],
            dt_s,
        )
        most = limits.speed_mm_per_s
        wanted = min(max(state.head_mm_per_s, -most), most)
        # From where the command was a tick ago: at the end of this one the head is where it is.
        distance = state.head_mm - wanted * dt_s - head
        velocity = motion_profile.step(limits, distance, wanted, velocity, dt_s)
        head += velocity * dt_s
        heads[tick] = head
    return heads


BARRIER_MM = 10.0
"""[assumed] Depth at which a model plant has a light barrier on the tip's way: as far from where
the tip begins as the clinical machine's, which has it at the tube's mouth."""
SPEED_WINDOW_S = 0.05
"""Window of the head's speed: encoder steps would show as speed in a shorter one."""


class PlantRun(NamedTuple):
    """One compensator on one plant with one seed."""

    error_mm: Array
    """Tip minus reference over the scored span, shape (ticks,)."""
    head_mm_per_s: float
    """Fastest that the head moved in that span."""
    completed: bool
    trips: int

    @property
    def rmse_mm(self) -> float:
        """Root mean square of the error."""
        return float(np.sqrt(np.mean(np.square(self.error_mm))))


CarryOut = Callable[[CompensationKind, Disturbance], PlantRun]
"""Carries a compensator out on one plant, identified before it was disturbed. Raises InputError
where it cannot. A further column is one more of these: whatever comes of a disturbance."""


def _run(error_mm: Array, head_mm: Array, completed: bool, trips: int) -> PlantRun:
    speed = servo.velocity_mm_per_s(head_mm, DT_S, SPEED_WINDOW_S)
    return PlantRun(error_mm, float(np.max(np.abs(speed))), completed, trips)


@lru_cache(maxsize=KEPT)
def _draw(
    machine: str, protocol: str, conduit: str | None, seed: int
) -> tuple[ResolvedCycle, Rig, Identification]:
    """A drawn machine, identified and, where its protocol wants it, taught."""
    equipment = RigChoice(machine, conduit=conduit, seed=seed)
    resolved = resolution.resolve(CycleChoice(equipment, protocol, compensation="none"))
    rig = resolved.equipment.draw()
    identification = rigs.identify(rig)
    if isinstance(resolved.protocol, Template):
        taught_mm = cycle_run.teach(resolved, rig, identification.calibration)
        rig = cycle_run.with_depth(rig, taught_mm)
    return resolved, rig, identification


def _take_twin(twin: Twin, seed: int) -> CarryOut:
    """Cycles of one drawn twin, identified once for all compensators, routes and disturbances."""
    resolved, drawn, identified = _draw(twin.machine, twin.protocol, twin.conduit, seed)
    rig = self_calibration.with_widths(drawn, twin.scale)

    @cache
    def calibrate(kind: CompensationKind) -> Calibration:
        """By the machine as it was drawn."""
        if kind == CompensationKind.NONE:
            return rigs.uncalibrated(rig.profile)
        if kind == CompensationKind.MODEL_PREVIEW:
            return with_lines(drawn, identified.calibration)
        return identified.calibration

    def carry_out(kind: CompensationKind, disturbance: Disturbance) -> PlantRun:
        chosen = resolved._replace(compensation=kind)
        conduit = disturb_transmission(rig.machine.transmission, disturbance)
        machine = rig.machine._replace(transmission=conduit)
        changed = rig._replace(machine=machine)
        return _cycle(chosen, changed, calibrate(kind), disturbance.delay_s)

    return carry_out


def _cycle(resolved: ResolvedCycle, rig: Rig, calibration: Calibration, delay_s: float) -> PlantRun:
    """One cycle; the controller goes by what was identified, the rig may have changed since."""
    prepared = cycle_run.assemble(resolved, rig, calibration)
    columns = cycle_run.play(prepared) if delay_s == 0.0 else _play_late(prepared, delay_s)
    scored = outcome.tracked(columns, cycle_run.tracked_span_s(prepared))
    figures = cycle_run.figures(prepared, columns)
    error = outcome.tracking_error_mm(columns)[scored]
    head = columns["readings.head_mm"][scored]
    return _run(error, head, figures.completed, len(figures.trips))


def _play_late(prepared: Prepared, delay_s: float) -> Columns:
    """A cycle whose commands reach the drives late all the time."""
    late = Injection(Fault.MESSAGE_LATE, AT_START, delay_s)
    return injection.run(prepared.loop, prepared.start, (late,), after_s=0.0).columns


@lru_cache(maxsize=4)
def excitation_mm(whole: Excitation = BENCH_STROKE, inner: bool = False) -> Array:
    """Head of an identification, shape (ticks,); with its shorter strokes where asked."""
    parts = rigs.strokes(whole, inner)
    heads = [
        cycle.excite(part, tick * DT_S)[0]
        for part in parts
        for tick in range(round(part.duration_s / DT_S))
    ]
    return np.array(heads)


def lines_of(plant: Plant, seed: int, whole: Excitation = BENCH_STROKE) -> PlayLines:
    """The model of plays that `model-preview` drives by. Raises InputError where none drives."""
    head = excitation_mm(whole, inner=True)
    tip = plant(head) + laser_noise_mm(seed, head.size)
    every = slice(None, None, EVERY)
    lines = recommendation.choose(head[every].copy(), tip[every].copy(), only_lines=True).lines
    assert lines is not None
    return lines


def identify(plant: Plant, seed: int, whole: Excitation = BENCH_STROKE) -> Calibration:
    """Calibration of a plant by the bench's estimators, its tip under the bench's laser noise."""
    head = excitation_mm(whole)
    tip = plant(head) + laser_noise_mm(seed, head.size)
    fit, plays = estimator.fit(head, tip), play_estimator.fit(head, tip)
    return rigs.calibrated(head, tip, fit, plays, PLAIN_PD)


class Driven(NamedTuple):
    """Head positions of a compensator for the paper's trapezoid on an ideal servo."""

    parked_mm: float
    heads_mm: Array
    course: Course


def drive_model(kind: CompensationKind, calibration: Calibration) -> Driven:
    """The head's way; no compensator sees the tip. Raises InputError where nothing is planned."""
    profile = machine_profile.BENCH
    able = setup.abilities(profile, kind, calibration, BENCH_SITE)
    plan = planner.plan(PAPER, able, profile.excitation, False, BENCH_SITE)
    speeds = (PAPER.insertion_mm_per_s, PAPER.withdrawal_mm_per_s)
    chosen = setup.compensator(profile, kind, calibration, speeds)
    course = cycle_course(plan)
    limits = HeadLimits(profile.head_limit_mm_per_s, profile.acceleration_mm_per_s2)
    branches_mm = setup.branches(kind, calibration)
    parked = compensation.park(chosen, compensation.rest(chosen, branches_mm, BENCH_SITE.park_mm))
    heads = lead(chosen, branches_mm, limits, parked, course.demand, DT_S)
    return Driven(parked.head_mm, heads, course)


def follow(plant: Plant, driven: Driven, disturbance: Disturbance) -> tuple[Array, Array]:
    """A head that goes that way, parked first, and the plant's tip behind it."""
    heads = np.concatenate(([driven.parked_mm], driven.heads_mm))
    tips = plant(delay(heads, disturbance, DT_S))
    return heads, disturb_tip(tips, float(plant(np.zeros(1))[0]), disturbance, DT_S)


def adapt(
    plant: Plant, kind: CompensationKind, identified: Calibration, disturbance: Disturbance
) -> Calibration:
    """Adapt gap and offset by the disturbance's cycles, from the head as the tip passes a barrier.

    Raises InputError where a cycle cannot be planned by what was learned.
    """
    used, change, by_lines = identified, unchanged(TRUSTED), kind == CompensationKind.MODEL_PREVIEW
    for _ in range(disturbance.cycles):
        heads, tips = follow(plant, drive_model(kind, used), disturbance)
        dark = tips > BARRIER_MM
        seen = passed(identified, ~dark, heads, BARRIER_MM, DT_S, by_lines)
        change = learn(identified, change, seen)
        used = adapted(identified, change.new)
    return used


def judge(plant: Plant, driven: Driven, disturbance: Disturbance = NOTHING) -> PlantRun:
    """A plant's tip behind a head that goes that way; the plant has its changed gap already."""
    tips = follow(plant, driven, disturbance)[1][1:]
    scored = slice(driven.course.insertion_tick, None)
    # A tick ends where the next one begins: the reference is that of then.
    reference = driven.course.demand[:, 0]
    error = tips - np.append(reference[1:], reference[-1])
    return _run(error[scored], driven.heads_mm[scored], True, 0)


def run_on_model(plant: Plant, kind: CompensationKind, calibration: Calibration) -> PlantRun:
    """The paper's trapezoid on an ideal servo. Raises InputError where it cannot be planned."""
    return judge(plant, drive_model(kind, calibration))


def _take_model(model: Model, seed: int) -> CarryOut:
    laid = model.matched(*wide_recording(seed))
    calibration = identify(laid(1.0), seed, model.stroke)
    nominal = rigs.uncalibrated(machine_profile.BENCH)

    @cache
    def calibrate(kind: CompensationKind) -> Calibration:
        """Without compensation there is nothing to identify."""
        if kind == CompensationKind.NONE:
            return nominal
        if kind == CompensationKind.MODEL_PREVIEW:
            return calibration._replace(lines=lines_of(laid(1.0), seed, model.stroke))
        return calibration

    @cache
    def drive(kind: CompensationKind) -> Driven:
        """No disturbance reaches the head."""
        return drive_model(kind, calibrate(kind))

    def carry_out(kind: CompensationKind, disturbance: Disturbance) -> PlantRun:
        changed = laid(disturbance.gap_ratio)
        if disturbance.cycles == 0 or kind == CompensationKind.NONE:
            return judge(changed, drive(kind), disturbance)
        learned = adapt(changed, kind, calibrate(kind), disturbance)
        return judge(changed, drive_model(kind, learned), disturbance)

    return carry_out


def take(plant: Twin | Model, seed: int) -> CarryOut:
    """A plant drawn by a seed, identified and ready for any compensator and disturbance."""
    return _take_model(plant, seed) if isinstance(plant, Model) else _take_twin(plant, seed)
