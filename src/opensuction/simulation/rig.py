"""Runs on one machine: identification with the laser, then automated cycles."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.controller.calibration import PLAIN_PD, Calibration, Feedforward, assume_nominal
from opensuction.controller.machine_profile import MachineProfile
from opensuction.hysteresis.bank import play_lines
from opensuction.identification.estimator import branch_curve
from opensuction.identification.estimator import modified_dahl as estimator
from opensuction.identification.estimator import prandtl_ishlinskii as play_estimator
from opensuction.identification.estimator import servo as servo_estimator
from opensuction.identification.estimator.modified_dahl import Fit
from opensuction.identification.estimator.prandtl_ishlinskii import PrandtlIshlinskiiFit
from opensuction.identification.estimator.servo import ServoFit
from opensuction.kernel.interface import IDENTIFY, NO_REQUESTS
from opensuction.kernel.vocabulary import AgeGroup, Phase
from opensuction.procedure.cycle.interlocks import NEW_CATHETER_S
from opensuction.procedure.cycle.plan import Excitation
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER, Protocol, Site
from opensuction.simulation import machine_kind, trace
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.machine_kind import MachineKind
from opensuction.simulation.trace import Columns
from opensuction.twin import parameter, preset
from opensuction.twin.machine.machine import Machine
from opensuction.twin.patient import patient_kind
from opensuction.twin.patient.patient_kind import PatientKind

VELOCITY_WINDOW_S = 0.05
"""Window of the velocity estimate for the servo fit."""
STANDING_S = 2.5
"""A machine stands before anybody asks it for anything; its current sensor's offset is learnt by
then, five time constants [computed]."""
SLOWEST_MM_PER_S = 2.0
"""Slower samples say little about the servo."""
NO_CARINA_MM = 1000.0
"""Nothing in the tip's way."""
CONNECTOR_MM = 20.0
"""Distance from the tube's upper end at which the tip parks in the connector."""
FAST_MM_PER_S = 30.0
"""Speed inside the tube [design-speed]."""
DEFAULT_PATIENT = "adult-icu"
EXCITING = PAPER._replace(negative_pressure_budget_s=60.0, in_airway_budget_s=60.0)
"""Protocol of an identification run: nobody is on the machine, and the valve stays closed."""
INNER_STROKES = (0.8, 0.6, 0.4, 0.2)
"""[design] Lengths of further strokes, as shares of the excitation's, as fast: a model whose loops
change with the place has to see turns at more places than both ends."""
IDENTIFICATION_RUN = 1
"""Number of the noise stream of identification runs; cycles use others."""


class Rig(NamedTuple):
    """One machine of the twin: its parameters, its records and how its controller knows it."""

    kind: MachineKind
    """What it was drawn from."""
    values: dict[str, float]
    machine: Machine
    profile: MachineProfile
    site: Site
    seed: int


class Recording(NamedTuple):
    """The excitation as it was recorded, one entry a tick of `DT_S`; each of shape (n,)."""

    head_mm: npt.NDArray[np.float64]
    """Encoder."""
    laser_mm: npt.NDArray[np.float64]
    """Tip."""
    insertion_v: npt.NDArray[np.float64]
    """Voltage of the insertion motor."""


class Identification(NamedTuple):
    """An identification run and what was found in it."""

    calibration: Calibration
    fit: Fit
    plays: PrandtlIshlinskiiFit
    servo: ServoFit
    head_mm: npt.NDArray[np.float64]
    """Encoder, shape (n,)."""
    laser_mm: npt.NDArray[np.float64]
    """Tip, shape (n,)."""


def rig(name: str, seed: int, nominal: bool = False, patient: str = DEFAULT_PATIENT) -> Rig:
    """A machine by preset name, drawn by the seed or exactly nominal.

    patient: preset of who lies at a clinical machine; the bench has nobody.
    The seed always draws the measurement noise. Raises InputError for an unknown name.
    """
    person = None if name == "bench" else patient_kind.of_preset(patient)
    kind = machine_kind.of_preset(name, None if person is None else person.age)
    return rig_of(kind, person, seed, nominal)


