"""Narrowing only narrows: what the governor lets through is never more than what was proposed.

Of all proposals, numbers or not, of all states and readings that are numbers, and of all limits
that are and that `settings_check` lets pass.
"""

from typing import Any, NamedTuple

import pytest
import z3

from opensuction.kernel.interface import Setpoints
from opensuction.safety.condition import Condition
from opensuction.safety.governor import judgement, limiter
from opensuction.safety.handling import Reaction
from opensuction.safety.limits import Limits
from opensuction.safety.watch.watch_state import Watch
from tests.proof.claim import (
    all_of,
    assert_holds,
    at_most,
    below,
    bounded,
    finite,
    has,
    implies,
    is_,
    is_finite,
    plus,
    same,
    within,
)
from tests.proof.table import proves
from tools.proof.abstract_double import AbstractDoubles
from tools.proof.arithmetic import Doubles
from tools.proof.logic import MASK_BITS, lift_truth
from tools.proof.translation import Translation, any_raises
from tools.proof.unknown import free

OF = "`limiter.narrow` and all that it calls"
FREE = (
    "doubles, abstractly: proposal any double, NaN and infinities too; state, readings and limits "
    "any finite ones; trips any mask; tick any finite time above 0"
)


class Narrowing(NamedTuple):
    """A tick of the limiter on unknowns."""

    doubles: AbstractDoubles
    translation: Translation
    limits: Limits
    last: Setpoints
    seen: Watch
    proposal: Setpoints
    trips: Any
    allowed: Setpoints
    reaction: Any
    assumed: z3.BoolRef
    """Of the limits what `settings_check` holds; and an impossible proposal has its trip."""


def possible(doubles: Doubles, proposal: Setpoints) -> z3.BoolRef:
    """Whether a proposal is of numbers, and its vacuum not below 0."""
    return all_of(
        is_finite(doubles, proposal.head_mm),
        is_finite(doubles, proposal.head_mm_per_s),
        is_finite(doubles, proposal.vacuum_mmhg),
        at_most(doubles, 0.0, proposal.vacuum_mmhg),
    )


def narrow(dt_s: float | None) -> Narrowing:
    doubles = AbstractDoubles()
    translation = Translation(doubles)
    limits, last = finite(doubles, Limits, "limits"), finite(doubles, Setpoints, "last")
    seen, proposal = finite(doubles, Watch, "seen"), free(doubles, Setpoints, "proposal")
    trips = z3.BitVec("trips", MASK_BITS)
    tick_s = doubles.free_finite("dt_s") if dt_s is None else dt_s
    allowed, reaction = translation.run(limiter.narrow, limits, last, seen, proposal, trips, tick_s)
    assumed = all_of(
        z3.Or(possible(doubles, proposal), has(trips, Condition.PROPOSAL_INVALID)),
        below(doubles, 0.0, limits.tip.gain),
        below(doubles, 0.0, limits.head_mm_per_s2),
        below(doubles, 0.0, limits.head_speed_mm_per_s),
        below(doubles, 0.0, tick_s),
    )
    return Narrowing(
        doubles, translation, limits, last, seen, proposal, trips, allowed, reaction, assumed
    )


@pytest.fixture(scope="module")
def tick() -> Narrowing:
    return narrow(None)


@proves(
    "N1",
    "The limiter raises nothing: it never divides by zero.",
    OF,
    FREE,
)
def test_the_limiter_never_raises(tick: Narrowing) -> None:
    assert_holds(tick.doubles, tick.assumed, z3.Not(any_raises(tick.translation)))


@proves(
    "N2",
    "The valve is let open, the pump let run only where that was proposed.",
    OF,
    FREE,
)
def test_valve_and_pump_are_never_more_than_proposed(tick: Narrowing) -> None:
    valve = implies(tick.allowed.valve_open, tick.proposal.valve_open)
    pump = implies(tick.allowed.pump_on, tick.proposal.pump_on)
    assert_holds(tick.doubles, tick.assumed, all_of(valve, pump))


@proves(
    "N3",
    "The vacuum let through is not above the one proposed; where that is impossible it is 0, the "
    "valve closed and the pump off.",
    OF,
    FREE,
)
def test_vacuum_is_never_more_than_proposed(tick: Narrowing) -> None:
    allowed, doubles = tick.allowed, tick.doubles
    cut = all_of(
        same(doubles, allowed.vacuum_mmhg, 0.0),
        z3.Not(lift_truth(allowed.valve_open)),
        z3.Not(lift_truth(allowed.pump_on)),
    )
    less = at_most(doubles, allowed.vacuum_mmhg, tick.proposal.vacuum_mmhg)
    claim = z3.And(z3.Or(less, cut), implies(z3.Not(possible(doubles, tick.proposal)), cut))
    assert_holds(doubles, tick.assumed, claim)


@proves(
    "N4",
    "The drive has torque only where that was proposed, or to withdraw.",
    OF,
    FREE,
)
def test_torque_is_never_more_than_proposed(tick: Narrowing) -> None:
    withdraws = is_(tick.reaction, Reaction.WITHDRAW)
    claim = implies(tick.allowed.insertion_on, z3.Or(tick.proposal.insertion_on, withdraws))
    assert_holds(tick.doubles, tick.assumed, claim)


