"""A person's hand on the catheter head while the insertion drive's torque is off.

The hand imposes a speed: it is stronger than friction and shorted motor together ([computed] 1.3 N
of friction, at most 5 N of braking at the drive's current limit; a hand gives tens of newtons), so
the axis follows it, and encoder, gear, conduit and tip follow the axis as they always do. It feels
the force at the tip, which [assumed] reaches it through the catheter it grips, and answers after
its reaction time. While the drive has torque the hand yields to it.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero
from opensuction.twin.machine.dc_axis import AxisMotion
from opensuction.twin.parameter import SPREAD_LIMIT
from opensuction.twin.parameter_row import Parameter

HAND_PURPOSE = 2_000_000
"""Streams from here on draw the hands of run 0, 1, 2, ..."""

PARAMETERS: dict[str, Parameter] = {
    "quick_mm_per_s": Parameter(25.0, 2.0, "mm/s", "speed inside the tube", "[assumed]", 5.0, 60.0),
    "slow_mm_per_s": Parameter(
        8.0,
        0.8,
        "mm/s",
        "speed beyond it",
        "[assumed] below the 10 of nurses, [paper] II-A",
        2.0,
        20.0,
    ),
    "out_mm_per_s": Parameter(30.0, 3.0, "mm/s", "speed on the way back", "[assumed]", 5.0, 60.0),
    "acceleration_mm_per_s2": Parameter(
        150.0, 0.0, "mm/s2", "of the hand", "[assumed]", 50.0, 1000.0
    ),
    "felt_n": Parameter(
        0.08,
        0.01,
        "N",
        "force at the tip that is felt",
        "[assumed] as the contact switch's",
        0.02,
        0.3,
    ),
    "reaction_s": Parameter(0.25, 0.04, "s", "from feeling to stopping", "[assumed]", 0.1, 1.0),
    "confirm_s": Parameter(
        0.2,
        0.04,
        "s",
        "from stopping to confirming",
        "[assumed] a button under the thumb",
        0.05,
        2.0,
    ),
    "hold_s": Parameter(0.1, 0.0, "s", "from confirming to drawing back", "[assumed]", 0.05, 5.0),
    "mark_mm": Parameter(
        0.0, 0.15, "mm", "error of the mark at which it lets go", "[assumed]", -2.0, 2.0
    ),
}
"""How people push: value, spread between people, unit, meaning, source, plausible range."""


class HandStage(IntEnum):
    """Stage of the hand's action."""

    AWAY = 0
    PUSHING = 1
    HOLDING = 2
    PULLING = 3
    LET_GO = 4


class Hand(NamedTuple):
    """Parameters of a hand; see `PARAMETERS`."""

    present: bool
    quick_until_mm: float
    """Head position up to which it pushes quickly: the tube's length on the scale."""
    quick_mm_per_s: float
    slow_mm_per_s: float
    out_mm_per_s: float
    acceleration_mm_per_s2: float
    felt_n: float
    reaction_s: float
    confirm_s: float
    hold_s: float
    park_mm: float
    """Head position at which it lets go."""


class HandState(NamedTuple):
    """State of the hand."""

    stage: int
    stage_s: float
    felt_s: float
    """Time since the tip's resistance was felt; 0 before."""


NOBODY = make_zero(Hand)
"""No hand is at the machine."""
AWAY = make_zero(HandState)
PUSHING = AWAY._replace(stage=1)


def draw(park_head_mm: float, quick_mm: float, seed: int, run: int) -> Hand:
    """A person's hand. park_head_mm: where the head is parked. quick_mm: length of the tube way.

    seed, run: draw the person.
    """
    source = random_stream.stream(seed, HAND_PURPOSE + run)
    values = {}
    for name, parameter in PARAMETERS.items():
        draw, _, source = random_stream.normal_pair(source)
        cut = min(max(draw, -SPREAD_LIMIT), SPREAD_LIMIT)
        values[name] = parameter.value + parameter.spread * cut
    mark_mm = values.pop("mark_mm")
    return Hand(
        present=True,
        quick_until_mm=park_head_mm + quick_mm,
        park_mm=park_head_mm + mark_mm,
        **values,
    )


@compiled
def is_gripping(state: HandState) -> bool:
    """True where the hand decides the head's position."""
    return state.stage in (HandStage.PUSHING, HandStage.HOLDING, HandStage.PULLING)


def confirms_in_s(hand: Hand, state: HandState) -> float:
    """Time until the hand presses the button, s; at most 0 once it is due.

    While it has felt nothing, the least that is left; infinite for a hand that no longer will.
    """
    if state.stage == HandStage.PUSHING:
        return hand.reaction_s - state.felt_s + hand.confirm_s
    return hand.confirm_s - state.stage_s if state.stage == HandStage.HOLDING else math.inf


@compiled
def _wanted_mm_per_s(hand: Hand, stage: int, head_mm: float) -> float:
    if stage == HandStage.PUSHING:
        return hand.quick_mm_per_s if head_mm < hand.quick_until_mm else hand.slow_mm_per_s
    if stage == HandStage.PULLING:
        # It slows down before the mark.
        left_s = (head_mm - hand.park_mm) * 5.0
        return -min(hand.out_mm_per_s, max(left_s, hand.slow_mm_per_s * 0.1))
    return 0.0


@compiled
def _next_stage(hand: Hand, state: HandState, head_mm: float, felt_s: float) -> int:
    stage = state.stage
    if stage == HandStage.PUSHING and felt_s > hand.reaction_s:
        return HandStage.HOLDING
    if stage == HandStage.HOLDING and state.stage_s >= hand.confirm_s + hand.hold_s:
        return HandStage.PULLING
    if stage == HandStage.PULLING and head_mm <= hand.park_mm:
        return HandStage.LET_GO
    return stage


@compiled
def step(
    hand: Hand, state: HandState, motion: AxisMotion, contact_n: float, dt_s: float
) -> tuple[HandState, AxisMotion]:
    """Advance hand and axis by one tick; the drive's torque is off.

    contact_n: force at the tip.
    """
    felt_s = state.felt_s
    if state.stage == HandStage.PUSHING and (contact_n >= hand.felt_n or felt_s > 0.0):
        felt_s += dt_s
    stage = _next_stage(hand, state, motion.position, felt_s)
    stage_s = state.stage_s + dt_s if stage == state.stage else 0.0
    reach = hand.acceleration_mm_per_s2 * dt_s
    wanted = _wanted_mm_per_s(hand, stage, motion.position)
    velocity = min(max(wanted, motion.velocity - reach), motion.velocity + reach)
    position = motion.position + 0.5 * (motion.velocity + velocity) * dt_s
    return (
        HandState(stage=stage, stage_s=stage_s, felt_s=felt_s),
        AxisMotion(position=position, velocity=velocity, drive_v=0.0),
    )
