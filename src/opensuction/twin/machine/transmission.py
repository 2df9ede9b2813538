"""Catheter in its conduit: head travel in, free tip travel out.

Clearance is distributed along the bends, so the tip answers as many plays of different width
side by side; friction against elastic stretch is one more narrow play in series; the polymer
creeps for seconds after the catheter has moved; and the gain changes slightly with depth. Width
is bend angle times diametral clearance: re-routing the conduit changes it.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import play, play_bundle
from opensuction.hysteresis.play_bundle import PLAYS, Bundle
from opensuction.kernel.compiled import compiled
from opensuction.kernel.tiny import drop_tiny

CREEP_VELOCITY_MM_PER_S = 3.0
"""Speed of the catheter at which half of the creep amplitude is drawn; assumed."""


class Transmission(NamedTuple):
    """Parameters of the catheter and its conduit."""

    widths_mm: Bundle
    """Full widths of the plays."""
    stretch_mm: float
    """Friction-limited elastic stretch: full width of the play in series."""
    gain: float
    """Tip travel for each mm of head travel, half-way down."""
    gain_per_mm: float
    """Change of that gain with depth, as a share of it."""
    middle_mm: float
    """Depth at which ``gain`` holds."""
    offset_mm: float
    """Tip position at depth 0."""
    creep_fast_mm: float
    creep_fast_per_s: float
    """Inverse of its time constant."""
    creep_slow_mm: float
    creep_slow_per_s: float


class TransmissionState(NamedTuple):
    """State of the catheter in its conduit."""

    plays_mm: Bundle
    stretch_mm: float
    """Position behind the elastic stretch."""
    head_mm: float
    creep_fast_mm: float
    creep_slow_mm: float
    tip_mm: float
    """Where the tip would be, were nothing in its way."""


def bundle(values: Iterable[float]) -> Bundle:
    """A number for each play. Raises ValueError for more or fewer."""
    found = tuple(float(value) for value in values)
    if len(found) != PLAYS:
        raise ValueError(f"a conduit has {PLAYS} plays, not {len(found)}")
    return found


def after_retract(transmission: Transmission, head_mm: float) -> TransmissionState:
    """State at rest after a long retract that ended with the head at ``head_mm``."""
    plays = bundle(head_mm + 0.5 * width_mm for width_mm in transmission.widths_mm)
    behind = float(np.mean(plays)) + 0.5 * transmission.stretch_mm
    return TransmissionState(
        plays_mm=plays,
        stretch_mm=behind,
        head_mm=head_mm,
        creep_fast_mm=0.0,
        creep_slow_mm=0.0,
        tip_mm=float(depth_mm(transmission, behind)),
    )


@compiled
def depth_mm(transmission: Transmission, behind_mm: float) -> float:
    """Tip position for a catheter position behind all clearance, without creep.

    The integral of ``gain * (1 + gain_per_mm * (depth - middle_mm))`` from depth 0.
    """
    change = transmission.gain_per_mm * (0.5 * behind_mm - transmission.middle_mm)
    return transmission.gain * behind_mm * (1.0 + change) + transmission.offset_mm


@compiled
def step(
    transmission: Transmission, state: TransmissionState, head_mm: float, dt_s: float
) -> TransmissionState:
    """Advance by one tick in which the head went to ``head_mm``."""
    plays = state.plays_mm
    behind = state.stretch_mm
    drawn = 0.0
    if head_mm != state.head_mm:
        plays, mean = play_bundle.step(transmission.widths_mm, plays, head_mm)
        behind = play.step(transmission.stretch_mm, behind, mean)
        # Crossing the clearance strains nothing: only the catheter's own motion counts.
        speed = (behind - state.stretch_mm) / dt_s
        drawn = speed / (abs(speed) + CREEP_VELOCITY_MM_PER_S)
    # Each mode relaxes towards what the motion draws; a tick is a 300th of any time constant.
    fast = state.creep_fast_mm + transmission.creep_fast_per_s * dt_s * (
        transmission.creep_fast_mm * drawn - state.creep_fast_mm
    )
    slow = state.creep_slow_mm + transmission.creep_slow_per_s * dt_s * (
        transmission.creep_slow_mm * drawn - state.creep_slow_mm
    )
    return TransmissionState(
        plays_mm=plays,
        stretch_mm=behind,
        head_mm=head_mm,
        creep_fast_mm=drop_tiny(fast),
        creep_slow_mm=drop_tiny(slow),
        tip_mm=depth_mm(transmission, behind) - fast - slow,
    )
