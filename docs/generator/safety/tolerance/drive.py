"""Thresholds on the insertion motor's current: forces, and the motor as a sensor of the head."""

import math
from typing import NamedTuple

from docs.generator.safety.tolerance.line import SINCE_VENTED_S
from docs.generator.safety.tolerance.noise import DT_S, Filter, low_pass, share
from docs.generator.safety.tolerance.sensor_error import Errors
from docs.generator.safety.tolerance.threshold import Borne, Chance, Threshold
from opensuction.controller import machine_profile
from opensuction.controller.governor_limit import FORCE_MARGIN
from opensuction.controller.machine_profile import MachineProfile
from opensuction.procedure.planning.clinical import PAEDIATRIC
from opensuction.safety.governor import judgement
from opensuction.safety.head import drive_force, head_vote
from opensuction.safety.watch import head_watch, tip_force
from opensuction.twin import parameter
from opensuction.twin.fault.fault import Fault
from opensuction.twin.parameter import SPREAD_LIMIT
from opensuction.twin.parameter_row import Parameter
from opensuction.twin.preset import load_v_per_n
from opensuction.twin.sensor.sensor import DRIFT_S

PROFILE = machine_profile.CLINICAL
GOVERNOR, WATCH = "safety.governor.judgement", "safety.watch.head_watch"
CURRENT = (
    "current_noise_a",
    "current_offset_a",
    "current_drift_a",
    "current_gain",
    "current_step_a",
)
FORCE = low_pass(head_watch.SPEED_WINDOW_S)
RESISTANCE = low_pass(head_watch.SPEED_WINDOW_S, drive_force.SETTLING_S)
LEAD = low_pass(head_vote.FORGET_S)
PRESSED = low_pass(head_watch.SPEED_WINDOW_S, drive_force.SETTLING_S, tip_force.FORCE_S)
INSERTION_MM_PER_S = PAEDIATRIC.insertion_mm_per_s
MM_PER_M = 1000.0


class _Drive(NamedTuple):
    """An insertion drive as it is, and as its controller knows it."""

    name: str
    preset: str
    table: dict[str, Parameter]
    profile: MachineProfile

    def most(self, name: str) -> float:
        return self.table[name].value + SPREAD_LIMIT * self.table[name].spread

    def volts_per_n(self) -> float:
        return load_v_per_n({name: row.value for name, row in self.table.items()})


_BEDSIDE = _Drive("bedside", "CLINICAL", parameter.CLINICAL, machine_profile.CLINICAL)
_BENCH = _Drive("bench", "BENCH", parameter.BENCH, machine_profile.BENCH)
TIP_N = 0.3
"""Highest force at the tip [computed]."""


def _ratio(drive: _Drive, errors: Errors) -> float:
    """Newtons that are read for each: more current for each than told, and the sensor's gain."""
    told = drive.profile.newton_per_a * drive.most("drive_a_per_n")
    return told * (1.0 + errors["current_gain"])


def _current_left(drive: _Drive, errors: Errors) -> float:
    """Offset of the current, A, that is left once the drive has stood still.

    It has drifted since; and what a servo pulls at rest, up to friction, is taken for what its
    volts drive through a winding that is not as it is told.
    """
    wandered = math.sqrt(2.0 * (1.0 - math.exp(-SINCE_VENTED_S / DRIFT_S)))
    learnt = low_pass(drive_force.OFFSET_S).ratio * errors["current_noise_a"]
    drift = errors["current_drift_a"]
    random = SPREAD_LIMIT * (drift * wandered + learnt) + 0.5 * errors["current_step_a"]
    resting_a = drive.most("insertion_friction_v") / drive.profile.winding_v_per_a
    return random + resting_a * (_ratio(drive, errors) - 1.0)


def _force(drive: _Drive, force_n: float, errors: Errors, behind: Filter) -> Borne:
    """A force as it is read at most, less what an ideal sensor would read of it."""
    per_a = drive.profile.newton_per_a
    return Borne(
        static=force_n * (_ratio(drive, errors) - 1.0) + per_a * _current_left(drive, errors),
        sigma=behind.ratio * per_a * errors["current_noise_a"],
    )


def _step_n(drive: _Drive) -> float:
    """What a step of the encoder is taken for."""
    mass = drive.profile.moving_mass_kg / (MM_PER_M * drive_force.SETTLING_S)
    step = drive.table["head_encoder_mm"].value
    return mass * share(head_watch.SPEED_WINDOW_S) * step / DT_S


def _resist(drive: _Drive, errors: Errors) -> Borne:
    friction = drive.most("insertion_friction_v") / drive.volts_per_n()
    nominal = drive.table["insertion_friction_v"].value / drive.volts_per_n()
    read = _force(drive, friction + TIP_N, errors, RESISTANCE)
    return read._replace(static=read.static + friction + TIP_N - nominal + _step_n(drive))


def _pull(drive: _Drive, errors: Errors) -> Borne:
    limit = drive.most("drive_force_n")
    read = _force(drive, limit, errors, FORCE)
    return read._replace(static=read.static + limit - drive.profile.drive_force_n)


