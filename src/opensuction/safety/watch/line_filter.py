"""The vacuum sensor's reading without its noise and without its offset.

White noise of some mmHg lies in every reading and says nothing; what the line does takes longer. A
vented line is at the room's pressure: what is read there is the sensor's offset, as far as a sound
one can have it. A larger one stays in the reading, and the pre-use test refuses it.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.denormals import drop_tiny
from opensuction.kernel.readings import Readings, is_number
from opensuction.kernel.record import make_zero

FILTER_S = 0.02
"""Time constant of the filter: of white noise a sixth is left, of a loss 20 ms are [computed]."""
ZERO_MMHG = 7.0
"""Offset up to which it is taken for the sensor's: 1 % of 500 mmHg, drift and what is left of the
noise; assumed."""
ZERO_S = 0.2
"""Time constant over which the offset is learnt; the pre-use test begins with a second without a
pump."""


class LineFilter(NamedTuple):
    """The reading, as it came and as it is taken."""

    raw_mmhg: float
    """Last reading that was one."""
    smooth_mmhg: float
    """It without its noise."""
    zero_mmhg: float
    """What of it is the sensor's offset."""
    heard: bool
    """There has been one: the first is believed at once."""


START = make_zero(LineFilter)


@compiled
def vacuum_mmhg(state: LineFilter) -> float:
    """Vacuum in the line, as far as it is known."""
    return state.smooth_mmhg - state.zero_mmhg


@compiled
def step(state: LineFilter, readings: Readings, vented: bool, dt_s: float) -> LineFilter:
    """Bring it up to this tick. vented: neither pump nor set point in the last tick."""
    raw = readings.line_vacuum_mmhg
    if not (readings.vacuum_valid and is_number(raw)):
        return state
    smooth = raw
    if state.heard:
        smooth = state.smooth_mmhg + (raw - state.smooth_mmhg) * (dt_s / (FILTER_S + dt_s))
    zero = state.zero_mmhg
    if vented and abs(smooth) <= ZERO_MMHG:
        zero += (smooth - zero) * (dt_s / (ZERO_S + dt_s))
    return LineFilter(
        raw_mmhg=raw, smooth_mmhg=drop_tiny(smooth), zero_mmhg=drop_tiny(zero), heard=True
    )