def rig_of(
    kind: MachineKind,
    patient: PatientKind | None,
    seed: int,
    nominal: bool = False,
    spread: float = 1.0,
) -> Rig:
    """One machine of a kind, with a patient of a kind or (the bench) nobody; as `rig`.

    spread: how many times as far from the nominal ones as usual both are drawn.
    """
    values = parameter.nominal(kind.table) if nominal else parameter.draw(kind.table, seed, spread)
    person = None if patient is None else patient_kind.draw(patient, seed, nominal, spread)
    machine = preset.machine(values, person, kind.catheter, kind.conduit, kind.transmission)
    site = BENCH_SITE._replace(catheter_mm=kind.catheter.outer_mm)
    if person is not None:
        site = bedside(machine)
    return Rig(kind, values, machine, kind.profile, site, seed)


def bedside(machine: Machine) -> Site:
    """Site of the tip at the patient of a machine; it parks in the connector behind the tube."""
    person = machine.patient
    return Site(
        park_mm=-(person.tube_length_mm + CONNECTOR_MM),
        boundary_mm=-person.tube_length_mm,
        fast_mm_per_s=FAST_MM_PER_S,
        tube_mm=person.tube_id_mm,
        catheter_mm=machine.catheter_mm,
        carina_mm=person.carina_mm,
        age=AgeGroup(person.age_group),
        peep_cmh2o=person.ventilator.peep_cmh2o,
        monitored=person.monitor.present,
        breathes=person.behaviour.is_lively and person.behaviour.effort.per_s > 0.0,
    )


def uncalibrated(profile: MachineProfile) -> Calibration:
    """Calibration without an identification: nominal transmission, plain PD."""
    return assume_nominal(profile.transmission, PLAIN_PD)


def with_carina(chosen: Rig, carina_mm: float) -> Rig:
    """The same machine without a patient: the rubber carina at a distance from the tube's end."""
    values = {**chosen.values, "carina_mm": carina_mm}
    kind = chosen.kind
    machine = preset.machine(values, None, kind.catheter, kind.conduit, kind.transmission)
    machine = machine._replace(mouth_mm=chosen.machine.mouth_mm)
    site = chosen.site._replace(monitored=False)
    return chosen._replace(values=values, machine=machine, site=site)


def assemble(
    chosen: Rig,
    protocol: Protocol,
    kind: CompensationKind,
    calibration: Calibration,
    run: int,
    by_contact: bool = False,
) -> tuple[Loop, LoopState]:
    """Closed loop of a rig at rest after a retract, ready for a request.

    run: number of the noise stream. by_contact: stop where the contact switch closes.
    Raises InputError where the protocol cannot be done.
    """
    settings = setup.settings(chosen.profile, protocol, kind, calibration, by_contact, chosen.site)
    loop = Loop(settings, setup.branches(kind, calibration), chosen.machine)
    state = preset.park(chosen.machine, chosen.values, settings.parked.head_mm, chosen.seed, run)
    return loop, trace.power_up(loop, state, NEW_CATHETER_S)


def strokes(excitation: Excitation, inner: bool) -> tuple[Excitation, ...]:
    """Strokes of a recording: the excitation, and where ``inner`` the shorter strokes."""
    shares = INNER_STROKES if inner else ()
    shorter = [
        Excitation(
            range_mm=share * excitation.range_mm,
            period_s=share * excitation.period_s,
            duration_s=share * excitation.period_s,
        )
        for share in shares
    ]
    return (excitation, *shorter)


def excite(chosen: Rig, run: int = IDENTIFICATION_RUN, names: Sequence[str] = COLUMNS) -> Columns:
    """Trace of the identification excitation: the head over its stroke and back, twice.

    The rubber trachea is taken off: nothing is in the tip's way, and nobody's cap shortens the
    stroke. run: number of the noise stream. names: the columns that are wanted.
    """
    return _excite(chosen, run, names, inner=False)[0]


