"""Thresholds on the catheter head and its two sensors."""

import math

from docs.generator.safety.tolerance.noise import DT_S, WHITE, low_pass, share
from docs.generator.safety.tolerance.sensor_error import Errors, most
from docs.generator.safety.tolerance.threshold import Borne, Chance, Constant, Threshold
from opensuction.controller import machine_profile
from opensuction.safety.governor import judgement
from opensuction.safety.head import head_vote
from opensuction.safety.watch import bus_watch, head_watch
from opensuction.twin import parameter
from opensuction.twin.fault.fault import Fault
from opensuction.twin.parameter import SPREAD_LIMIT

PROFILE = machine_profile.CLINICAL
GOVERNOR, WATCH = "safety.governor.judgement", "safety.watch.head_watch"
CARRIAGE = ("carriage_noise_mm", "carriage_zero_mm", "carriage_sensor_mm")
LATE_MM = PROFILE.head_limit_mm_per_s * DT_S
"""Way of the head while a message is late."""


def _after(ticks: float) -> int:
    """Ticks that hold for longer than so many."""
    return math.floor(ticks + 1e-6) + 1


def _carriage(errors: Errors, beyond_mm: float = 0.0) -> Borne:
    """Both sensors apart: all the play, and half a step each of the reading and of the zero.

    The zero was learnt on one side of the play.
    """
    noise, step = errors["carriage_noise_mm"], errors["carriage_sensor_mm"]
    learnt = SPREAD_LIMIT * low_pass(head_vote.LEARN_S).ratio * noise
    static = most("gear_backlash_mm") + step + learnt + beyond_mm
    if _home(errors).static > head_vote.MOST_MM:
        static += errors["carriage_zero_mm"]
    return Borne(static=static, sigma=noise)


def _home(errors: Errors) -> Borne:
    """The zero as it is read at home, where the head lies on one side of the play."""
    side = 0.5 * (most("gear_backlash_mm") + errors["carriage_sensor_mm"])
    return Borne(errors["carriage_zero_mm"] + side, errors["carriage_noise_mm"])


def _apart(
    constants: tuple[Constant, ...],
    compared: str,
    margin: float,
    beyond_mm: float,
    ticks: int,
    simulated: str,
) -> Threshold:
    return Threshold(
        constants,
        compared,
        "mm",
        margin,
        lambda errors: _carriage(errors, beyond_mm),
        "all the play, step of reading and zero" + (", a late message" if beyond_mm else ""),
        CARRIAGE,
        Chance.EVEN,
        WHITE,
        ticks,
        (Fault.ENCODER_OFFSET, Fault.GEAR_LOST, Fault.GEAR_WORN, Fault.CARRIAGE_SENSOR_FROZEN),
        ticks * DT_S,
        simulated,
    )


def _late(
    constants: tuple[Constant, ...],
    compared: str,
    because: str,
    ticks: int,
    faults: tuple[Fault, ...],
    takes_s: float,
) -> Threshold:
    """What only so many late messages in a row reach."""
    return Threshold(
        constants,
        compared,
        "ticks",
        float(ticks),
        lambda _: Borne(1.0, 0.0),
        because,
        ("late_share",),
        Chance.LATE,
        WHITE,
        ticks,
        faults,
        takes_s,
    )


def _overspeed() -> Threshold:
    limit = PROFILE.head_limit_mm_per_s
    leap = share(head_watch.SPEED_WINDOW_S) * (limit + parameter.CLINICAL["head_encoder_mm"].value)
    return Threshold(
        ((WATCH, "OVERSPEED_RATIO"), (GOVERNOR, "OVERSPEED_TICKS")),
        f"averaged head speed over its limit of {limit:g} mm/s",
        "mm/s",
        (head_watch.OVERSPEED_RATIO - 1.0) * limit,
        lambda _: Borne(leap, 0.0),
        "a message that is late brings two ticks' way at once",
        ("late_share",),
        Chance.NONE,
        WHITE,
        judgement.OVERSPEED_TICKS,
        (Fault.ENCODER_JUMPING, Fault.ENCODER_NOISY),
        judgement.OVERSPEED_TICKS * DT_S + head_watch.SPEED_WINDOW_S,
    )


