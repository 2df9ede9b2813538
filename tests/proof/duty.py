"""Contracts by which only numbers reach a command: what each callee asks for and gives."""

from typing import Any

import z3

from opensuction.control import servo
from opensuction.control.servo import Servo, ServoState, ValveMotion
from opensuction.kernel.interface import LARGEST, Readings, Setpoints
from opensuction.safety.condition import Condition
from opensuction.safety.governor import governor, limiter
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.limits import Limits
from opensuction.safety.watch import watch
from opensuction.safety.watch.watch_state import Watch
from tests.proof.claim import (
    all_of,
    at_most,
    between,
    bounded,
    has,
    minus,
    plus,
    within,
)
from tests.proof.span import (
    COMMAND_MM,
    DT_S,
    GROWTH_MM,
    KEPT_SIZES,
    MOST_HEAD_MM,
    cam_is_kept,
    move_is_told,
    setting,
    speed_is_kept,
    tip_is_kept,
    unknown_state,
    vote_is_kept,
    watch_is_kept,
)
from tests.proof.test_narrowing import possible
from tools.proof.arithmetic import Doubles
from tools.proof.contract import Contract
from tools.proof.logic import MASK_BITS, as_integer, lift_truth
from tools.proof.unknown import free


def _servo_arguments(doubles: Doubles) -> list[Any]:
    sizes = {"state.error": 1e18, "state.velocity": 1e20, "velocity": 1e20}
    number = bounded(doubles, {**sizes, "position": 1e16, "reading": 1e9})
    state = free(doubles, ServoState, "state", number)
    numbers = [number(name) for name in ("position", "velocity", "reading")]
    return [setting(doubles, Servo, "servo"), state, *numbers, DT_S]


def _servo_requires(
    doubles: Doubles, gains: Servo, state: Any, position: Any, velocity: Any, reading: Any, _: float
) -> z3.BoolRef:
    return all_of(
        friction_is_borne(doubles, gains),
        within(doubles, position, 1e16),
        within(doubles, reading, 1e9),
        within(doubles, velocity, 1e20),
        within(doubles, state.error, 1e18),
        within(doubles, state.velocity, 1e20),
    )


def friction_is_borne(doubles: Doubles, gains: Servo) -> z3.BoolRef:
    """What is put on against friction is not below the whole supply the other way."""
    return at_most(doubles, minus(doubles, gains.voltage_limit_v), gains.friction_v)


def _servo_ensures(
    doubles: Doubles,
    result: Any,
    gains: Servo,
    _state: Any,
    _position: Any,
    _velocity: Any,
    *_: Any,
) -> z3.BoolRef:
    following, volts = result
    return all_of(
        between(doubles, minus(doubles, gains.voltage_limit_v), volts, gains.voltage_limit_v),
        within(doubles, following.error, 1e18),
        within(doubles, following.velocity, 1e20),
    )


def _servo_result(doubles: Doubles, name: str) -> Any:
    number = bounded(doubles, {"error": 1e18, "velocity": 1e20, "volts": 1e6})
    return free(doubles, ServoState, name, number), number(f"{name}.volts")


SERVO = Contract(servo.step, _servo_arguments, _servo_result, _servo_requires, _servo_ensures)


def _valve_requires(doubles: Doubles, motion: Any, cam_rad: Any, *_: Any) -> z3.BoolRef:
    return cam_is_kept(doubles, motion, cam_rad)


def _valve_arguments(doubles: Doubles) -> list[Any]:
    cam_rad = doubles.free_finite("cam_rad", 0.0, 2e3)  # type: ignore[union-attr]
    return [setting(doubles, ValveMotion, "valve_motion"), cam_rad, z3.Bool("opened"), DT_S]


def _valve_result(doubles: Doubles, name: str) -> Any:
    number = bounded(doubles, {"cam": (0.0, 2e3), "speed": 1e12})
    return number(f"{name}.cam"), number(f"{name}.speed")


