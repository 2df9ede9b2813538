"""No path of the procedure asks for vacuum on the way in.

The table of transitions is walked whole, and what each phase asks for is run on unknowns: plan,
readings, requests and what the state remembers.
"""

import itertools
import math
from typing import Any, NamedTuple

import pytest
import z3

from opensuction.control import motion_profile
from opensuction.kernel.interface import Readings, Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import cycle, demand, progress, transition
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.plan import Plan
from opensuction.procedure.cycle.progress import ControlFeedback, ProcedureState
from opensuction.procedure.cycle.transition import TRANSITIONS, Event
from opensuction.procedure.suction import line_flow
from opensuction.procedure.suction.line_flow import Pace, PacePlan
from tests.proof.claim import all_of, assert_holds, at_most, implies, is_, plus, same
from tests.proof.span import DT_S
from tests.proof.table import proves
from tools.proof import arithmetic
from tools.proof.abstract_double import AbstractDoubles
from tools.proof.logic import MASK_BITS, disjoin, lift_truth
from tools.proof.translation import Translation
from tools.proof.unknown import free

SUCKING = (Phase.OPENING, Phase.SUCTIONING, Phase.WITHDRAWING)
"""Phases that open the valve whatever was before."""
INWARDS = (Phase.PRELOADING, Phase.INSERTING)
"""Phases whose reference, or head, is to go in."""


@proves(
    "T1",
    "What is run each tick is the table: of the events of a tick the first that the table knows "
    "is taken, and leads where the table says.",
    "`transition.follow`, `transition.cause`",
    "each phase, any mask of events",
)
@pytest.mark.parametrize("phase", list(Phase))
def test_the_tick_follows_the_table(phase: Phase) -> None:
    doubles = AbstractDoubles()
    events = z3.BitVec("events", MASK_BITS)
    following = Translation(doubles).run(transition.follow, int(phase), events)
    known = [event for event in Event if (phase, event) in TRANSITIONS]
    claims, earlier = [], z3.BoolVal(False)
    for event in known:
        happened = z3.Extract(int(event), int(event), events) == 1
        goal = is_(following, TRANSITIONS[phase, event])
        claims.append(z3.Implies(z3.And(happened, z3.Not(earlier)), goal))
        earlier = z3.Or(earlier, happened)
    claims.append(z3.Implies(z3.Not(earlier), is_(following, phase)))
    assert_holds(doubles, True, all_of(*claims))


class Tick(NamedTuple):
    """A tick of the cycle on unknowns."""

    doubles: AbstractDoubles
    plan: Plan
    state: ProcedureState
    feedback: ControlFeedback
    events: Any
    """Mask of what happened in it."""
    now: ProcedureState
    asked: Demand
    assumed: z3.BoolRef
    """It takes a step of the table, and no item is tested outside the pre-use test."""


def step_cycle(doubles: AbstractDoubles) -> Tick:
    """Run a tick; where the reference is on its way may be anything: see T5."""
    plan, state = free(doubles, Plan, "plan"), free(doubles, ProcedureState, "state")
    plan = plan._replace(limits_s=tuple(doubles.free(f"limit{phase:d}_s") for phase in Phase))
    calls = itertools.count()

    def anything(*_: Any) -> Any:
        call = next(calls)
        return doubles.free(f"way{call}_mm"), doubles.free(f"way{call}_mm_per_s")

    def choose(values: Any, index: Any) -> Any:
        return arithmetic.element(doubles, values, index)

    seen: list[Any] = []

    def follow(_: Any, events: Any) -> Any:
        seen.append(events)
        return z3.Int("following")

    ways = {motion_profile.at: anything, motion_profile.staged_at: anything, cycle.excite: anything}
    tests = {
        progress.step_check: lambda *_: free(doubles, type(state.check), "checked"),
        progress.step_teaching: lambda *_: free(doubles, type(state.teaching), "taught"),
        line_flow.step: lambda *_: free(doubles, type(state.flow), "flow"),
        cycle._phase_limit_s: choose,
        transition.follow: follow,
        transition.cause: lambda *_: z3.Int("cause"),
    }
    feedback = free(doubles, ControlFeedback, "feedback")
    translation = Translation(doubles, ways | tests)
    now, asked = translation.run(
        cycle.step,
        plan,
        state,
        free(doubles, Readings, "readings"),
        free(doubles, Requests, "requests"),
        feedback,
        DT_S,
    )
    steps = {(phase, phase) for phase in Phase}
    steps |= {(phase, goal) for (phase, _), goal in TRANSITIONS.items()}
    by_table = [z3.And(is_(state.phase, one), is_(now.phase, other)) for one, other in steps]
    assumed = all_of(disjoin(*by_table), is_untested(state))
    return Tick(doubles, plan, state, feedback, seen[0], now, asked, assumed)


@pytest.fixture(scope="module")
def tick() -> Tick:
    return step_cycle(AbstractDoubles())


def is_untested(state: ProcedureState) -> z3.BoolRef:
    """Outside the pre-use test no item of it is being tested."""
    return z3.Or(is_(state.phase, Phase.CHECKING), is_(state.check.item, CheckItem.NONE))


def test_no_item_is_tested_outside_the_pre_use_test(tick: Tick) -> None:
    assert_holds(tick.doubles, tick.assumed, is_untested(tick.now))


