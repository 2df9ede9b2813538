"""Ranges of numbers for the proofs that none of them grows into an infinity.

Settings: the range of a machine file, and orders of magnitude beyond any machine. State: the range
that the proofs show to be kept from tick to tick.
"""

from typing import Any

import z3

from opensuction.control.servo import Servo, ValveMotion
from opensuction.controller.record import CoreState, Settings
from opensuction.kernel.interface import LARGEST
from opensuction.safety.governor.governor import GovernorState
from opensuction.safety.head.head_vote import OUT_TICKS, SURPRISED_TICKS, HeadVote
from opensuction.safety.invalid_ticks import INVALID_TICKS
from opensuction.safety.limits import Limits
from opensuction.safety.watch.watch_state import Watch
from tests.proof.claim import all_of, between, bounded, is_finite, within
from tools.proof.arithmetic import Doubles
from tools.proof.logic import as_integer, lift_truth
from tools.proof.unknown import free

DT_S = 0.001
"""The tick of every machine here."""

SETTINGS: dict[str, float | tuple[float, float]] = {
    "tip.gain": (1e-3, 1e3),
    "drive.mm_per_s_per_v": (1e-6, 100.0),
    "drive.supply_v": (0.0, 100.0),
    "drive.volts_per_a": (1e-6, 1e6),
    "drive.newton_per_a": (1e-6, 1e6),
    "limits.leaving_mm_per_s": (1e-6, 1e4),
    "limits.head_mm_per_s2": (1e-6, 1e6),
    "limits.head_speed_mm_per_s": (1e-6, 1e4),
    "limits.vacuum_mmhg": (0.0, 1e6),
    "limits.withdrawal_s": (0.0, 1e6),
    "valve_motion.open_rad": (0.0, 1e3),
    "valve_motion.speed_rad_per_s": (0.0, 1e6),
    "back_emf_v_s": (0.0, 1e6),
    "catch_up_v": (0.0, 1e6),
    "voltage_limit_v": (0.0, 1e6),
}
"""Signs that the arithmetic relies on; `controller.record` refuses others."""
ANY_SETTING = (-1e6, 1e6)

MOTOR_MM_PER_S = 1.0e4
"""Fastest motor of these settings: 100 mm/s for each volt, 100 V."""
DRIFT_MM = 60.0
"""Furthest that a head goes on by its motor alone before a sensor is asked again: 5 ticks."""
SOUND_MM = LARGEST + 2.0
"""A head that a sensor has, within what one is ridden out and the zero of the second one."""
SPEED_MM_PER_S = 3.2e9
"""Fastest average: a head found at the other end of what a sensor can tell, in a tick."""
HEAD_MM = SOUND_MM + 5.1 * SPEED_MM_PER_S * DT_S
"""A head that went on by such a speed until its sensor was found odd."""
MOST_WAY = 3 * (SURPRISED_TICKS - 1) + 2 * (OUT_TICKS + 6)
ZERO_MM = 1.0
"""Zero of the second sensor: `home_zero.MOST_MM` and more."""
MOST_HEAD_MM = HEAD_MM + MOST_WAY * DRIFT_MM
COMMAND_MM = 1.0e15
"""A command may run ahead of its head by what its speed allows in 2,500 years of ticks."""
GROWTH_MM = 20.0
"""By which it grows in a tick at most, rounding included."""
CAM_SLACK_RAD = "0.000000001"
"""Rounding of a cam that has arrived."""


def setting(doubles: Doubles, kind: Any, name: str) -> Any:
    """Settings within these bounds."""
    return free(doubles, kind, name, bounded(doubles, {**SETTINGS, name: ANY_SETTING}, True))


def unknown_settings(doubles: Doubles, **others: Any) -> Settings:
    """Settings of which only what moves anything is there."""
    return Settings(
        plan=others.get("plan"),  # type: ignore[arg-type]
        service=None,  # type: ignore[arg-type]
        compensation=None,  # type: ignore[arg-type]
        parked=None,  # type: ignore[arg-type]
        insertion_servo=setting(doubles, Servo, "insertion_servo"),
        valve_servo=setting(doubles, Servo, "valve_servo"),
        valve_motion=setting(doubles, ValveMotion, "valve_motion"),
        limits=setting(doubles, Limits, "limits"),
        alarms=None,  # type: ignore[arg-type]
    )


