"""The airway below the tube as the tip meets it: carina, and secretions that flow to the tip.

The catheter takes up what lies within reach of its tip, at the rate at which a mucus plug moves
through the bore. What has been taken up counts as removed; its way through the bore is followed in
`opensuction.twin.machine.bore`. Where secretions lie is the bedside's (`secretion`).
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.twin.airway import tip as tip_model
from opensuction.twin.airway.tip import Tip


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
    touched = tip_model.touch(airway.tip, airway.carina_mm, free_tip_mm)
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
