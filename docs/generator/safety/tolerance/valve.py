"""Thresholds on the cam of the suction valve."""

import math

from docs.generator.safety.tolerance.noise import DT_S, WHITE
from docs.generator.safety.tolerance.sensor_error import Errors, most
from docs.generator.safety.tolerance.threshold import Borne, Chance, Constant, Threshold
from opensuction.controller.machine_profile import CLINICAL as PROFILE
from opensuction.procedure.cycle import progress
from opensuction.safety.watch import valve_axis
from opensuction.twin.fault.fault import Fault

CAM = ("cam_noise_rad", "cam_zero_rad", "cam_encoder_rad")
WATCH, PROGRESS = "safety.watch.valve_axis", "procedure.cycle.progress"
OVERDUE_S = (
    valve_axis.OVERDUE_SHARE * PROFILE.cam_open_rad / PROFILE.cam_rad_per_s + valve_axis.SETTLE_S
)


def _cam(errors: Errors, beyond: float) -> Borne:
    static = errors["cam_zero_rad"] + 0.5 * errors["cam_encoder_rad"] + beyond
    return Borne(static, errors["cam_noise_rad"])


def _settled_rad() -> float:
    """How far from its command the servo leaves the open cam, against spring and friction."""
    spring = most("spring_preload_v") + most("spring_v_per_rad") * PROFILE.cam_open_rad
    return (spring + most("valve_friction_v")) / PROFILE.valve_p_v_per_rad


def _row(
    constants: tuple[Constant, ...],
    compared: str,
    margin: float,
    beyond: float,
    because: str,
    fault: Fault,
    simulated: str = "",
) -> Threshold:
    return Threshold(
        constants,
        compared,
        "rad",
        margin,
        lambda errors: _cam(errors, beyond),
        because,
        CAM,
        Chance.EVEN,
        WHITE,
        math.floor(valve_axis.STILL_S / DT_S) + 1 if constants[0][0] == WATCH else 1,
        (fault, Fault.CAM_ENCODER_OFFSET),
        valve_axis.STILL_S if constants[0][0] == WATCH else OVERDUE_S,
        simulated,
    )


def _missed(errors: Errors) -> Borne:
    """A seized cam: the reading that it is held against has noise of its own."""
    noise = errors["cam_noise_rad"]
    return Borne(math.sqrt(3.0) * noise + errors["cam_encoder_rad"], noise)


def thresholds() -> list[Threshold]:
    """Closed, behind closed, open; and whether one that is seized can be told at once."""
    stop, open_rad = most("cam_stop_rad"), PROFILE.cam_open_rad
    zero, servo = "zero, half a step", "zero, half a step, what the servo leaves"
    behind = "end stop, zero, half a step"
    still = _row(
        ((WATCH, "STILL_RAD"), (WATCH, "STILL_S")),
        "a seized cam's reading, which must look still; missed, it is told as overdue in "
        f"{OVERDUE_S:.2f} s",
        valve_axis.STILL_RAD,
        0.0,
        "noise of the reading that it is held against, a step",
        Fault.VALVE_JAMMED,
    )
    return [
        _row(
            ((WATCH, "CLOSED_RAD"), (WATCH, "STILL_S")),
            "closed cam",
            valve_axis.CLOSED_RAD,
            0.0,
            zero,
            Fault.VALVE_JAMMED,
            "cam",
        ),
        _row(
            ((PROGRESS, "CLOSED_SHARE"),),
            "the same, before the cycle goes on",
            progress.CLOSED_SHARE * open_rad,
            0.0,
            zero,
            Fault.VALVE_SLOW,
        ),
        _row(
            ((WATCH, "BEHIND_RAD"), (WATCH, "STILL_S")),
            "cam on its end stop",
            valve_axis.BEHIND_RAD,
            stop,
            behind,
            Fault.VALVE_JAMMED,
            "cam",
        ),
        _row(
            ((PROGRESS, "BEHIND_SHARE"),),
            "the same, before the cycle goes on",
            progress.BEHIND_SHARE * open_rad,
            stop,
            behind,
            Fault.VALVE_SLOW,
        ),
        _row(
            ((WATCH, "OPEN_SHARE"), (WATCH, "STILL_S")),
            "open cam",
            (1.0 - valve_axis.OPEN_SHARE) * open_rad,
            _settled_rad(),
            servo,
            Fault.VALVE_JAMMED,
            "cam",
        ),
        _row(
            ((PROGRESS, "OPEN_SHARE"),),
            "the same, before the cycle goes on",
            (1.0 - progress.OPEN_SHARE) * open_rad,
            _settled_rad(),
            servo,
            Fault.VALVE_SLOW,
        ),
        still._replace(bear=_missed, errors=("cam_noise_rad", "cam_encoder_rad"), ticks=1),
    ]
