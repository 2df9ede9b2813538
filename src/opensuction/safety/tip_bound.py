"""Deepest and shallowest possible position of the tip; there is no tip sensor.

Between the head and the tip lies a gap whose width is known only between two bounds. Behind a gap
of width w the catheter follows the head as ``p = min(max(p, head - w/2), head + w/2)``; the
interval that is kept here holds p for every w between the bounds, also one that changes on the way.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled

GAP_LEAST = 0.7
"""Share of the identified gap that it may have shrunk to before the bound fails."""
GAP_MOST = 1.3
"""Share of the identified gap that it may have grown to."""


class TipBounds(NamedTuple):
    """Bounds on the tip's lead and lag against the head."""

    gain: float
    """Tip travel for each mm of head travel."""
    offset_mm: float
    narrow_mm: float
    """Head travel across the narrowest gap thought possible."""
    wide_mm: float


class TipInterval(NamedTuple):
    """Interval of the catheter behind the gap, in head travel."""

    foremost_mm: float
    rearmost_mm: float


def bound_tip(gain: float, offset_mm: float, gap_mm: float) -> TipBounds:
    """Bounds around an identified (or nominal) gap of the transmission.

    gap_mm: full width, mm of tip between the advancing and the retracting branch.
    """
    return TipBounds(
        gain=gain,
        offset_mm=offset_mm,
        narrow_mm=GAP_LEAST * gap_mm / gain,
        wide_mm=GAP_MOST * gap_mm / gain,
    )


@compiled
def assume_anywhere(bounds: TipBounds, head_mm: float) -> TipInterval:
    """Interval when nothing is known of how the head came here: after a retract, or an advance."""
    return TipInterval(
        foremost_mm=head_mm + 0.5 * bounds.wide_mm, rearmost_mm=head_mm - 0.5 * bounds.wide_mm
    )


@compiled
def follow(bounds: TipBounds, interval: TipInterval, head_mm: float) -> TipInterval:
    """Interval once the head has been measured at ``head_mm``.

    Foremost: pushing in, the narrowest gap brings the catheter furthest; drawing out, the widest
    holds it longest. Rearmost: the mirror image. The plays of the two extreme widths alone do not
    bound those between them: after a reversal a middle gap is the last to follow.
    """
    narrow_mm, wide_mm = 0.5 * bounds.narrow_mm, 0.5 * bounds.wide_mm
    return TipInterval(
        foremost_mm=min(max(interval.foremost_mm, head_mm - narrow_mm), head_mm + wide_mm),
        rearmost_mm=min(max(interval.rearmost_mm, head_mm - wide_mm), head_mm + narrow_mm),
    )


@compiled
def deepest_mm(bounds: TipBounds, interval: TipInterval) -> float:
    """Deepest tip position that is possible."""
    return bounds.gain * interval.foremost_mm + bounds.offset_mm


@compiled
def shallowest_mm(bounds: TipBounds, interval: TipInterval) -> float:
    """Shallowest tip position that is possible."""
    return bounds.gain * interval.rearmost_mm + bounds.offset_mm


@compiled
def head_cap_mm(bounds: TipBounds, cap_mm: float) -> float:
    """Head position beyond which an advance could take the tip past the cap."""
    return (cap_mm - bounds.offset_mm) / bounds.gain + 0.5 * bounds.narrow_mm
