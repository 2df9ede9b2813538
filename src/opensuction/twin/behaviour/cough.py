"""Coughs: some come by themselves, more while a catheter stimulates the airway.

A cough is a short effort to breathe in, then a push of the muscles of expiration. The tube keeps
the glottis open, so nothing is held back first: pressure and flow rise together.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream
from opensuction.twin.behaviour import chance
from opensuction.twin.behaviour.chance import Chance

INSPIRATION_S = 0.3
"""[assumed] How long the effort before the push lasts."""
INSPIRED_SHARE = 0.1
"""[assumed] Its pressure, as a share of the push's."""
WEAKEST, STRONGEST = 0.6, 1.4
"""[assumed] A patient's coughs lie between these shares of the usual one."""
NEVER_S = 1.0e9
"""Time since the last cough of somebody who has not coughed yet."""


class Cough(NamedTuple):
    """Coughs of one patient."""

    spontaneous_per_s: float
    provoked_per_s: float
    """More of them at the strongest stimulus; see `opensuction.twin.patient.heart.stimulus`."""
    peak_cmh2o: float
    """Highest pressure of the muscles in a usual cough."""
    push_s: float
    """How long they push."""
    refractory_s: float
    """Least time from the end of a cough to the next."""


class CoughState(NamedTuple):
    """The cough that is, or was last."""

    since_s: float
    """Time since it began."""
    peak_cmh2o: float
    coming: Chance


def silent(source: RandomStream) -> CoughState:
    """Nobody has coughed yet."""
    return CoughState(since_s=NEVER_S, peak_cmh2o=0.0, coming=chance.draw(source))


@compiled
def pressure_cmh2o(cough: Cough, state: CoughState) -> float:
    """Pressure of the muscles on the lung; below 0 while the patient breathes in for it."""
    pushed_s = state.since_s - INSPIRATION_S
    if pushed_s >= cough.push_s:
        return 0.0
    if pushed_s < 0.0:
        wave = math.sin(math.pi * state.since_s / INSPIRATION_S)
        return -INSPIRED_SHARE * state.peak_cmh2o * wave * wave
    wave = math.sin(math.pi * pushed_s / cough.push_s)
    return state.peak_cmh2o * wave * wave


@compiled
def step(cough: Cough, state: CoughState, stimulus: float, dt_s: float) -> CoughState:
    """Advance by one step. stimulus: of the airway by the catheter, 0 to 1."""
    since_s = state.since_s + dt_s
    if since_s < INSPIRATION_S + cough.push_s + cough.refractory_s:
        return state._replace(since_s=since_s)
    rate_per_s = cough.spontaneous_per_s + cough.provoked_per_s * stimulus
    coming = chance.wear(state.coming, rate_per_s, dt_s)
    if not chance.is_due(coming):
        return state._replace(since_s=since_s, coming=coming)
    return CoughState(
        since_s=0.0,
        peak_cmh2o=cough.peak_cmh2o * chance.between(WEAKEST, STRONGEST, coming.share),
        coming=chance.draw(coming.stream),
    )
