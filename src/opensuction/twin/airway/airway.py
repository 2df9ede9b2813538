"""The airway below the tube as the tip meets it: carina, and secretions that flow to the tip.

The catheter takes up what lies within reach of its tip, at the rate at which a mucus plug moves
through the bore. What has been taken up counts as removed; its way through the bore is followed in
`opensuction.twin.machine.suction_line`. Where secretions lie is the bedside's (`secretion`).

Contact of the catheter's tip with the carina.

Catheter and tissue are two springs in series; beyond its buckling load the slender tip gives way
sideways and adds little force. That limits what a soft catheter can do to the carina, and makes a
stiff one dangerous.

Secretions along the trachea, in bins: what lies where, what is near the tip, what is taken.

It is stepped with the patient. The machine gets the volume within reach of its tip, and gives back
the volume that it took.

The tracheostomy tube as a flow resistance, open or with the catheter in it.

Turbulent: the loss at entry and exit, and wall friction after Blasius over the hydraulic diameter,
both times the dynamic pressure. Friction is taken at one reference flow, so that the loss is a
pure square of the flow and `twin.patient.ventilator` has a closed solution; at twice that flow
the friction is 19 % too large, the loss 3 % in the open adult tube and 6 % with the catheter. The
laminar part (0.01 cmH2O at 6 L/min in the adult tube) is left out.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

DENSITY_KG_PER_M3 = 1.2
VISCOSITY_M2_PER_S = 1.5e-5
"""Kinematic viscosity of air."""
PA_PER_CMH2O = 98.0665
ENTRY_EXIT = 1.5
"""Loss at a sharp entry (0.5) and at the exit (1), in dynamic pressures."""
BLASIUS = 0.316
WIDEST_RATIO = 0.95
"""A catheter this wide leaves 10 % of the area; a wider one is taken as this."""


class Tube(NamedTuple):
    """Losses of the open tube, in cmH2O for the square of one mL/s."""

    ends: float
    """At entry and exit."""
    friction: float
    """Along the wall, at the reference flow."""


def of_size(bore_mm: float, length_mm: float, reference_ml_per_s: float) -> Tube:
    """Tube of a given inner diameter and length; friction taken at the reference flow.

    Source: [computed] with these losses a 4 mm catheter in an 80 mm tube takes 1.4, 0.94 and
    0.49 cmH2O at 18 L/min for inner diameters of 7.5, 8 and 9 mm.
    """
    bore_m = bore_mm * 1e-3
    area_m2 = 0.25 * math.pi * bore_m * bore_m
    reynolds = reference_ml_per_s * 1e-6 / area_m2 * bore_m / VISCOSITY_M2_PER_S
    dynamic = 0.5 * DENSITY_KG_PER_M3 * (1e-6 / area_m2) ** 2 / PA_PER_CMH2O
    return Tube(
        ends=ENTRY_EXIT * dynamic,
        friction=BLASIUS * reynolds**-0.25 * length_mm / bore_mm * dynamic,
    )


@compiled
def loss(tube: Tube, catheter_ratio: float) -> float:
    """Pressure loss in cmH2O for the square of one mL/s.

    catheter_ratio: catheter over tube diameter, 0 without a catheter. The free area shrinks by
    1 - r^2, the hydraulic diameter by 1 - r, the Reynolds number by 1 + r.
    """
    ratio = min(max(catheter_ratio, 0.0), WIDEST_RATIO)
    area = 1.0 - ratio * ratio
    friction = tube.friction * math.sqrt(math.sqrt(1.0 + ratio)) / (1.0 - ratio)
    return (tube.ends + friction) / (area * area)


BIN_MM = 10.0
"""Length of one bin of secretions."""

Bins = Array
"""Secretions in each bin from the tube's lower end downwards, mL, shape (bins,)."""


@compiled
def _bin_at(secretion_ml: Bins, depth_mm: float) -> int:
    return min(max(int(depth_mm / BIN_MM), 0), secretion_ml.size - 1)


@compiled
def within_reach_ml(secretion_ml: Bins, tip_mm: float, reach_mm: float) -> float:
    """Secretions in the bins from the tip to ``reach_mm`` in front of it; none from the tube."""
    found = 0.0
    if tip_mm > -reach_mm:
        first = _bin_at(secretion_ml, tip_mm)
        last = _bin_at(secretion_ml, tip_mm + reach_mm)
        for i in range(first, last + 1):
            found += secretion_ml[i]
    return found


@compiled
def step_secretion(
    secretion_ml: Bins,
    produced_ml_per_s: Bins,
    tip_mm: float,
    reach_mm: float,
    taken_ml: float,
    dt_s: float,
) -> Bins:
    """Secretions after a volume was taken at the tip, what lies next to it first, and new came.

    produced_ml_per_s: in each bin, shape (bins,). taken_ml: at most `within_reach_ml` there.
    The arrays given stay as they are.
    """
    rest = secretion_ml.copy()
    left = taken_ml
    first = _bin_at(secretion_ml, tip_mm)
    last = _bin_at(secretion_ml, tip_mm + reach_mm)
    for i in range(first, last + 1):
        part = min(rest[i], left)
        rest[i] -= part
        left -= part
    for i in range(rest.size):
        rest[i] += produced_ml_per_s[i] * dt_s
    return rest


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


class Airway(NamedTuple):
    """Geometry and secretions of the airway, from the lower end of the tube downwards."""

    carina_mm: float
    """Distance from the tube's lower end to the carina."""
    tip: Tip
    """Mechanics of the tip against it."""
    uptake_ml_per_s_per_mmhg: float
    """Mucus taken up for each mmHg at the tip; falls with viscosity."""
    reach_mm: float
    """Distance in front of the tip from which mucus flows in."""
    mucus_share: float
    """Share of the tip's opening that mucus takes while it flows in."""


class AirwayState(NamedTuple):
    """State of the airway."""

    taken_ml: float
    """Taken up in the last tick."""
    removed_ml: float
    """Total taken up."""
    tip_mm: float
    contact_n: float
    free_share: float
    """Share of the tip's opening that is free of mucus."""


@compiled
def step(
    airway: Airway,
    state: AirwayState,
    free_tip_mm: float,
    tip_vacuum_mmhg: float,
    reachable_ml: float,
    dt_s: float,
) -> AirwayState:
    """Advance by one tick.

    free_tip_mm: unhindered tip position. tip_vacuum_mmhg: vacuum that reaches the tip.
    reachable_ml: secretions within reach of it.
    """
    touched = touch(airway.tip, airway.carina_mm, free_tip_mm)
    wanted = airway.uptake_ml_per_s_per_mmhg * tip_vacuum_mmhg * dt_s
    taken = min(wanted, reachable_ml)
    free = 1.0
    if taken > 0.0:
        free -= airway.mucus_share * taken / wanted
    return AirwayState(
        taken_ml=taken,
        removed_ml=state.removed_ml + taken,
        tip_mm=touched.tip_mm,
        contact_n=touched.force_n,
        free_share=free,
    )