def _spent(vote: HeadVote) -> z3.ArithRef:
    """How much of its free way a head has gone, in ticks: it grows with each, and is limited."""
    odd = as_integer(vote.encoder_odd)
    odd = z3.If(odd == OUT_TICKS, OUT_TICKS + 6, odd)
    return 3 * as_integer(vote.surprised_ticks) + z3.If(lift_truth(vote.encoder_out), 0, 2 * odd)


def _is_within(doubles: Doubles, value: Any, size: z3.ArithRef) -> z3.BoolRef:
    finite = is_finite(doubles, value)
    return all_of(finite, value.real <= size, value.real >= -size)


def vote_is_kept(doubles: Doubles, vote: HeadVote) -> z3.BoolRef:
    """What holds of the vote's numbers, from tick to tick.

    A head that no sensor bears out goes on by its speed, until one is believed or voted out: by
    the averaged one in the first such tick, by the motor's in all others.
    """
    unseen_ticks, odd = as_integer(vote.unseen_ticks), as_integer(vote.encoder_odd)
    surprised = as_integer(vote.surprised_ticks)
    unseen = unseen_ticks >= INVALID_TICKS
    calm = z3.And(odd + surprised < SURPRISED_TICKS, z3.Not(unseen))
    calm_mm = z3.RealVal(SOUND_MM) + z3.RealVal(DRIFT_MM) * z3.ToReal(surprised)
    way = z3.If(unseen, MOST_WAY, _spent(vote))
    way_mm = z3.RealVal(HEAD_MM) + z3.RealVal(DRIFT_MM) * z3.ToReal(way)
    return all_of(
        unseen_ticks >= 0,
        odd >= 0,
        odd <= OUT_TICKS,
        surprised >= 0,
        surprised < SURPRISED_TICKS,
        within(doubles, vote.encoder_mm, LARGEST),
        within(doubles, vote.carriage_mm, LARGEST + 1.1 * ZERO_MM),
        within(doubles, vote.zero_mm, ZERO_MM),
        within(doubles, vote.motor_mm_per_s, MOTOR_MM_PER_S * 1.000001),
        z3.Implies(calm, _is_within(doubles, vote.head_mm, calm_mm)),
        _is_within(doubles, vote.head_mm, way_mm),
    )


def speed_is_kept(doubles: Doubles, vote: HeadVote, speed_mm_per_s: Any) -> z3.BoolRef:
    """The averaged speed's bound: rounding may raise it only while nothing goes on by it."""
    seen = as_integer(vote.unseen_ticks) < INVALID_TICKS
    sound = z3.And(as_integer(vote.encoder_odd) == 0, seen)
    fastest = z3.If(sound, z3.RealVal(1), z3.RealVal("1.000001"))
    return _is_within(doubles, speed_mm_per_s, fastest * z3.RealVal(SPEED_MM_PER_S))


def tip_is_kept(doubles: Doubles, seen: Watch) -> z3.BoolRef:
    """Bounds of cam, tip and where suction began."""
    return all_of(
        within(doubles, seen.cam_rad, LARGEST),
        within(doubles, seen.tip.foremost_mm, 1e9),
        within(doubles, seen.tip.rearmost_mm, 1e9),
        within(doubles, seen.suction_start_mm, MOST_HEAD_MM),
    )


def watch_is_kept(doubles: Doubles, seen: Watch) -> z3.BoolRef:
    """What holds of all that is seen, as far as a command depends on it."""
    at_vote = all_of(seen.head_mm.real == seen.vote.head_mm.real, is_finite(doubles, seen.head_mm))
    speed = speed_is_kept(doubles, seen.vote, seen.speed_mm_per_s)
    cam = as_integer(seen.invalid.cam) >= 0
    return all_of(at_vote, vote_is_kept(doubles, seen.vote), speed, cam, tip_is_kept(doubles, seen))


def core_is_kept(
    doubles: Doubles, settings: Settings, core: CoreState, command_mm: float = COMMAND_MM
) -> z3.BoolRef:
    """What holds of the controller's state, as far as a command depends on it."""
    last = core.governor.last
    return all_of(
        watch_is_kept(doubles, core.governor.watch),
        within(doubles, last.head_mm, command_mm),
        within(doubles, last.head_mm_per_s, 1e20),
        within(doubles, core.insertion_servo.error, 1e18),
        within(doubles, core.insertion_servo.velocity, 1e20),
        within(doubles, core.valve_servo.error, 1e18),
        within(doubles, core.valve_servo.velocity, 1e20),
        within(doubles, core.driven_v, 1e6),
        cam_is_kept(doubles, settings.valve_motion, core.cam_rad),
    )