def _valve_ensures(doubles: Doubles, result: Any, motion: Any, *_: Any) -> z3.BoolRef:
    cam_rad, speed = result
    return z3.And(cam_is_kept(doubles, motion, cam_rad), within(doubles, speed, 1e12))


VALVE = Contract(servo.step_valve, _valve_arguments, _valve_result, _valve_requires, _valve_ensures)


def _locate_arguments(doubles: Doubles) -> list[Any]:
    limits, state = setting(doubles, Limits, "limits"), unknown_state(doubles)
    driven_v = doubles.free_finite("driven_v", -1e6, 1e6)  # type: ignore[union-attr]
    return [limits, state, free(doubles, Readings, "readings"), driven_v, DT_S]


def _locate_requires(
    doubles: Doubles, _limits: Limits, state: Any, _readings: Any, driven_v: Any, _: float
) -> z3.BoolRef:
    return z3.And(watch_is_kept(doubles, state.watch), within(doubles, driven_v, 1e6))


def _locate_ensures(doubles: Doubles, vote: Any, _limits: Limits, state: Any, *_: Any) -> Any:
    seen = state.watch
    return z3.And(
        vote_is_kept(doubles, vote),
        move_is_told(doubles, seen.vote, seen.speed_mm_per_s, vote),
    )


def unknown_vote(doubles: Doubles, name: str) -> Any:
    sizes = {key.removeprefix("vote."): size for key, size in KEPT_SIZES.items()}
    return free(doubles, HeadVote, name, bounded(doubles, {**sizes, "jumped_mm": 1e8}))


LOCATE = Contract(
    governor.locate, _locate_arguments, unknown_vote, _locate_requires, _locate_ensures
)


def _watch_arguments(doubles: Doubles) -> list[Any]:
    state = unknown_state(doubles)
    return [
        setting(doubles, Limits, "limits"),
        state.watch,
        state.last,
        state.valve_command_changed,
        free(doubles, Readings, "readings"),
        unknown_vote(doubles, "vote"),
        z3.Bool("overrun"),
        DT_S,
    ]


def _watch_requires(
    doubles: Doubles,
    _limits: Any,
    before: Watch,
    last: Any,
    _changed: Any,
    _readings: Any,
    vote: Any,
    *_: Any,
) -> z3.BoolRef:
    return all_of(
        watch_is_kept(doubles, before),
        vote_is_kept(doubles, vote),
        within(doubles, last.head_mm, COMMAND_MM),
        within(doubles, last.head_mm_per_s, 1e20),
        move_is_told(doubles, before.vote, before.speed_mm_per_s, vote),
    )


def _watch_ensures(
    doubles: Doubles,
    seen: Watch,
    _limits: Any,
    _before: Any,
    _last: Any,
    _changed: Any,
    _readings: Any,
    vote: Any,
    *_: Any,
) -> z3.BoolRef:
    same_vote = [
        as_integer(getattr(seen.vote, name)) == as_integer(getattr(vote, name))
        for name in ("unseen_ticks", "encoder_odd", "surprised_ticks")
    ]
    same_number = [
        getattr(seen.vote, name).real == getattr(vote, name).real
        for name in ("head_mm", "encoder_mm", "carriage_mm", "motor_mm_per_s", "zero_mm")
    ]
    same_out = lift_truth(seen.vote.encoder_out) == lift_truth(vote.encoder_out)
    return all_of(
        seen.head_mm.real == vote.head_mm.real,
        as_integer(seen.invalid.cam) >= 0,
        *same_vote,
        *same_number,
        same_out,
        speed_is_kept(doubles, vote, seen.speed_mm_per_s),
        tip_is_kept(doubles, seen),
    )


