"""No NaN or infinity reaches a command, whatever the readings are and whatever is asked for.

The controller's tick is run whole but for what it proposes: procedure, control and upkeep may ask
for anything at all. What is too large is proved by contract, callee by callee.
"""

from collections.abc import Callable
from typing import Any

import z3

from opensuction.control import compensation, servo, valve
from opensuction.control.exact_inverse import HeadState
from opensuction.control.servo import Servo, ServoState
from opensuction.control.valve import ValveMotion
from opensuction.controller import controller
from opensuction.controller.record import CoreState, Inputs
from opensuction.kernel.commands import Setpoints
from opensuction.kernel.readings import LARGEST, Readings
from opensuction.kernel.requests import Requests
from opensuction.procedure.cycle import button, upkeep
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.progress import ProcedureState
from opensuction.procedure.cycle.upkeep import Counters, Upkeep
from opensuction.safety.condition import Condition
from opensuction.safety.governor import forced_withdrawal, governor, limiter
from opensuction.safety.governor.forced_withdrawal import ForcedWithdrawal
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.limits import Limits
from opensuction.safety.watch import patient_watch, watch
from opensuction.safety.watch.patient_watch import PatientWatch
from opensuction.safety.watch.watch_state import Watch
from proof.abstract_double import AbstractDoubles
from proof.arithmetic import Doubles
from proof.contract import Contract, prove_contract, prove_on, rely
from proof.logic import MASK_BITS, as_integer, lift_truth
from proof.translation import Translation, any_raises
from proof.unknown import free
from tests.proof.claim import (
    all_of,
    at_most,
    between,
    bounded,
    has,
    is_finite,
    report,
    within,
)
from tests.proof.span import (
    COMMAND_MM,
    DT_S,
    GROWTH_MM,
    KEPT_SIZES,
    MOST_HEAD_MM,
    cam_is_kept,
    core_is_kept,
    divisors,
    move_is_told,
    setting,
    speed_is_kept,
    tip_is_kept,
    unknown_settings,
    unknown_state,
    vote_is_kept,
    watch_is_kept,
)
from tests.proof.table import proves
from tests.proof.test_narrowing import possible

TICK = "a tick of 1 ms; settings within the bounds of `tests/proof/span.py`"


# Servo


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
    return at_most(doubles, doubles.negative(gains.voltage_limit_v), gains.friction_v)


def _servo_ensures(
    doubles: Doubles, result: Any, gains: Servo, state: Any, position: Any, velocity: Any, *_: Any
) -> z3.BoolRef:
    following, volts = result
    return all_of(
        between(doubles, doubles.negative(gains.voltage_limit_v), volts, gains.voltage_limit_v),
        within(doubles, following.error, 1e18),
        within(doubles, following.velocity, 1e20),
    )


def _servo_result(doubles: Doubles, name: str) -> Any:
    number = bounded(doubles, {"error": 1e18, "velocity": 1e20, "volts": 1e6})
    return free(doubles, ServoState, name, number), number(f"{name}.volts")


SERVO = Contract(servo.step, _servo_arguments, _servo_result, _servo_requires, _servo_ensures)


def check_contract(contract: Contract) -> None:
    doubles = AbstractDoubles(divisors())
    for answer in prove_contract(contract, doubles, Translation(doubles)):
        report(answer)


@proves(
    "F1",
    "The servo's volts are a number within its supply.",
    "`servo.step`",
    f"doubles, abstractly; position within 1e16, reading within 1e9, its state within 1e20; {TICK}",
)
def test_the_volts_are_within_the_supply() -> None:
    check_contract(SERVO)


# Valve


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


VALVE = Contract(valve.step, _valve_arguments, _valve_result, _valve_requires, _valve_ensures)


@proves(
    "F2",
    "The cam's command stays between closed and open (but for rounding: 1e-9 rad), its speed a "
    "number.",
    "`valve.step`",
    f"doubles, abstractly; any cam between closed and open; {TICK}",
)
def test_the_cam_is_commanded_within_its_stroke() -> None:
    check_contract(VALVE)


# What is seen of the head


def _locate_arguments(doubles: Doubles) -> list[Any]:
    limits, state = setting(doubles, Limits, "limits"), unknown_state(doubles)
    driven_v = doubles.free_finite("driven_v", -1e6, 1e6)  # type: ignore[union-attr]
    return [limits, state, free(doubles, Readings, "readings"), driven_v, DT_S]


def _locate_requires(
    doubles: Doubles, limits: Limits, state: Any, readings: Any, driven_v: Any, _: float
) -> z3.BoolRef:
    return z3.And(watch_is_kept(doubles, state.watch), within(doubles, driven_v, 1e6))


def _locate_ensures(doubles: Doubles, vote: Any, limits: Limits, state: Any, *_: Any) -> Any:
    seen = state.watch
    return z3.And(
        vote_is_kept(doubles, vote),
        move_is_told(doubles, seen.vote, seen.speed_mm_per_s, vote),
    )


