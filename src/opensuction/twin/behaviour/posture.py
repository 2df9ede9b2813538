"""Head and neck are moved now and then: the carina lies elsewhere, and the conduit bends otherwise.

Mostly between cycles: nobody turns a patient with a catheter inside, but for the patient.
"""

from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream
from opensuction.twin.behaviour import chance
from opensuction.twin.behaviour.chance import Chance

MOVING_S = 0.5
"""[assumed] Time constant of a move."""
FURTHEST = 10.0 / 3.0
"""Moves are cut off at this many standard deviations: 10 mm where one is 3."""


class Posture(NamedTuple):
    """Changes of one patient's posture: how often, and how far."""

    per_s: float
    """While no catheter is inside."""
    inside_share: float
    """Share of it while one is."""
    carina_mm: float
    """Standard deviation of the carina's depth over postures."""
    gap_ratio: float
    """Standard deviation of the conduit's gap over them, as a share of it."""


class PostureState(NamedTuple):
    """Posture of the patient at present."""

    carina_mm: float
    """How much deeper the carina is than at the start."""
    gap_ratio: float
    """Gap of the conduit over that at the start."""
    carina_goal_mm: float
    gap_goal_ratio: float
    coming: Chance


def settled(source: RandomStream) -> PostureState:
    """As at the start."""
    return PostureState(0.0, 1.0, 0.0, 1.0, chance.draw(source))


@compiled
def _cut(deviations: float) -> float:
    return min(max(deviations, -FURTHEST), FURTHEST)


@compiled
def _move(posture: Posture, state: PostureState) -> PostureState:
    """The patient is moved: both goals are drawn anew, for a move does not add to the last."""
    depth, bend, later = random_stream.normal_pair(state.coming.stream)
    return state._replace(
        carina_goal_mm=posture.carina_mm * _cut(depth),
        gap_goal_ratio=1.0 + posture.gap_ratio * _cut(bend),
        coming=chance.draw(later),
    )


@compiled
def step(posture: Posture, state: PostureState, inside: bool, dt_s: float) -> PostureState:
    """Advance by one step. inside: the catheter's tip is."""
    rate_per_s = posture.per_s
    if inside:
        rate_per_s *= posture.inside_share
    state = state._replace(coming=chance.wear(state.coming, rate_per_s, dt_s))
    if chance.is_due(state.coming):
        state = _move(posture, state)
    share = dt_s / (MOVING_S + dt_s)
    return state._replace(
        carina_mm=state.carina_mm + share * (state.carina_goal_mm - state.carina_mm),
        gap_ratio=state.gap_ratio + share * (state.gap_goal_ratio - state.gap_ratio),
    )
