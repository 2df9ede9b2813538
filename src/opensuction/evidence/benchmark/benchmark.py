"""Every compensator on every plant with fixed seeds: which one is good for what.

A twin runs the whole controller with its governor, scored as the paper scores (laser minus
reference). A model plant runs the compensator on an ideal servo, scored without sensor noise.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from opensuction import __version__
from opensuction.control import compensation
from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.control.head_path import HeadLimits
from opensuction.controller import machine_profile, setup
from opensuction.controller.calibration import PLAIN_PD, Calibration
from opensuction.evidence.benchmark.benchmark_plant import (
    KEPT,
    PLANTS,
    Model,
    Plant,
    Twin,
    wide_recording,
)
from opensuction.evidence.benchmark.benchmark_plant import noise_mm as laser_noise_mm
from opensuction.identification.estimator import modified_dahl as estimator
from opensuction.identification.estimator import prandtl_ishlinskii as play_estimator
from opensuction.identification.estimator import servo
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.procedure.cycle import cycle
from opensuction.procedure.planning import planner
from opensuction.procedure.planning.clinical import Template
from opensuction.procedure.planning.protocol import PAPER
from opensuction.procedure.planning.site import BENCH_SITE
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.resolution import ResolvedCycle
from opensuction.simulation import ideal_loop, outcome
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.rig import Identification, Rig

FIRST_SEED = 101
"""Seeds that no compensator was written with."""
SPEED_WINDOW_S = 0.05
"""Window of the head's speed: encoder steps would show as speed in a shorter one."""


class Run(NamedTuple):
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


CarryOut = Callable[[CompensationKind], Run]
"""Carries a compensator out on one identified plant. Raises InputError where it cannot."""


class BenchmarkResult(NamedTuple):
    """One compensator on one plant, all seeds."""

    plant: str
    compensation: str
    runs: tuple[Run, ...]
    refused: str
    """Why the controller refused the first refused run; empty where none was."""


class Benchmark(NamedTuple):
    """All results, in the order of plants and compensators."""

    seeds: tuple[int, ...]
    results: list[BenchmarkResult]


def seeds_of(count: int) -> tuple[int, ...]:
    """The first ``count`` seeds of the benchmark."""
    return tuple(range(FIRST_SEED, FIRST_SEED + count))


def _run(error_mm: Array, head_mm: Array, completed: bool, trips: int) -> Run:
    speed = servo.velocity_mm_per_s(head_mm, DT_S, SPEED_WINDOW_S)
    return Run(error_mm, float(np.max(np.abs(speed))), completed, trips)


