"""Contact of the catheter's tip with the carina.

Catheter and tissue are two springs in series; beyond its buckling load the slender tip gives way
sideways and adds little force. That limits what a soft catheter can do to the carina, and makes a
stiff one dangerous.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled


class Tip(NamedTuple):
    """Mechanics of the tip and of what it presses on."""

    carina_n_per_mm: float
    """Stiffness of the tissue (or of the bench's rubber)."""
    catheter_n_per_mm: float
    """Axial stiffness of the catheter."""
    buckling_n: float
    """Load at which the free tip buckles (0.13 to 0.26 N for PVC)."""
    post_buckling_ratio: float
    """Stiffness left after buckling, as a share of that before."""


class Touch(NamedTuple):
    """Tip position once the carina is in its way, and the force on it."""

    tip_mm: float
    force_n: float


@compiled
def touch(tip: Tip, carina_mm: float, free_tip_mm: float) -> Touch:
    """Position of the tip against the carina, and the force with which it presses.

    carina_mm: position of the carina. free_tip_mm: where the tip would be with nothing in its way.
    """
    overlap = free_tip_mm - carina_mm
    if overlap <= 0.0:
        return Touch(tip_mm=free_tip_mm, force_n=0.0)
    stiffness = (
        tip.catheter_n_per_mm * tip.carina_n_per_mm / (tip.catheter_n_per_mm + tip.carina_n_per_mm)
    )
    force = stiffness * overlap
    if force > tip.buckling_n:
        beyond = overlap - tip.buckling_n / stiffness
        force = tip.buckling_n + tip.post_buckling_ratio * stiffness * beyond
    return Touch(tip_mm=carina_mm + force / tip.carina_n_per_mm, force_n=force)