def _unknown_watch(doubles: Doubles, name: str) -> Any:
    sizes = {**KEPT_SIZES, f"{name}.head_mm": MOST_HEAD_MM, f"{name}.cam_rad": LARGEST}
    return free(doubles, Watch, name, bounded(doubles, sizes))


WATCH = Contract(watch.step, _watch_arguments, _unknown_watch, _watch_requires, _watch_ensures)


def _narrow_arguments(doubles: Doubles) -> list[Any]:
    state = unknown_state(doubles)
    proposal = free(doubles, Setpoints, "proposal")
    trips = z3.BitVec("trips", MASK_BITS)
    limits = setting(doubles, Limits, "limits")
    return [limits, state.last, state.watch, proposal, trips, DT_S]


def vacuum_is_limited(doubles: Doubles, limits: Limits, vacuum_mmhg: Any) -> z3.BoolRef:
    """Not above what the patient may have, or the line is tested with when closed."""
    low = at_most(doubles, vacuum_mmhg, limits.vacuum_mmhg)
    tested = at_most(doubles, vacuum_mmhg, limits.line.parked_closed_mmhg)
    return all_of(between(doubles, 0.0, vacuum_mmhg, 1e6), z3.Or(low, tested))


def _narrow_requires(
    doubles: Doubles, _limits: Any, last: Any, seen: Any, proposal: Any, trips: Any, _: float
) -> z3.BoolRef:
    return all_of(
        z3.Or(possible(doubles, proposal), has(trips, Condition.PROPOSAL_INVALID)),
        within(doubles, last.head_mm, COMMAND_MM),
        within(doubles, last.head_mm_per_s, 1e20),
        within(doubles, seen.head_mm, MOST_HEAD_MM),
        within(doubles, seen.suction_start_mm, MOST_HEAD_MM),
        within(doubles, seen.speed_mm_per_s, 1e10),
    )


def _narrow_ensures(doubles: Doubles, result: Any, limits: Any, last: Any, *_: Any) -> z3.BoolRef:
    allowed, _ = result
    furthest = plus(doubles, _larger(doubles, last.head_mm), GROWTH_MM)
    return all_of(
        at_most(doubles, allowed.head_mm, furthest),
        at_most(doubles, minus(doubles, allowed.head_mm), furthest),
        within(doubles, allowed.head_mm_per_s, 1e20),
        vacuum_is_limited(doubles, limits, allowed.vacuum_mmhg),
    )


def _larger(doubles: Doubles, head_mm: Any) -> Any:
    """The size of a command, or of the furthest head, whichever is larger."""
    size = doubles.absolute(head_mm)
    most = doubles.make(MOST_HEAD_MM)
    return doubles.choose(lift_truth(doubles.less(size, most)), most, size)


def _unknown_setpoints(doubles: Doubles, name: str) -> Any:
    sizes: dict[str, float | tuple[float, float]] = {
        "head_mm": 2 * COMMAND_MM,
        "head_mm_per_s": 1e20,
        "vacuum_mmhg": (0.0, 1e6),
    }
    allowed = free(doubles, Setpoints, name, bounded(doubles, sizes))
    return allowed, z3.Int(f"{name}.reaction")


NARROW = Contract(
    limiter.narrow, _narrow_arguments, _unknown_setpoints, _narrow_requires, _narrow_ensures
)


def _judge_ensures(
    doubles: Doubles, trips: Any, _limits: Any, _state: Any, _seen: Any, proposal: Any
) -> z3.BoolRef:
    """That is N10, of all trips together."""
    return z3.Or(possible(doubles, proposal), has(trips, Condition.PROPOSAL_INVALID))


JUDGE = Contract(
    governor.judge,
    lambda doubles: [
        setting(doubles, Limits, "limits"),
        unknown_state(doubles),
        free(doubles, Watch, "seen"),
        free(doubles, Setpoints, "proposal"),
    ],
    lambda _, name: z3.BitVec(name, MASK_BITS),
    lambda *_: True,
    _judge_ensures,
)