@lru_cache(maxsize=KEPT)
def _draw(
    machine: str, protocol: str, conduit: str, seed: int
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
    """Cycles of one drawn twin, identified once for all compensators and routes."""
    resolved, rig, identified = _draw(twin.machine, twin.protocol, twin.conduit, seed)
    return lambda kind: _cycle(resolved._replace(compensation=kind), rig, twin.scale, identified)


def _cycle(resolved: ResolvedCycle, rig: Rig, scale: float, identified: Identification) -> Run:
    """One cycle; the controller goes by what was identified, the conduit may be laid otherwise."""
    calibration = identified.calibration
    if resolved.compensation == CompensationKind.NONE:
        calibration = rigs.uncalibrated(rig.profile)
    resolved = resolved._replace(choice=resolved.choice._replace(gap_scale=scale))
    prepared = cycle_run.assemble(resolved, rig, calibration)
    columns = cycle_run.play(prepared)
    scored = outcome.tracked(columns, cycle_run.tracked_span_s(prepared))
    figures = cycle_run.figures(prepared, columns)
    error = outcome.tracking_error_mm(columns)[scored]
    head = columns["readings.head_mm"][scored]
    return _run(error, head, figures.completed, len(figures.trips))


@lru_cache(maxsize=1)
def excitation_mm() -> Array:
    """Head of the bench's identification, shape (ticks,)."""
    excitation = machine_profile.BENCH.excitation
    ticks = round(excitation.duration_s / DT_S)
    return np.array([cycle.excite(excitation, tick * DT_S)[0] for tick in range(ticks)])


def identify(plant: Plant, seed: int) -> Calibration:
    """What the bench's estimators make of a plant, its tip under the bench's laser noise."""
    head = excitation_mm()
    tip = plant(head) + laser_noise_mm(seed, head.size)
    fit, plays = estimator.fit(head, tip), play_estimator.fit(head, tip)
    return rigs.calibrated(head, tip, fit, plays, PLAIN_PD)


def run_on_model(plant: Plant, kind: CompensationKind, calibration: Calibration) -> Run:
    """The paper's trapezoid on an ideal servo. Raises InputError where it cannot be planned."""
    profile = machine_profile.BENCH
    able = setup.abilities(profile, kind, calibration, BENCH_SITE)
    plan = planner.plan(PAPER, able, profile.excitation, False, BENCH_SITE)
    speeds = (PAPER.insertion_mm_per_s, PAPER.withdrawal_mm_per_s)
    chosen = setup.compensator(profile, kind, calibration, speeds)
    course = ideal_loop.course(plan)
    limits = HeadLimits(profile.head_limit_mm_per_s, profile.acceleration_mm_per_s2)
    branches_mm = setup.branches(kind, calibration)
    parked = compensation.park(chosen, compensation.rest(chosen, branches_mm, BENCH_SITE.park_mm))
    heads = ideal_loop.lead(chosen, branches_mm, limits, parked, course.demand, DT_S)
    tips = plant(np.concatenate(([parked.head_mm], heads)))[1:]
    scored = slice(course.insertion_tick, None)
    return _run((tips - course.demand[:, 0])[scored], heads[scored], True, 0)


def _take_model(model: Model, seed: int) -> CarryOut:
    plant = model.matched(*wide_recording(seed))
    calibration = identify(plant, seed)
    nominal = rigs.uncalibrated(machine_profile.BENCH)

    def run(kind: CompensationKind) -> Run:
        """One compensator; without compensation there is nothing to identify."""
        return run_on_model(plant, kind, nominal if kind == CompensationKind.NONE else calibration)

    return run


def run_on_plant(
    plant: Twin | Model, seeds: tuple[int, ...], compensations: tuple[str, ...]
) -> list[BenchmarkResult]:
    """Some compensators on one plant."""
    runs: dict[str, list[Run]] = {name: [] for name in compensations}
    refused = dict.fromkeys(compensations, "")
    for seed in seeds:
        carry_out = (
            _take_model(plant, seed) if isinstance(plant, Model) else _take_twin(plant, seed)
        )
        for name in compensations:
            try:
                runs[name].append(carry_out(KIND_OF_NAME[name]))
            except InputError as refusal:
                refused[name] = refused[name] or str(refusal)
    return [
        BenchmarkResult(plant.name, name, tuple(runs[name]), refused[name])
        for name in compensations
    ]


def run(
    count: int,
    tell: Callable[[str], None] = lambda _: None,
    plants: tuple[Twin | Model, ...] = PLANTS,
    compensations: tuple[str, ...] = tuple(KIND_OF_NAME),
) -> Benchmark:
    """Run everything. count: of seeds. tell: called with a line of progress before each plant."""
    seeds, results = seeds_of(count), []
    for number, plant in enumerate(plants, start=1):
        tell(f"{number} of {len(plants)}: {plant.name}, {plant.about}")
        results += run_on_plant(plant, seeds, compensations)
    return Benchmark(seeds, results)


def _round(value: float) -> float:
    """To a tenth of a micrometre: further digits are the arithmetic of one processor."""
    return round(value, 4)


def figures(result: BenchmarkResult) -> dict[str, Any]:
    """One entry of ``results``; None where every run was refused."""
    rmse = [run.rmse_mm for run in result.runs]
    peaks = [float(np.max(np.abs(run.error_mm))) for run in result.runs]
    speeds = [run.head_mm_per_s for run in result.runs]
    return {
        "plant": result.plant,
        "compensation": result.compensation,
        "seeds": len(result.runs),
        "rmse_mm": _round(float(np.mean(rmse))) if rmse else None,
        "rmse_worst_mm": _round(max(rmse)) if rmse else None,
        "peak_mm": _round(max(peaks)) if peaks else None,
        "head_mm_per_s": _round(max(speeds)) if speeds else None,
        "completed": sum(run.completed for run in result.runs),
        "trips": sum(run.trips for run in result.runs),
        "refused": result.refused or None,
    }


def _first_seed_rmse_mm(found: Benchmark) -> dict[str, dict[str, float]]:
    """RMSE of the first seed alone by plant and compensator: what a quick check can repeat."""
    first: dict[str, dict[str, float]] = {}
    for result in found.results:
        if result.runs:
            rmse_mm = _round(result.runs[0].rmse_mm)
            first.setdefault(result.plant, {})[result.compensation] = rmse_mm
    return first


def plain(found: Benchmark, wall_s: float) -> dict[str, Any]:
    """The JSON object of the command."""
    return {
        "version": __version__,
        "in_silico": True,
        "seeds": list(found.seeds),
        "results": [figures(result) for result in found.results],
        "first_seed_rmse_mm": _first_seed_rmse_mm(found),
        "wall_s": wall_s,
    }