def cam_is_kept(doubles: Doubles, motion: ValveMotion, cam_rad: Any) -> z3.BoolRef:
    """Between closed and open."""
    far = cam_rad.real <= motion.open_rad.real + z3.RealVal(CAM_SLACK_RAD)
    return all_of(between(doubles, 0.0, cam_rad, 2e3), far)


def divisors() -> list[float]:
    """Durations of one to six ticks, by which ways are divided."""
    return [DT_S * ticks * (1.0 - 1e-9) for ticks in range(1, INVALID_TICKS + 2)]


KEPT_SIZES: dict[str, float | tuple[float, float]] = {
    "vote.head_mm": MOST_HEAD_MM,
    "watch.head_mm": MOST_HEAD_MM,
    "vote.encoder_mm": LARGEST,
    "vote.carriage_mm": LARGEST + 1.1 * ZERO_MM,
    "vote.zero_mm": ZERO_MM,
    "vote.motor_mm_per_s": MOTOR_MM_PER_S * 1.000001,
    "speed_mm_per_s": SPEED_MM_PER_S * 1.000001,
    "watch.cam_rad": LARGEST,
    "tip.foremost_mm": 1e9,
    "tip.rearmost_mm": 1e9,
    "suction_start_mm": MOST_HEAD_MM,
    "last.head_mm": COMMAND_MM,
    "last.head_mm_per_s": 1e20,
    "insertion_servo.error": 1e18,
    "insertion_servo.velocity": 1e20,
    "valve_servo.error": 1e18,
    "valve_servo.velocity": 1e20,
    "core.driven_v": 1e6,
    "core.cam_rad": 2e3,
}
"""The same as plain sizes: what is not named here may be any double, not a number too."""


def unknown_state(doubles: Doubles) -> GovernorState:
    """A governor's state in which these numbers are bounded, and all others anything."""
    state: GovernorState = free(doubles, GovernorState, "governor", bounded(doubles, KEPT_SIZES))
    return state


def move_is_told(
    doubles: Doubles, before: HeadVote, speed_mm_per_s: Any, vote: HeadVote
) -> z3.BoolRef:
    """How far the head moves in a tick other than what the vote says that it jumped.

    Not at all where no sensor tells, nor where one took the other's place; by what lies between two
    readings where it was found again or has travelled; else by the speed that was expected.
    """
    bounds = within(doubles, vote.head_mm, MOST_HEAD_MM), within(doubles, vote.jumped_mm, 1e8)
    moved = vote.head_mm.real - before.head_mm.real - vote.jumped_mm.real
    unseen, odd = as_integer(before.unseen_ticks), as_integer(before.encoder_odd)
    told, odd_now = as_integer(vote.unseen_ticks) == 0, as_integer(vote.encoder_odd)

    def by(size: Any) -> z3.BoolRef:
        size = z3.RealVal(size) if isinstance(size, float) else size
        return z3.And(moved <= size, moved >= -size)

    expected = []
    for ticks in range(1, INVALID_TICKS + 1):
        way = z3.RealVal(DT_S * ticks * 1.000001)
        speed = z3.If(speed_mm_per_s.real >= 0, speed_mm_per_s.real, -speed_mm_per_s.real)
        averaged = all_of(odd == 0, odd_now > 0, by(speed * way + z3.RealVal("0.00001")))
        by_motor = by(MOTOR_MM_PER_S * DT_S * ticks * 1.01)
        expected.append(z3.And(unseen == ticks - 1, z3.Or(averaged, by_motor)))
    travelled = z3.And(odd == 0, by(2.0 * LARGEST + 200.0))
    found = z3.And(unseen >= INVALID_TICKS, by(LARGEST + 1.1 * ZERO_MM + MOST_HEAD_MM))
    return all_of(
        *bounds,
        z3.Implies(z3.Not(told), by(0.00001)),
        z3.Implies(told, z3.Or(by(0.00001), found, travelled, *expected)),
    )
