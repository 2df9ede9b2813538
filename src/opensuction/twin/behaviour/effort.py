"""Own breaths: the patient pulls now and then, at no time that the ventilator has agreed to.

The ventilator is triggered by none of them; it gives what its pressure control lets through.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream
from opensuction.twin.behaviour import chance
from opensuction.twin.behaviour.chance import Chance

SOONEST, LATEST = 0.6, 1.4
"""[assumed] Time between two breaths lies between these shares of the mean."""
WEAKEST, STRONGEST = 0.6, 1.4
"""[assumed] Their pressures likewise."""
LONGEST_S = 1.0
"""[assumed] How long a breath pulls at most."""
LONGEST_SHARE = 0.4
"""[assumed] And at most this share of the mean time between two."""


class Effort(NamedTuple):
    """Breathing of one patient against the ventilator."""

    per_s: float
    """0 for nobody who breathes."""
    peak_cmh2o: float
    """Usual highest pull of the muscles, positive."""


class EffortState(NamedTuple):
    """The breath that is, or was last, and the next one."""

    left_s: float
    """Time until the next."""
    since_s: float
    """Time since the last began."""
    peak_cmh2o: float
    """Its pull."""
    coming: Chance
    """Only its random numbers are used: these breaths come nearly evenly."""


def silent(effort: Effort, source: RandomStream) -> EffortState:
    """Between two breaths."""
    coming = chance.draw(source)
    left_s = coming.share / effort.per_s if effort.per_s > 0.0 else 0.0
    return EffortState(left_s, since_s=LONGEST_S, peak_cmh2o=0.0, coming=coming)


@compiled
def pressure_cmh2o(effort: Effort, state: EffortState) -> float:
    """Pressure of the muscles on the lung, at most 0."""
    if effort.per_s <= 0.0:
        return 0.0
    lasts_s = min(LONGEST_S, LONGEST_SHARE / effort.per_s)
    if state.since_s >= lasts_s:
        return 0.0
    return -state.peak_cmh2o * math.sin(math.pi * state.since_s / lasts_s)


@compiled
def step(effort: Effort, state: EffortState, dt_s: float) -> EffortState:
    """Advance by one step."""
    if effort.per_s <= 0.0:
        return state
    left_s = state.left_s - dt_s
    if left_s > 0.0:
        return state._replace(left_s=left_s, since_s=state.since_s + dt_s)
    drawn = chance.draw(state.coming.stream)
    # Two uniform numbers: the one that an event's time is drawn from, and the other.
    return EffortState(
        left_s=chance.between(SOONEST, LATEST, math.exp(-drawn.left)) / effort.per_s,
        since_s=0.0,
        peak_cmh2o=effort.peak_cmh2o * chance.between(WEAKEST, STRONGEST, drawn.share),
        coming=drawn,
    )