@proves(
    "N5",
    "With torque, the head's command goes further in than the last one only as far as proposed, "
    "and never while the governor withdraws.",
    OF,
    FREE,
)
def test_the_command_goes_no_further_in_than_proposed(tick: Narrowing) -> None:
    head_mm, doubles = tick.allowed.head_mm, tick.doubles
    inwards = z3.And(
        lift_truth(tick.allowed.insertion_on), z3.Not(at_most(doubles, head_mm, tick.last.head_mm))
    )
    milder = z3.Not(is_(tick.reaction, Reaction.WITHDRAW))
    proposed = at_most(doubles, head_mm, tick.proposal.head_mm)
    assert_holds(doubles, tick.assumed, implies(inwards, z3.And(milder, proposed)))


@proves(
    "N6",
    "A speed inwards is let through only with a command that goes further in: never where the "
    "command stands, is held back or withdraws.",
    OF,
    FREE,
)
def test_the_velocity_goes_in_only_with_the_command(tick: Narrowing) -> None:
    doubles, allowed = tick.doubles, tick.allowed
    inwards = z3.And(
        lift_truth(allowed.insertion_on), z3.Not(at_most(doubles, allowed.head_mm_per_s, 0.0))
    )
    assert_holds(
        doubles, tick.assumed, implies(inwards, below(doubles, tick.last.head_mm, allowed.head_mm))
    )


@proves(
    "N7",
    "While it withdraws with torque, the command is neither further in than the last one nor "
    "than where the head is.",
    OF,
    FREE,
)
def test_a_withdrawal_is_commanded_outwards_of_the_head(tick: Narrowing) -> None:
    doubles, head_mm = tick.doubles, tick.allowed.head_mm
    withdraws = z3.And(lift_truth(tick.allowed.insertion_on), is_(tick.reaction, Reaction.WITHDRAW))
    behind = z3.And(
        at_most(doubles, head_mm, tick.last.head_mm), at_most(doubles, head_mm, tick.seen.head_mm)
    )
    assert_holds(doubles, tick.assumed, implies(withdraws, behind))


@proves(
    "N8",
    "Where it is held (the valve not closed) the command goes in no further than .5 mm beyond "
    "the least head position since the valve opened (but for rounding: 1e-6 mm); with contact not "
    "at all.",
    OF,
    FREE + "; the valve opened within 1e6 mm",
)
def test_no_advance_under_vacuum(tick: Narrowing) -> None:
    doubles, allowed, seen = tick.doubles, tick.allowed, tick.seen
    inwards = z3.And(
        lift_truth(allowed.insertion_on),
        z3.Not(at_most(doubles, allowed.head_mm, tick.last.head_mm)),
    )
    held = z3.Or(lift_truth(allowed.valve_open), below(doubles, 0.0, seen.durations.sucking_s))
    near = within(doubles, seen.suction_start_mm, 1e6)
    furthest_mm = plus(doubles, seen.suction_start_mm, limiter.ADVANCE_MM + 1e-6)
    touching = below(doubles, 0.0, seen.durations.contact_s)
    claim = z3.And(implies(held, at_most(doubles, allowed.head_mm, furthest_mm)), z3.Not(touching))
    assert_holds(doubles, z3.And(tick.assumed, near), implies(inwards, claim))


@proves(
    "N9",
    "The commanded speed inwards is not above its limit (but for rounding: 1e-5 mm/s).",
    OF,
    "as before, within 1e6 mm and a tick of 1 ms",
)
def test_the_command_is_no_faster_than_its_limit() -> None:
    tick = narrow(0.001)
    doubles = tick.doubles
    near = all_of(
        *(
            z3.And(at_most(doubles, -1e6, one), at_most(doubles, one, 1e6))
            for one in (tick.last.head_mm, tick.seen.head_mm, tick.limits.head_speed_mm_per_s)
        )
    )
    most = plus(doubles, tick.limits.head_speed_mm_per_s, 1e-5)
    claim = implies(tick.allowed.insertion_on, at_most(doubles, tick.allowed.head_mm_per_s, most))
    assert_holds(doubles, z3.And(tick.assumed, near), claim)


@proves(
    "N10",
    "An impossible proposal has its trip in the very tick: what N1 to N8 take for granted.",
    "`judgement.judge` and all that it calls",
    "doubles, abstractly: limits and what is seen any doubles whatever, NaN too; but for what it "
    "divides by",
)
def test_an_impossible_proposal_trips_at_once() -> None:
    doubles = AbstractDoubles()
    translation = Translation(doubles)
    limits = free(doubles, Limits, "limits", bounded(doubles, {"tip.gain": (1e-6, 1e6)}))
    seen = free(doubles, Watch, "seen")
    proposal = free(doubles, Setpoints, "proposal")
    trips = translation.run(judgement.judge, limits, seen, proposal, z3.Bool("opened"))
    impossible = z3.Not(possible(doubles, proposal))
    assert_holds(doubles, True, has(trips, Condition.PROPOSAL_INVALID) == impossible)
    assert_holds(doubles, True, z3.Not(any_raises(translation)))
