"""Runs on one machine: identification with the laser, then automated cycles."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.controller.setup import Calibration, Feedforward, MachineProfile
from opensuction.hysteresis import modified_dahl
from opensuction.identification import modified_dahl as estimator
from opensuction.identification import servo as servo_estimator
from opensuction.identification.modified_dahl import Fit
from opensuction.identification.servo import ServoFit
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import IDENTIFY
from opensuction.procedure.protocol import PAPER, Protocol
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns
from opensuction.twin import parameter, preset
from opensuction.twin.machine import Machine

VELOCITY_WINDOW_S = 0.05
"""Window of the velocity estimate for the servo fit."""
SLOWEST_MM_PER_S = 2.0
"""Slower samples say little about the servo."""
IDENTIFICATION_RUN = 1
"""Number of the noise stream of identification runs; cycles use others."""


class Rig(NamedTuple):
    """One machine of the twin: its parameters, its records and how its controller knows it."""

    values: dict[str, float]
    machine: Machine
    profile: MachineProfile
    seed: int


class Identification(NamedTuple):
    """An identification run and what was found in it."""

    calibration: Calibration
    fit: Fit
    servo: ServoFit
    head_mm: npt.NDArray[np.float64]
    """Encoder, shape (n,)."""
    laser_mm: npt.NDArray[np.float64]
    """Tip, shape (n,)."""


def rig(name: str, seed: int, nominal: bool = False) -> Rig:
    """A machine by preset name, drawn by the seed or exactly nominal.

    The seed always draws the measurement noise. Raises InputError for an unknown name.
    """
    if name not in preset.TABLES:
        known = ", ".join(sorted(preset.TABLES))
        raise InputError(f"machine '{name}' is not known: one of {known}")
    table = preset.TABLES[name]
    values = parameter.nominal(table) if nominal else parameter.drawn(table, seed)
    return Rig(values=values, machine=preset.machine(values), profile=setup.BENCH, seed=seed)


def uncalibrated(profile: MachineProfile) -> Calibration:
    """What is known without an identification: nominal transmission, plain PD."""
    return Calibration(model=profile.transmission, feedforward=setup.PLAIN_PD)


def assemble(
    chosen: Rig, protocol: Protocol, kind: CompensationKind, calibration: Calibration, run: int
) -> tuple[Loop, LoopState]:
    """Closed loop of a rig at rest after a retract, ready for a request.

    run: number of the noise stream. Raises InputError where the protocol cannot be done.
    """
    settings = setup.settings(chosen.profile, protocol, kind, calibration)
    loop = Loop(controller=settings, machine=chosen.machine)
    state = preset.parked(chosen.machine, chosen.values, settings.parked.head_mm, chosen.seed, run)
    return loop, trace.power_up(loop, state)


def excite(chosen: Rig, run: int = IDENTIFICATION_RUN) -> Columns:
    """Trace of the identification excitation: head 0 to 100 mm and back, twice in 40 s."""
    loop, state = assemble(chosen, PAPER, CompensationKind.NONE, uncalibrated(chosen.profile), run)
    limit_s = loop.controller.plan.excitation.duration_s + 2.0
    limits = loop.controller.limits._replace(in_airway_s=limit_s)  # bench: nobody is there
    loop = loop._replace(controller=loop.controller._replace(limits=limits))
    _, columns = trace.record(loop, state, IDENTIFY, limit_s)
    return columns


def identify(chosen: Rig, run: int = IDENTIFICATION_RUN) -> Identification:
    """Identify transmission and servo of a rig from one excitation.

    The model's input is the encoder's head position, not the command.
    Raises InputError if the recording does not determine the model.
    """
    columns = excite(chosen, run)
    during = columns["phase"] == Phase.IDENTIFYING
    head = columns["readings.head_mm"][during]
    laser = columns["truth.laser_mm"][during]
    found = estimator.fit(head, laser)
    velocity = servo_estimator.velocity_mm_per_s(head, DT_S, VELOCITY_WINDOW_S)
    servo = servo_estimator.fit_feedforward(
        columns["commands.insertion_v"][during],
        velocity,
        SLOWEST_MM_PER_S,
        chosen.profile.supply_v,
    )
    return Identification(
        calibration=Calibration(
            model=found.model,
            feedforward=Feedforward(
                velocity_v_s_per_mm=servo.velocity_v_s_per_mm, friction_v=servo.friction_v
            ),
        ),
        fit=found,
        servo=servo,
        head_mm=head,
        laser_mm=laser,
    )


def gap_mm(identification: Identification) -> float:
    """Full gap of an identified transmission, mm of tip."""
    return float(modified_dahl.gap_mm(identification.fit.model))