def _unknown_vote(doubles: Doubles, name: str) -> Any:
    sizes = {key.removeprefix("vote."): size for key, size in KEPT_SIZES.items()}
    return free(doubles, HeadVote, name, bounded(doubles, {**sizes, "jumped_mm": 1e8}))


LOCATE = Contract(
    governor.locate, _locate_arguments, _unknown_vote, _locate_requires, _locate_ensures
)


@proves(
    "F3",
    "Where the head is taken to be, and the motor's speed, stay numbers within bounds from tick to "
    "tick.",
    "`governor.locate` (`head_vote.step`) with all that it calls",
    "doubles, abstractly; readings any double whatever, valid or not; the state as F3 and F4 leave "
    f"it, all other numbers of it any doubles; {TICK}",
)
def test_the_head_stays_a_number() -> None:
    check_contract(LOCATE)


def _watch_arguments(doubles: Doubles) -> list[Any]:
    state = unknown_state(doubles)
    return [
        setting(doubles, Limits, "limits"),
        state.watch,
        state.last,
        state.valve_command_changed,
        free(doubles, Readings, "readings"),
        _unknown_vote(doubles, "vote"),
        z3.Bool("overrun"),
        DT_S,
    ]


def _watch_requires(
    doubles: Doubles, limits: Any, before: Watch, last: Any, changed: Any, readings: Any, vote: Any,
    *_: Any,
) -> z3.BoolRef:  # fmt: skip
    return all_of(
        watch_is_kept(doubles, before),
        vote_is_kept(doubles, vote),
        move_is_told(doubles, before.vote, before.speed_mm_per_s, vote),
    )


