"""The airway below the tube: carina, and secretions that lie along it and must come out.

Secretions lie in bins along the trachea; the catheter takes up what lies within reach of its
tip, at the rate at which a mucus plug moves through the bore. What has been taken up counts as
removed; its way through the bore is not followed.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.compiled import compiled
from opensuction.twin import tip as tips
from opensuction.twin.tip import Tip

BIN_MM = 10.0
"""Length of one bin of secretions."""


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

    secretion_ml: npt.NDArray[np.float64]
    """Secretions in each bin, shape (bins,); never written, only replaced."""
    removed_ml: float
    """Total taken up."""
    tip_mm: float
    contact_n: float
    free_share: float
    """Share of the tip's opening that is free of mucus."""


@compiled
def _bin_at(state: AirwayState, depth_mm: float) -> int:
    return min(max(int(depth_mm / BIN_MM), 0), state.secretion_ml.size - 1)


@compiled
def step(
    airway: Airway, state: AirwayState, free_tip_mm: float, tip_vacuum_mmhg: float, dt_s: float
) -> AirwayState:
    """Advance by one tick.

    free_tip_mm: unhindered tip position. tip_vacuum_mmhg: vacuum that reaches the tip.
    """
    touched = tips.touch(airway.tip, airway.carina_mm, free_tip_mm)
    tip = touched.tip_mm
    secretion = state.secretion_ml
    taken = 0.0
    wanted = airway.uptake_ml_per_s_per_mmhg * tip_vacuum_mmhg * dt_s
    if tip > -airway.reach_mm and wanted > 0.0:
        first = _bin_at(state, tip)
        last = _bin_at(state, tip + airway.reach_mm)
        for i in range(first, last + 1):
            if taken < wanted and state.secretion_ml[i] > 0.0:
                if taken == 0.0:
                    secretion = state.secretion_ml.copy()
                part = min(secretion[i], wanted - taken)
                secretion[i] -= part
                taken += part
        full = taken / wanted
        return AirwayState(
            secretion_ml=secretion,
            removed_ml=state.removed_ml + taken,
            tip_mm=tip,
            contact_n=touched.force_n,
            free_share=1.0 - airway.mucus_share * full,
        )
    return AirwayState(
        secretion_ml=secretion,
        removed_ml=state.removed_ml,
        tip_mm=tip,
        contact_n=touched.force_n,
        free_share=1.0,
    )
