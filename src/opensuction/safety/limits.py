"""The limits of one patient on one machine, and how deep the tip can be: there is no tip sensor."""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.safety.patient_watch import PatientLimits

GAP_LEAST = 0.7
"""Share of the identified gap that it may have shrunk to before the bound fails."""
GAP_MOST = 1.3
"""Share of the identified gap that it may have grown to."""


class TipBounds(NamedTuple):
    """How far the tip can be ahead of or behind the head."""

    gain: float
    """Tip travel for each mm of head travel."""
    offset_mm: float
    narrow_mm: float
    """Head travel across the narrowest gap thought possible."""
    wide_mm: float


class Limits(NamedTuple):
    """What the governor holds. Every value is set for the patient; none has a default."""

    tip: TipBounds
    cap_mm: float
    """Deepest tip position ever allowed."""
    outside_mm: float
    """The deepest possible tip is above this: it is out of the patient."""
    park_head_mm: float
    head_speed_mm_per_s: float
    following_mm: float
    """Largest distance between commanded and measured head."""
    stalled_mm: float
    """Distance from its command at which the servo must be moving the head, whatever friction."""
    vacuum_mmhg: float
    """Highest line vacuum."""
    negative_pressure_s: float
    in_airway_s: float
    contact_s: float
    withdrawal_s: float
    """Longest time a forced withdrawal may take before torque is cut."""
    patient: PatientLimits


def tip_bounds(gain: float, offset_mm: float, gap_mm: float) -> TipBounds:
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
def anywhere(bounds: TipBounds, head_mm: float) -> float:
    """Foremost position when nothing is known of how the head came here: as after a retract."""
    return head_mm + 0.5 * bounds.wide_mm


@compiled
def follow(bounds: TipBounds, foremost_mm: float, head_mm: float) -> float:
    """Foremost position behind the gap, once the head has been measured at ``head_mm``.

    Behind a gap of width w the catheter follows ``p = min(max(p, head - w/2), head + w/2)``. No
    p for any w between narrow and wide is ever above the value returned: pushing in, the narrowest
    gap brings it furthest; drawing out, the widest holds it longest. The plays of the two extremes
    alone do not bound those between them: after a turn a middle gap is the last to follow.
    """
    pushed_mm = max(foremost_mm, head_mm - 0.5 * bounds.narrow_mm)
    return min(pushed_mm, head_mm + 0.5 * bounds.wide_mm)


@compiled
def deepest_mm(bounds: TipBounds, foremost_mm: float) -> float:
    """Deepest tip position that is possible."""
    return bounds.gain * foremost_mm + bounds.offset_mm


@compiled
def head_cap_mm(bounds: TipBounds, cap_mm: float) -> float:
    """Head position beyond which an advance could take the tip past the cap."""
    return (cap_mm - bounds.offset_mm) / bounds.gain + 0.5 * bounds.narrow_mm
