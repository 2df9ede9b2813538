"""The limits of one patient on one machine, and the interval in which the tip can be."""

from typing import NamedTuple

from opensuction.hysteresis import play
from opensuction.kernel.compiled import compiled

GAP_LEAST = 0.7
"""Share of the identified gap that it may have shrunk to before the interval fails."""
GAP_MOST = 1.3
"""Share of the identified gap that it may have grown to."""


class TipBounds(NamedTuple):
    """How far the tip can be ahead of or behind the head: there is no tip sensor."""

    gain: float
    """Tip travel for each mm of head travel."""
    offset_mm: float
    narrow_mm: float
    """Full width of the narrowest gap thought possible."""
    wide_mm: float


class TipInterval(NamedTuple):
    """The gap's two extremes, each as a play that follows the measured head."""

    narrow_mm: float
    wide_mm: float


class Limits(NamedTuple):
    """What the governor holds. Every value is set for the patient; none has a default."""

    tip: TipBounds
    cap_mm: float
    """Deepest tip position ever allowed."""
    outside_mm: float
    """The deepest end of the interval is above this: the tip is out of the patient."""
    park_head_mm: float
    head_speed_mm_per_s: float
    following_mm: float
    """Largest distance between commanded and measured head."""
    vacuum_mmhg: float
    """Highest line vacuum."""
    negative_pressure_s: float
    in_airway_s: float
    contact_s: float
    withdrawal_s: float
    """Longest time a forced withdrawal may take before torque is cut."""


def tip_bounds(gain: float, offset_mm: float, gap_mm: float) -> TipBounds:
    """Bounds around an identified (or nominal) gap of the transmission, full width in mm."""
    return TipBounds(
        gain=gain,
        offset_mm=offset_mm,
        narrow_mm=GAP_LEAST * gap_mm,
        wide_mm=GAP_MOST * gap_mm,
    )


def retracted(bounds: TipBounds, head_mm: float) -> TipInterval:
    """Interval after a long retract that ended with the head at ``head_mm``."""
    return TipInterval(
        narrow_mm=head_mm + 0.5 * bounds.narrow_mm, wide_mm=head_mm + 0.5 * bounds.wide_mm
    )


def anywhere(bounds: TipBounds, head_mm: float) -> TipInterval:
    """Interval when nothing is known of how the head came to ``head_mm``: the deepest it can be."""
    return retracted(bounds, head_mm)


@compiled
def follow(bounds: TipBounds, interval: TipInterval, head_mm: float) -> TipInterval:
    """Advance the interval to a measured head position."""
    return TipInterval(
        narrow_mm=play.step(bounds.narrow_mm, interval.narrow_mm, head_mm),
        wide_mm=play.step(bounds.wide_mm, interval.wide_mm, head_mm),
    )


@compiled
def deepest_mm(bounds: TipBounds, interval: TipInterval) -> float:
    """Deepest tip position that is possible."""
    return bounds.gain * max(interval.narrow_mm, interval.wide_mm) + bounds.offset_mm


@compiled
def head_cap_mm(bounds: TipBounds, cap_mm: float) -> float:
    """Head position beyond which an advance could take the tip past the cap."""
    return (cap_mm - bounds.offset_mm) / bounds.gain + 0.5 * bounds.narrow_mm