def _runaway() -> Threshold:
    return Threshold(
        ((WATCH, "RUNAWAY_SUCKING_MM"), (GOVERNOR, "RUNAWAY_TICKS")),
        "head further in than its command, valve open",
        "mm",
        head_watch.RUNAWAY_SUCKING_MM,
        lambda _: Borne(LATE_MM, 0.0),
        "a message that is late, at full speed; the servo's own ripple is not counted",
        ("late_share",),
        Chance.NONE,
        WHITE,
        judgement.RUNAWAY_TICKS,
        (Fault.MOTOR_REVERSED, Fault.ENCODER_REVERSED),
        judgement.RUNAWAY_TICKS * DT_S,
    )


def _sensors() -> list[Threshold]:
    sucking = _after(judgement.DISAGREE_SUCKING_S / DT_S)
    disagree = _after(judgement.DISAGREE_S / DT_S)
    home = Threshold(
        (("safety.head.head_vote", "MOST_MM"),),
        "zero of the second sensor at home, up to which it is learnt",
        "mm",
        head_vote.MOST_MM,
        _home,
        "mounting, half of the play, half a step",
        CARRIAGE,
        Chance.EVEN,
        WHITE,
        1,
        (Fault.ENCODER_OFFSET,),
        head_vote.STILL_TICKS * DT_S + head_vote.LEARN_S,
    )
    return [
        _apart(
            ((WATCH, "APART_MM"), (GOVERNOR, "DISAGREE_S")),
            "motor and catheter head apart, valve closed",
            head_watch.APART_MM,
            0.0,
            disagree,
            "head",
        ),
        _apart(
            ((WATCH, "APART_SUCKING_MM"), (GOVERNOR, "DISAGREE_SUCKING_S")),
            "motor and catheter head apart, valve open",
            head_watch.APART_SUCKING_MM,
            0.0,
            sucking,
            "head, sucking",
        ),
        _apart(
            (("safety.head.head_vote", "CARRIAGE_MM"),),
            f"the same in a single tick, at {PROFILE.head_limit_mm_per_s:g} mm/s",
            head_vote.CARRIAGE_MM,
            LATE_MM,
            1,
            "",
        ),
        home,
    ]


def _lateness() -> list[Threshold]:
    leaps = math.floor(head_vote.JUMP_MM / LATE_MM)
    odd = head_vote.OUT_TICKS // head_vote.BAD_TICKS
    repeated = (Fault.READING_REPEATED, Fault.READING_LATE)
    stale = bus_watch.STALE_TICKS
    return [
        _late(
            (("safety.head.head_vote", "JUMP_MM"), ("safety.head.head_vote", "OUT_TICKS")),
            f"encoder off its expected place, at {PROFILE.head_limit_mm_per_s:g} mm/s",
            f"{leaps} late in a row are {leaps * LATE_MM:.3f} mm; {odd} odd ticks more",
            leaps + odd,
            (Fault.ENCODER_JUMPING, Fault.ENCODER_ALTERNATING),
            odd * DT_S,
        ),
        _late(
            (("controller.machine_profile", "CLINICAL.stalled_mm"), (GOVERNOR, "STALL_S")),
            "head that stands still, off its command",
            "the same value again, by late messages of the drive",
            _after(judgement.STALL_S / DT_S),
            (Fault.MOTOR_STALLED, Fault.ENCODER_FROZEN),
            judgement.STALL_S,
        ),
        _late(
            (("safety.watch.bus_watch", "STALE_TICKS"),),
            "all sensors repeat themselves on a withdrawal",
            "the same message of both nodes again; one is counted",
            stale,
            repeated,
            stale * DT_S,
        ),
        _late(
            (("safety.watch.bus_watch", "DEAD_TICKS"),),
            "all sensors repeat themselves, the head at rest",
            "the same message of both nodes again; one is counted, and noise must have been there",
            bus_watch.DEAD_TICKS,
            repeated,
            bus_watch.DEAD_TICKS * DT_S,
        ),
        _overspeed(),
        _runaway(),
    ]


def thresholds() -> list[Threshold]:
    """Both sensors against one another; lateness."""
    return _sensors() + _lateness()
