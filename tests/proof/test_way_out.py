"""Every phase with the tip inside has a bounded way out, whatever readings come.

Two clocks see to that. The governor's counts how long the tip may have been inside, whoever
proposes what in whichever phase; the procedure's how long a phase lasts. Each is proved to go on
in every tick, and to end what it times; the table then has no way round.
"""

from typing import Any, NamedTuple

import pytest
import z3

from opensuction.kernel.interface import Readings, Setpoints
from opensuction.kernel.vocabulary import CYCLE, RESTING, Phase
from opensuction.procedure.cycle.transition import ACTIVE, TRANSITIONS, Event
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import RELEASING, WITHDRAWING
from opensuction.safety.governor import governor
from opensuction.safety.governor.governor import GovernorState, Verdict
from opensuction.safety.governor.limiter import ADVANCE_MM
from opensuction.safety.handling import Reaction
from opensuction.safety.limits import Limits
from tests.proof.claim import (
    all_of,
    assert_holds,
    at_most,
    below,
    bounded,
    has,
    implies,
    is_,
    plus,
    within,
)
from tests.proof.duty import unknown_vote
from tests.proof.span import DT_S, KEPT_SIZES, setting
from tests.proof.table import proves
from tests.proof.test_transition import Tick, step_cycle
from tools.proof.abstract_double import AbstractDoubles
from tools.proof.logic import as_integer, as_mask, lift_truth
from tools.proof.translation import Translation
from tools.proof.unknown import free

OF = "`governor.step` and all that it calls"
FREE = (
    "doubles, abstractly; readings and proposal any double whatever, trips any mask; clocks up to "
    "1e6 s, other numbers as F3 and F4 keep them or any; a tick of 1 ms"
)
WITHDRAWN = WITHDRAWING | RELEASING
"""Every trip: none has a milder reaction."""
CLOCKS = {
    f"{clock}_s": (0.0, 1e6)
    for clock in (
        "inside",
        "forced",
        "blocked",
        "unseen",
        "waiting",
        "whole",
        "in_airway",
        "withdrawal",
    )
}


class Guarded(NamedTuple):
    """A tick of the governor on unknowns."""

    doubles: AbstractDoubles
    limits: Limits
    state: GovernorState
    following: GovernorState
    allowed: Setpoints
    verdict: Verdict


def guard() -> Guarded:
    doubles = AbstractDoubles()
    limits = setting(doubles, Limits, "limits")
    number = bounded(doubles, KEPT_SIZES | CLOCKS)
    state = free(doubles, GovernorState, "governor", number)
    proposal, readings = free(doubles, Setpoints, "proposal"), free(doubles, Readings, "readings")
    following, allowed, verdict = Translation(doubles).run(
        governor.step,
        limits,
        state,
        proposal,
        readings,
        unknown_vote(doubles, "vote"),
        z3.Bool("overrun"),
        DT_S,
    )
    return Guarded(doubles, limits, state, following, allowed, verdict)


@pytest.fixture(scope="module")
def guarded() -> Guarded:
    return guard()


@pytest.fixture(scope="module")
def cycle_tick() -> Tick:
    return step_cycle(AbstractDoubles())


def parts(value: Any) -> list[z3.ExprRef]:
    """What an unknown double is made of: the same parts are the same double."""
    return [value.real, *map(lift_truth, (value.nan, value.up, value.down))]


def goes_on(doubles: AbstractDoubles, before: Any, after: Any) -> z3.BoolRef:
    """Whether a clock has gone on by a tick, but for rounding."""
    least = plus(doubles, before, 0.999 * DT_S)
    return at_most(doubles, least, after)


def is_away(guarded: Guarded) -> z3.BoolRef:
    """Whether the head is further in than home, but for rounding."""
    home_mm = plus(guarded.doubles, guarded.limits.park_head_mm, ADVANCE_MM + 1e-6)
    return below(guarded.doubles, home_mm, guarded.following.watch.head_mm)


def is_withdrawing(verdict: Verdict) -> z3.BoolRef:
    """Whether the governor draws the head out, or has let it go."""
    reaction = as_integer(verdict.reaction)
    return z3.Or(reaction == int(Reaction.WITHDRAW), reaction == int(Reaction.TORQUE_OFF))