def _watch_ensures(
    doubles: Doubles, seen: Watch, limits: Any, before: Any, last: Any, changed: Any, readings: Any,
    vote: Any, *_: Any,
) -> z3.BoolRef:  # fmt: skip
    same_vote = [
        as_integer(getattr(seen.vote, name)) == as_integer(getattr(vote, name))
        for name in ("unseen_ticks", "encoder_odd", "surprised_ticks")
    ]
    same_number = [
        getattr(seen.vote, name).real == getattr(vote, name).real
        for name in ("head_mm", "encoder_mm", "carriage_mm", "motor_mm_per_s")
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
    sizes = {**KEPT_SIZES, "head_mm": MOST_HEAD_MM, "cam_rad": LARGEST}
    return free(doubles, Watch, name, bounded(doubles, sizes))


WATCH = Contract(watch.step, _watch_arguments, _unknown_watch, _watch_requires, _watch_ensures)


@proves(
    "F4",
    "The averaged speed, the possible tip, the cam's reading and where suction began stay numbers "
    "within bounds from tick to tick.",
    "`watch.step` with all that it calls",
    "doubles, abstractly; readings any double whatever; the state as F3 and F4 leave it, all other "
    f"numbers of it any doubles; {TICK}",
)
def test_what_is_seen_stays_a_number() -> None:
    check_contract(WATCH)


# What is let through


def _narrow_arguments(doubles: Doubles) -> list[Any]:
    state = unknown_state(doubles)
    proposal = free(doubles, Setpoints, "proposal")
    trips = z3.BitVec("trips", MASK_BITS)
    limits = setting(doubles, Limits, "limits")
    return [limits, state.last, state.watch, proposal, trips, DT_S]


def _narrow_requires(
    doubles: Doubles, limits: Any, last: Any, seen: Any, proposal: Any, trips: Any, _: float
) -> z3.BoolRef:
    return all_of(
        z3.Or(possible(doubles, proposal), has(trips, Condition.PROPOSAL_INVALID)),
        within(doubles, last.head_mm, COMMAND_MM),
        within(doubles, last.head_mm_per_s, 1e20),
        within(doubles, seen.head_mm, MOST_HEAD_MM),
        within(doubles, seen.suction_start_mm, MOST_HEAD_MM),
    )


def _narrow_ensures(
    doubles: Doubles, result: Any, limits: Any, last: Any, seen: Any, proposal: Any, *_: Any
) -> z3.BoolRef:
    allowed, _ = result
    furthest = doubles.add(_larger(doubles, last.head_mm), doubles.make(GROWTH_MM))
    return all_of(
        at_most(doubles, allowed.head_mm, furthest),
        at_most(doubles, doubles.negative(allowed.head_mm), furthest),
        within(doubles, allowed.head_mm_per_s, 1e20),
        between(doubles, 0.0, allowed.vacuum_mmhg, 1e6),
    )


def _larger(doubles: Doubles, head_mm: Any) -> Any:
    """The size of a command, or of the furthest head, whichever is larger."""
    size = doubles.absolute(head_mm)
    most = doubles.make(MOST_HEAD_MM)
    return doubles.choose(lift_truth(doubles.less(size, most)), most, size)


def _unknown_setpoints(doubles: Doubles, name: str) -> Any:
    sizes = {
        "head_mm": 2 * COMMAND_MM,
        "head_mm_per_s": 1e20,
        "vacuum_mmhg": (0.0, 1e6),
    }
    allowed = free(doubles, Setpoints, name, bounded(doubles, sizes))
    return allowed, z3.Int(f"{name}.reaction")


NARROW = Contract(
    limiter.narrow, _narrow_arguments, _unknown_setpoints, _narrow_requires, _narrow_ensures
)


@proves(
    "F5",
    "The setpoints let through are numbers: the vacuum between 0 and its limits, the head's "
    "command further out or in than the last by 20 mm a tick at most.",
    "`limiter.narrow` with all that it calls",
    "doubles, abstractly; proposal any double, NaN and infinities too; "
    f"command within 1e15 mm; {TICK}",
)
def test_what_is_let_through_is_a_number() -> None:
    check_contract(NARROW)


# The whole tick


def _anything(doubles: Doubles, *kinds: Any) -> Callable[..., Any]:
    """A function that may give anything of these types."""
    calls = iter(range(1000))

    def summary(*_: Any, **__: Any) -> Any:
        call = next(calls)
        name = f"any:{'.'.join(kind.__name__ for kind in kinds)}:{call}"
        parts = tuple(free(doubles, kind, f"{name}.{i}") for i, kind in enumerate(kinds))
        return parts if len(parts) > 1 else parts[0]

    return summary


def _asked_for(doubles: Doubles) -> dict[Callable[..., Any], Callable[..., Any]]:
    """Procedure, control and upkeep: whatever they ask for."""
    given: dict[Callable[..., Any], tuple[Any, ...]] = {
        controller._press: (Requests, Upkeep, bool),
        controller._decide: (ProcedureState, Demand, HeadState),
        controller._wrong: (int, int),
        compensation.after_retract: (HeadState,),
        upkeep.is_asked: (bool,),
        upkeep.refusal: (int,),
        upkeep.step: (Upkeep,),
        upkeep.watch_resets: (Upkeep,),
        upkeep.is_prompting: (bool,),
        upkeep.count: (Counters,),
        button.hold: (int,),
        patient_watch.step: (PatientWatch,),
        forced_withdrawal.step: (ForcedWithdrawal,),
    }
    return {function: _anything(doubles, *kinds) for function, kinds in given.items()}


def _judge_ensures(
    doubles: Doubles, trips: Any, limits: Any, state: Any, seen: Any, proposal: Any
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
    lambda doubles, name: z3.BitVec(name, MASK_BITS),
    lambda doubles, *arguments: True,
    _judge_ensures,
)


@proves(
    "F6",
    "All trips together have that of an impossible proposal.",
    "`governor.judge` with all that it calls",
    f"doubles, abstractly: everything any double whatever; {TICK}",
)
def test_all_trips_have_that_of_an_impossible_proposal() -> None:
    check_contract(JUDGE)


@proves(
    "F7",
    "Every number in a tick's commands is one: head, cam between closed and open, volts of both "
    "drives within their supply, vacuum between 0 and its limits; and so is the deepest possible "
    "tip of the verdict. What F1 to F5 ask of the state, the tick keeps.",
    "`controller.control_step`, on F1 to F6 and with procedure, control, upkeep and alarms asking "
    "for anything",
    "doubles, abstractly; readings, requests, proposals any double whatever; state as the tick "
    f"keeps it, all other numbers of it any doubles; {TICK}",
)
def test_commands_are_numbers() -> None:
    doubles = AbstractDoubles()
    summaries, reliance = rely([SERVO, VALVE, LOCATE, WATCH, NARROW, JUDGE], doubles)
    translation = Translation(doubles, summaries | _asked_for(doubles))
    settings = unknown_settings(doubles, plan=_Plan)
    number = bounded(doubles, KEPT_SIZES)
    core = free(doubles, CoreState, "core", number)
    inputs = free(doubles, Inputs, "inputs", None, {"inputs.dt_s": DT_S})
    head = free(doubles, HeadState, "head")
    following, _, outputs, _ = translation.run(
        controller.control_step, settings, None, core, head, inputs
    )
    commands = outputs.commands
    volts = [
        between(doubles, doubles.negative(axis.voltage_limit_v), value, axis.voltage_limit_v)
        for axis, value in (
            (settings.insertion_servo, commands.insertion_v),
            (settings.valve_servo, commands.valve_v),
        )
    ]
    claim = all_of(
        is_finite(doubles, commands.head_mm),
        cam_is_kept(doubles, settings.valve_motion, commands.cam_rad),
        between(doubles, 0.0, commands.vacuum_mmhg, 1e6),
        is_finite(doubles, outputs.verdict.deepest_mm),
        *volts,
        core_is_kept(doubles, settings, following, 2 * COMMAND_MM),
        z3.Not(any_raises(translation)),
    )
    servos = settings.insertion_servo, settings.valve_servo
    assumed = all_of(
        core_is_kept(doubles, settings, core), *(friction_is_borne(doubles, one) for one in servos)
    )
    report(prove_on(reliance, doubles, assumed, claim))


class _Plan:
    """All of the plan that the tick itself reads."""

    travel_known = z3.Bool("travel_known")
