"""Creep of the catheter's polymer: what its motion draws out comes back over seconds.

Two modes, ``tau dz/dt = A v / (|v| + v0) - z`` with v the catheter's own speed.
"""

from typing import NamedTuple

import numpy as np

from opensuction.kernel.compiled import compiled
from opensuction.kernel.denormals import drop_tiny
from opensuction.kernel.record import Array

VELOCITY_MM_PER_S = 3.0
"""Speed of the catheter at which half of the amplitude is drawn; assumed."""


class Creep(NamedTuple):
    """Amplitudes and inverse time constants of the two modes."""

    fast_mm: float
    fast_per_s: float
    slow_mm: float
    slow_per_s: float


class CreepState(NamedTuple):
    """Lag of the tip, in either mode."""

    fast_mm: float
    slow_mm: float


NONE = CreepState(0.0, 0.0)


@compiled
def step(creep: Creep, state: CreepState, speed_mm_per_s: float, dt_s: float) -> CreepState:
    """Advance by one tick with the catheter at some speed."""
    drawn = 0.0
    if speed_mm_per_s != 0.0:
        drawn = speed_mm_per_s / (abs(speed_mm_per_s) + VELOCITY_MM_PER_S)
    # Each mode relaxes towards what the motion draws; a tick is a 300th of any time constant.
    fast = state.fast_mm + creep.fast_per_s * dt_s * (creep.fast_mm * drawn - state.fast_mm)
    slow = state.slow_mm + creep.slow_per_s * dt_s * (creep.slow_mm * drawn - state.slow_mm)
    return CreepState(fast_mm=drop_tiny(fast), slow_mm=drop_tiny(slow))


@compiled
def lag_mm(creep: Creep, behind_mm: Array, dt_s: float) -> Array:
    """Lag of a tip behind a catheter's own positions; shape (n,), from rest."""
    lags, state = np.empty(behind_mm.size), CreepState(0.0, 0.0)
    before_mm = behind_mm[0]
    for tick in range(behind_mm.size):
        state = step(creep, state, (behind_mm[tick] - before_mm) / dt_s, dt_s)
        before_mm = behind_mm[tick]
        lags[tick] = state.fast_mm + state.slow_mm
    return lags