@proves(
    "W1",
    "As long as the deepest possible tip is inside, the clock of the airway goes on in every tick; "
    "nothing but a tip outside, or a person's reset, sets it back.",
    OF,
    FREE,
)
def test_the_clock_of_the_airway_goes_on(guarded: Guarded) -> None:
    doubles, before = guarded.doubles, guarded.state.watch.durations.inside_s
    inside = below(doubles, guarded.limits.outside_mm, guarded.verdict.deepest_mm)
    clock = guarded.following.watch.durations.inside_s
    assert_holds(doubles, inside, goes_on(doubles, before, clock))


@proves(
    "W2",
    "In the tick in which that clock is past its limit the governor withdraws or has let go, and "
    "the trip is named, whatever phase, protocol or proposal.",
    OF,
    FREE,
)
def test_the_clock_of_the_airway_ends_it(guarded: Guarded) -> None:
    clock = guarded.following.watch.durations.inside_s
    over = below(guarded.doubles, guarded.limits.in_airway_s, clock)
    tripped = has(guarded.verdict.trips, Condition.IN_AIRWAY_TIME)
    assert_holds(guarded.doubles, over, z3.And(tripped, is_withdrawing(guarded.verdict)))


@proves(
    "W3",
    "What has tripped stays tripped: from then on every tick withdraws or has let go.",
    OF,
    FREE,
)
def test_a_trip_is_latched(guarded: Guarded) -> None:
    tripped = guarded.state.trips & WITHDRAWN != 0
    still = as_mask(guarded.following.trips) & WITHDRAWN != 0
    assert_holds(guarded.doubles, tripped, z3.And(still, is_withdrawing(guarded.verdict)))


@proves(
    "W4",
    "Withdrawing, the drive has torque, unless the head is home; let go, it has none.",
    OF,
    FREE,
)
def test_a_withdrawal_has_torque(guarded: Guarded) -> None:
    reaction = guarded.verdict.reaction
    driven = lift_truth(guarded.allowed.insertion_on)
    claim = all_of(
        implies(is_(reaction, Reaction.WITHDRAW), z3.Or(driven, z3.Not(is_away(guarded)))),
        implies(is_(reaction, Reaction.TORQUE_OFF), z3.Not(driven)),
    )
    assert_holds(guarded.doubles, True, claim)


@pytest.mark.sweep
@proves(
    "W5",
    "As long as it withdraws a head that is not home, the clock of the withdrawal goes on in every "
    "tick, and so does its last clock, which nothing but a person's reset sets back, whatever is "
    "read; so does the one of waiting, but in ticks in which the head is seen to come by 1 mm/s.",
    OF,
    FREE,
)
def test_the_clocks_of_a_withdrawal_go_on(guarded: Guarded) -> None:
    doubles, seen = guarded.doubles, guarded.following.watch
    forced = z3.And(is_away(guarded), is_(guarded.verdict.reaction, Reaction.WITHDRAW))
    before, after = guarded.state.withdrawal, guarded.following.withdrawal
    comes = at_most(doubles, seen.speed_mm_per_s, -governor.LEAVING_MM_PER_S)
    claim = z3.And(
        goes_on(doubles, before.forced_s, after.forced_s),
        goes_on(doubles, before.whole_s, after.whole_s),
        z3.Or(comes, goes_on(doubles, before.waiting_s, after.waiting_s)),
    )
    assert_holds(doubles, forced, claim)
    assert_holds(doubles, True, at_most(doubles, before.whole_s, after.whole_s))


@proves(
    "W6",
    "A withdrawal that is past its time and has been waited for 4 s, that something has held for "
    ".3 s, or whose last clock is past the time of its whole way at 1 mm/s and 4 s (for an adult "
    "192 s), is let go in the next tick.",
    OF,
    FREE,
)
def test_a_withdrawal_ends(guarded: Guarded) -> None:
    doubles, clocks = guarded.doubles, guarded.state.withdrawal
    late = z3.And(
        below(doubles, guarded.limits.withdrawal_s, clocks.forced_s),
        below(doubles, governor.WAITING_S, clocks.waiting_s),
    )
    blocked = below(doubles, governor.BLOCKED_S, clocks.blocked_s)
    longest_s = Translation(doubles).run(governor.longest_s, guarded.limits)
    over = below(doubles, longest_s, clocks.whole_s)
    claim = is_(guarded.verdict.reaction, Reaction.TORQUE_OFF)
    assert_holds(doubles, z3.Or(late, blocked, over), claim)


