"""Artefacts of the oximeter: a value that is too low, an old value, or none.

Motion and cold fingers cause them: they come by chance, and more often when the patient coughs. The
true saturation does not change.
"""

from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream
from opensuction.kernel.readings import Monitor
from opensuction.twin.behaviour import chance
from opensuction.twin.behaviour.chance import Chance

SHORTEST_S, LONGEST_S = 2.0, 12.0
"""[assumed] How long one lasts."""
LARGEST_PERCENT = 15.0
"""[assumed] Reads by so much too low at most."""
LOW_SHARE, FROZEN_SHARE = 0.5, 0.25
"""[assumed] So many read too low, so many stand still; the others are missing."""
RESTLESS_S = 5.0
"""[assumed] How long after the start of a cough a finger moves."""


class Artefact(NamedTuple):
    """Rate of artefacts of one patient's oximeter."""

    per_s: float
    cough_ratio: float
    """Times as often during a cough."""


class ArtefactState(NamedTuple):
    """Artefact of the present, if there is any."""

    left_s: float
    """For so long still; at most 0 where nothing is."""
    low_percent: float
    """Reads by so much too low."""
    is_frozen: bool
    frozen_percent: float
    """What it then shows."""
    is_missing: bool
    coming: Chance


def clear(source: RandomStream) -> ArtefactState:
    """Nothing is wrong."""
    return ArtefactState(0.0, 0.0, False, 0.0, False, chance.draw(source))


@compiled
def _begin(state: ArtefactState, spo2_percent: float) -> ArtefactState:
    kind = state.coming.share
    lasts, depth, later = random_stream.uniform_pair(state.coming.stream)
    is_low = kind < LOW_SHARE
    is_frozen = LOW_SHARE <= kind < LOW_SHARE + FROZEN_SHARE
    low_percent = 0.0
    if is_low:
        low_percent = LARGEST_PERCENT * depth
    return ArtefactState(
        left_s=chance.between(SHORTEST_S, LONGEST_S, lasts),
        low_percent=low_percent,
        is_frozen=is_frozen,
        frozen_percent=spo2_percent,
        is_missing=not (is_low or is_frozen),
        coming=chance.draw(later),
    )


@compiled
def step(
    artefact: Artefact,
    state: ArtefactState,
    coughed_since_s: float,
    spo2_percent: float,
    dt_s: float,
) -> ArtefactState:
    """Advance by one step.

    coughed_since_s: time since the start of the last cough. spo2_percent: what is right.
    """
    if state.left_s > 0.0:
        return state._replace(left_s=state.left_s - dt_s)
    rate_per_s = artefact.per_s
    if coughed_since_s < RESTLESS_S:
        rate_per_s *= artefact.cough_ratio
    state = state._replace(coming=chance.wear(state.coming, rate_per_s, dt_s))
    if chance.is_due(state.coming):
        return _begin(state, spo2_percent)
    return state


@compiled
def distort(state: ArtefactState, monitor: Monitor) -> Monitor:
    """Distort the monitor's values by an artefact; a value that is missing anyway stays so."""
    if state.left_s <= 0.0 or not monitor.spo2_valid:
        return monitor
    if state.is_missing:
        return monitor._replace(spo2_percent=0.0, spo2_valid=False)
    if state.is_frozen:
        return monitor._replace(spo2_percent=state.frozen_percent)
    return monitor._replace(spo2_percent=max(monitor.spo2_percent - state.low_percent, 0.0))