def _drive_rows(drive: _Drive) -> list[Threshold]:
    nominal = drive.table["insertion_friction_v"].value / drive.volts_per_n()
    window_s = head_watch.SPEED_WINDOW_S
    return [
        Threshold(
            (("controller.machine_profile", f"{drive.preset}.jam_n"), (GOVERNOR, "JAM_S")),
            f"resistance over nominal friction, {drive.name}",
            "N",
            drive.profile.jam_n - nominal,
            lambda errors: _resist(drive, errors),
            "stiffest friction and the tip, force for an ampere, gain, offset with what it was "
            "learnt wrong by, encoder's step; not counted: the motor's volts must bear it out",
            CURRENT,
            Chance.FILTERED,
            RESISTANCE,
            1,
            (Fault.CATHETER_JAMMED,),
            judgement.JAM_S + window_s + drive_force.SETTLING_S,
            f"jam, {drive.name}",
        ),
        Threshold(
            (("controller.governor_limit", "FORCE_MARGIN"), (GOVERNOR, "OVERFORCE_S")),
            f"force over the drive's own current limit, {drive.name}",
            "N",
            (FORCE_MARGIN - 1.0) * drive.profile.drive_force_n,
            lambda errors: _pull(drive, errors),
            "highest limit, force for an ampere, gain, offset as above; only while the limit rules",
            CURRENT,
            Chance.FILTERED,
            FORCE,
            1,
            (Fault.CURRENT_OFFSET, Fault.CURRENT_NOISY),
            judgement.OVERFORCE_S + window_s,
            f"force, {drive.name}",
        ),
        Threshold(
            (("safety.head.drive_force", "SLACK_N"),),
            f"force of a motor without current: whether a runaway only coasts, {drive.name}",
            "N",
            drive_force.SLACK_N,
            lambda errors: _force(drive, 0.0, errors, FORCE),
            "offset as above; beyond it one that coasts is taken for pushed",
            CURRENT,
            Chance.FILTERED,
            FORCE,
            1,
            (Fault.MOTOR_LOST,),
            window_s,
        ),
    ]


def _pressed(drive: _Drive, errors: Errors) -> Borne:
    """What the current makes of no force: offset, gain and friction are in what was learnt, too."""
    per_a = drive.profile.newton_per_a
    drifting = errors["current_drift_a"] * math.sqrt(2.0 * tip_force.FREE_S / DRIFT_S)
    random = math.hypot(PRESSED.ratio * errors["current_noise_a"], drifting)
    return Borne(static=per_a * errors["current_step_a"], sigma=per_a * random)


def _pressing(drive: _Drive) -> Threshold:
    return Threshold(
        (("safety.watch.tip_force", "PRESSED_N"), ("safety.watch.tip_force", "PRESSED_S")),
        f"force at the tip by the current, {drive.name}",
        "N",
        tip_force.PRESSED_N,
        lambda errors: _pressed(drive, errors),
        "a step of the current sensor, its drift over a second; not counted: the motor's volts "
        "must bear it out",
        CURRENT,
        Chance.FILTERED,
        PRESSED,
        1,
        (Fault.SWITCH_STUCK_OPEN, Fault.SWITCH_STIFF),
        tip_force.PRESSED_S + drive_force.SETTLING_S + tip_force.FORCE_S,
    )


def _motor_lead(drive: _Drive, errors: Errors) -> Borne:
    """What head and motor model are apart by, over `FORGET_S` at the speed of insertion."""
    profile = drive.profile
    per_a = profile.no_load_mm_per_s / profile.supply_v * profile.winding_v_per_a
    friction_a = drive.most("insertion_friction_v") / profile.winding_v_per_a
    current = friction_a * (_ratio(drive, errors) - 1.0) + _current_left(drive, errors)
    faster = drive.most("no_load_mm_per_s") / profile.no_load_mm_per_s - 1.0
    allowed = head_watch.MODEL_LAG_S * INSERTION_MM_PER_S
    static = head_vote.FORGET_S * (faster * INSERTION_MM_PER_S + per_a * current) - allowed
    sigma = head_vote.FORGET_S * per_a * LEAD.ratio * errors["current_noise_a"]
    return Borne(static + drive.table["head_encoder_mm"].value, sigma)


def _adrift(drive: _Drive) -> Threshold:
    return Threshold(
        ((WATCH, "ADRIFT_MM"), (GOVERNOR, "ADRIFT_S")),
        f"both sensors' way beyond the motor's over .3 s, at {INSERTION_MM_PER_S:g} mm/s, "
        f"{drive.name}",
        "mm",
        head_watch.ADRIFT_MM,
        lambda errors: _motor_lead(drive, errors),
        "a faster motor (less `MODEL_LAG_S`), current for its friction, offset, encoder's step",
        CURRENT,
        Chance.FILTERED,
        LEAD,
        1,
        (Fault.HEAD_SENSORS_DRIFTING,),
        judgement.ADRIFT_S + head_vote.FORGET_S,
    )


def thresholds() -> list[Threshold]:
    """The motor as a sensor; forces on either machine."""
    return [
        _adrift(_BEDSIDE),
        _adrift(_BENCH),
        *_drive_rows(_BEDSIDE),
        *_drive_rows(_BENCH),
        _pressing(_BEDSIDE),
    ]