@proves(
    "W7",
    "The clock of a phase goes on in every tick in which the phase does not change, and its limit "
    "stays, or grows by a tick: only in OPENING, as long as the valve is asked to be closed, in "
    "the first `build_most_s` of it. Past its limit, and after a trip, the event is raised that "
    "ends the phase (T1, W9).",
    "`cycle.step` and all that it calls, as for T2",
    "every step of the table; a limit that grows up to 1e6 s; everything else any value whatever",
)
def test_the_clock_of_a_phase_goes_on(cycle_tick: Tick) -> None:
    doubles, state, now = cycle_tick.doubles, cycle_tick.state, cycle_tick.now
    stays = as_integer(now.phase) == state.phase
    before, after = parts(state.limit_s), parts(now.limit_s)
    limit = all_of(*(one == other for one, other in zip(before, after, strict=True)))
    sized = within(doubles, state.limit_s, 1e6)
    # A tick is added, and rounded.
    longest = at_most(doubles, now.limit_s, plus(doubles, state.limit_s, 1.001 * DT_S))
    grown = z3.And(at_most(doubles, state.limit_s, now.limit_s), longest)
    clock = as_integer(now.phase_ticks) == state.phase_ticks + 1
    time_s = doubles.multiply(doubles.from_integer(state.phase_ticks), doubles.make(DT_S))
    over = below(doubles, state.limit_s, time_s)
    most_s = cycle_tick.plan.build_most_s
    built = z3.And(
        within(doubles, most_s, 1e6), at_most(doubles, plus(doubles, most_s, DT_S), time_s)
    )
    building = z3.And(
        is_(state.phase, Phase.OPENING), z3.Not(built), z3.Not(lift_truth(now.valve_open))
    )
    claim = all_of(
        implies(stays, clock),
        implies(z3.And(stays, z3.Not(building)), limit),
        implies(z3.And(stays, building, sized), z3.Or(limit, grown)),
        implies(over, has(cycle_tick.events, Event.PHASE_OVERDUE)),
        implies(cycle_tick.feedback.tripped, has(cycle_tick.events, Event.TRIPPED)),
    )
    assert_holds(doubles, cycle_tick.assumed, claim)


REQUESTED = tuple(event for event in Event if event >= Event.START_REQUESTED)
"""Only a person brings these about, or the schedule that a person has set."""


def longest_way(phase: Phase, before: tuple[Phase, ...] = ()) -> tuple[Phase, ...]:
    """The longest way through the table without a person. Fails where it comes round."""
    assert phase not in before, f"round and round: {[*before, phase]}"
    goals = {
        goal
        for (origin, event), goal in TRANSITIONS.items()
        if origin == phase and event not in REQUESTED
    }
    ways = [longest_way(goal, (*before, phase)) for goal in goals]
    return max(ways, key=len, default=(*before, phase))


@proves(
    "W8",
    "Without a person the table never comes round: every way through it ends at rest, after each "
    "phase at most once.",
    "`transition.TRANSITIONS`",
    "every row of the table",
)
@pytest.mark.parametrize("phase", list(Phase))
def test_the_table_never_comes_round(phase: Phase) -> None:
    assert longest_way(phase)[-1] in RESTING
    assert len(longest_way(Phase.CHECKING)) == len(CYCLE) + 2  # aborted at its end


@proves(
    "W9",
    "Every phase in which the machine does something is left for ABORTING by a trip, by a person "
    "and by its clock; ABORTING for HALTED by its own; PARKED for HALTED by a trip.",
    "`transition.TRANSITIONS`",
    "every row of the table",
)
@pytest.mark.parametrize("event", [Event.TRIPPED, Event.ABORT_REQUESTED, Event.PHASE_OVERDUE])
def test_every_phase_can_be_broken_off(event: Event) -> None:
    assert {TRANSITIONS.get((phase, event)) for phase in ACTIVE} == {Phase.ABORTING}
    assert set(Phase) == {*ACTIVE, *RESTING, Phase.ABORTING}
    assert TRANSITIONS[Phase.ABORTING, Event.PHASE_OVERDUE] == Phase.HALTED
    assert TRANSITIONS[Phase.PARKED, Event.TRIPPED] == Phase.HALTED
