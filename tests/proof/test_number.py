"""No NaN or infinity reaches a command, whatever the readings are and whatever is asked for.

The controller's tick is run whole but for what it proposes: procedure, control and upkeep may ask
for anything at all. What is too large is proved by contract, callee by callee.
"""

from collections.abc import Callable
from typing import Any

import pytest
import z3

from opensuction.control import compensation
from opensuction.control.backlash_inverse import HeadState
from opensuction.controller import controller
from opensuction.controller.record import CoreState, Inputs
from opensuction.kernel.interface import Requests
from opensuction.procedure.cycle import button, interlocks
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.interlocks import Counters, Interlocks
from opensuction.procedure.cycle.progress import ProcedureState
from opensuction.safety.governor import governor
from opensuction.safety.governor.governor import ForcedWithdrawal
from opensuction.safety.watch import patient_watch
from opensuction.safety.watch.patient_watch import PatientWatch
from tests.proof.claim import (
    all_of,
    between,
    bounded,
    is_finite,
    minus,
    report,
)
from tests.proof.duty import (
    JUDGE,
    LOCATE,
    NARROW,
    SERVO,
    VALVE,
    WATCH,
    friction_is_borne,
    vacuum_is_limited,
)
from tests.proof.span import (
    COMMAND_MM,
    DT_S,
    KEPT_SIZES,
    cam_is_kept,
    core_is_kept,
    divisors,
    unknown_settings,
)
from tests.proof.table import proves
from tools.proof.abstract_double import AbstractDoubles
from tools.proof.arithmetic import Doubles
from tools.proof.contract import Contract, prove_contract, prove_on, rely
from tools.proof.translation import Translation, any_raises
from tools.proof.unknown import free

TICK = "a tick of 1 ms; settings within the bounds of `tests/proof/span.py`"


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


@proves(
    "F2",
    "The cam's command stays between closed and open (but for rounding: 1e-9 rad), its speed a "
    "number.",
    "`valve.step`",
    f"doubles, abstractly; any cam between closed and open; {TICK}",
)
def test_the_cam_is_commanded_within_its_stroke() -> None:
    check_contract(VALVE)


@pytest.mark.sweep
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
        controller._press: (Requests, Interlocks, bool),
        controller._decide: (ProcedureState, Demand, HeadState),
        controller._wrong: (int, int),
        compensation.after_retract: (HeadState,),
        interlocks.is_asked: (bool,),
        interlocks.refusal: (int,),
        interlocks.step: (Interlocks,),
        interlocks.watch_resets: (Interlocks,),
        interlocks.is_prompting: (bool,),
        interlocks.count: (Counters,),
        button.hold: (int,),
        patient_watch.step: (PatientWatch,),
        governor.step_withdrawal: (ForcedWithdrawal,),
    }
    return {function: _anything(doubles, *kinds) for function, kinds in given.items()}


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
        between(doubles, minus(doubles, axis.voltage_limit_v), value, axis.voltage_limit_v)
        for axis, value in (
            (settings.insertion_servo, commands.insertion_v),
            (settings.valve_servo, commands.valve_v),
        )
    ]
    claim = all_of(
        is_finite(doubles, commands.head_mm),
        cam_is_kept(doubles, settings.valve_motion, commands.cam_rad),
        vacuum_is_limited(doubles, settings.limits, commands.vacuum_mmhg),
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