def _excite(chosen: Rig, run: int, names: Sequence[str], inner: bool) -> list[Columns]:
    """The trace of each of `strokes`."""
    chosen = with_carina(chosen, NO_CARINA_MM)
    loop, state = assemble(
        chosen, EXCITING, CompensationKind.NONE, uncalibrated(chosen.profile), run
    )
    parts = strokes(loop.controller.plan.excitation, inner)
    limit_s = parts[0].duration_s + 2.0
    # Bench: nobody is there, nor a tube with its light barrier.
    limits = loop.controller.limits._replace(
        in_airway_s=limit_s, cap_mm=NO_CARINA_MM, mouth_mm=math.inf
    )
    loop = loop._replace(controller=loop.controller._replace(limits=limits))
    state, _ = trace.record(loop, state, NO_REQUESTS, STANDING_S, ())
    traces = []
    for part in parts:
        plan = loop.controller.plan._replace(excitation=part)
        loop = loop._replace(controller=loop.controller._replace(plan=plan))
        state, columns = trace.record(loop, state, IDENTIFY, limit_s, names)
        traces.append(columns)
    return traces


def recordings(chosen: Rig, run: int, inner: bool) -> tuple[Recording, ...]:
    """Recordings of encoder, laser and motor voltage during the identification excitation.

    run: number of the noise stream. inner: go on with `INNER_STROKES`, a recording each; the first
    one is the same without. One is shorter than its part of the excitation where that was broken
    off.
    """
    names = ("phase", "readings.head_mm", "truth.laser_mm", "commands.insertion_v")
    found = []
    for columns in _excite(chosen, run, names, inner):
        during = columns["phase"] == Phase.IDENTIFYING
        found.append(Recording(*(columns[name][during] for name in names[1:])))
    return tuple(found)


def recording(chosen: Rig, run: int) -> Recording:
    """The excitation alone: see `recordings`."""
    return recordings(chosen, run, inner=False)[0]


def join(parts: Sequence[Recording]) -> Recording:
    """Recordings one after the other."""
    return Recording(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def identify(chosen: Rig, run: int = IDENTIFICATION_RUN) -> Identification:
    """Identify transmission and servo of a rig from one excitation.

    Raises InputError if the recording does not determine the model.
    """
    return fitted(recording(chosen, run), chosen.profile.supply_v)


def fitted(recorded: Recording, supply_v: float) -> Identification:
    """Transmission and servo from a recording of the excitation.

    The model's input is the encoder's head position, not the command.
    Raises InputError if the recording does not determine the model.
    """
    head, laser = recorded.head_mm, recorded.laser_mm
    found = estimator.fit(head, laser)
    plays = play_estimator.fit(head, laser)
    velocity = servo_estimator.velocity_mm_per_s(head, DT_S, VELOCITY_WINDOW_S)
    servo = servo_estimator.fit_feedforward(
        recorded.insertion_v, velocity, SLOWEST_MM_PER_S, supply_v
    )
    feedforward = Feedforward(
        velocity_v_s_per_mm=servo.velocity_v_s_per_mm, friction_v=servo.friction_v
    )
    return Identification(
        calibration=calibrated(head, laser, found, plays, feedforward),
        fit=found,
        plays=plays,
        servo=servo,
        head_mm=head,
        laser_mm=laser,
    )


def calibrated(
    head_mm: npt.NDArray[np.float64],
    laser_mm: npt.NDArray[np.float64],
    found: Fit,
    plays: PrandtlIshlinskiiFit,
    feedforward: Feedforward,
) -> Calibration:
    """Calibration for every compensator, from one recording and the two fits of it.

    Raises InputError where the recording does not show both branches of the loop.
    """
    return Calibration(
        model=found.model,
        feedforward=feedforward,
        plays=plays.model,
        width=branch_curve.fit_parallel(head_mm, laser_mm),
        table=branch_curve.fit_table(head_mm, laser_mm),
        lines=play_lines.of_prandtl_ishlinskii(plays.model),
    )
