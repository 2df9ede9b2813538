"""The tracheostomy tube as a flow resistance, open or with the catheter in it.

Turbulent: the loss at entry and exit, and wall friction after Blasius over the hydraulic diameter,
both times the dynamic pressure. Friction is taken at one reference flow, so that the loss is a
pure square of the flow and `twin.patient.airflow` has a closed solution; at twice that flow
the friction is 19 % too large, the loss 3 % in the open adult tube and 6 % with the catheter. The
laminar part (0.01 cmH2O at 6 L/min in the adult tube) is left out.
"""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled

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