def valve_may_be_open(phase: Any, item: Any) -> z3.BoolRef:
    """Where the demanded valve may be open: the claim, and what each tick keeps."""
    stroking = z3.And(is_(phase, Phase.CHECKING), is_(item, CheckItem.VALVE_OPENS))
    others = [is_(phase, one) for one in (*SUCKING, Phase.ABORTING)]
    return z3.Or(stroking, *others)


@proves(
    "T2",
    "The valve is asked to be open in OPENING, SUCTIONING and WITHDRAWING, in ABORTING and in the "
    "item of the pre-use test that strokes it, and nowhere else, whatever came before.",
    "`cycle.step` and all that it calls but for the reference's way, the pre-use test's, the "
    "teaching's and the line flow's own step",
    "every step of the table; everything else any value whatever",
)
def test_the_valve_is_asked_for_in_these_phases_only(tick: Tick) -> None:
    where = valve_may_be_open(tick.now.phase, tick.now.check.item)
    assert_holds(tick.doubles, tick.assumed, implies(tick.asked.valve_open, where))


@proves(
    "T3",
    "An abort opens no valve: it keeps one open that was.",
    "the same",
    "the same",
)
def test_an_abort_opens_no_valve(tick: Tick) -> None:
    aborting = z3.And(is_(tick.now.phase, Phase.ABORTING), lift_truth(tick.asked.valve_open))
    assert_holds(tick.doubles, tick.assumed, implies(aborting, tick.state.valve_open))


@proves(
    "T4",
    "While the valve is asked to be open no motion inwards is: none announced, no jog, and a "
    "reference that stands or is on the way to its park position.",
    "the same, with `demand.ask`",
    "the same",
)
def test_no_motion_inwards_is_asked_for_with_an_open_valve(tick: Tick) -> None:
    doubles, now, asked = tick.doubles, tick.now, tick.asked
    going_out = z3.Or(is_(now.phase, Phase.WITHDRAWING), is_(now.phase, Phase.ABORTING))
    standing = same(doubles, asked.reference_mm_per_s, 0.0)
    announced = z3.And(
        same(doubles, asked.direction, demand.INWARDS), at_most(doubles, 0.0, asked.starts_in_s)
    )
    claim = all_of(z3.Or(going_out, standing), z3.Not(announced), same(doubles, asked.jog_mm, 0.0))
    assert_holds(doubles, tick.assumed, implies(asked.valve_open, claim))


@proves(
    "T5",
    "A way from rest to rest never turns: between its ends its speed has the sign of the way, so "
    "the ways of WITHDRAWING and ABORTING, whose end is the park position, go outwards from "
    "everywhere further in.",
    "`profile.at` and all that it calls; root as any number not below 0",
    "doubles, abstractly: ends, speed and acceleration any finite ones, the last two above 0; any "
    "time",
)
def test_a_way_never_turns() -> None:
    doubles = AbstractDoubles()
    names = ("start_mm", "end_mm", "speed", "acceleration", "time_s")
    unknown: list[Any] = [doubles.free_finite(name) for name in names]
    start, end, speed, acceleration, time_s = unknown

    def root(_: Any) -> Any:
        return doubles.free_finite("root", 0.0)

    translation = Translation(doubles, {math.sqrt: root})
    way = motion_profile.Profile(start, end, speed, acceleration)
    _, velocity = translation.run(motion_profile.at, way, time_s)
    positive = all_of(
        z3.Not(at_most(doubles, speed, 0.0)), z3.Not(at_most(doubles, acceleration, 0.0))
    )
    outwards = at_most(doubles, end, start)
    claim = implies(outwards, at_most(doubles, velocity, 0.0))
    assert_holds(doubles, positive, claim)


@proves(
    "T6",
    "What comes slows the way out, and never turns it round or hurries it: its speed stays between "
    "none and the planned one, it falls behind by a tick a tick at most (but for rounding), and "
    "the time that it may still lose does not grow.",
    "`pace.go_on`",
    "doubles, abstractly: speeds as shares from 0 to 1, times from 0 to 1,000 s; a tick of 1 ms",
)
def test_what_comes_never_turns_the_way_out() -> None:
    doubles = AbstractDoubles()
    plan = free(doubles, PacePlan, "plan")._replace(
        slow_ratio=doubles.free_finite("slow", 0.0, 1.0), ramp_s=doubles.free_finite("ramp")
    )
    before = free(doubles, Pace, "pace")._replace(
        ratio=doubles.free_finite("ratio", 0.0, 1.0),
        late_s=doubles.free_finite("late", 0.0, 1e3),
        spare_s=doubles.free_finite("spare", 0.0, 1e3),
    )
    after = Translation(doubles).run(line_flow.go_on, plan, before, z3.Bool("comes"), DT_S)
    claim = all_of(
        at_most(doubles, 0.0, after.ratio),
        at_most(doubles, after.ratio, 1.0),
        at_most(doubles, before.late_s, after.late_s),
        at_most(doubles, after.late_s, plus(doubles, before.late_s, DT_S + 1e-9)),
        at_most(doubles, 0.0, after.spare_s),
        at_most(doubles, after.spare_s, before.spare_s),
    )
    assert_holds(doubles, True, claim)
