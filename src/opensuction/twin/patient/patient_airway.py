"""The patient's trachea in the place of the bench's rubber one."""

from opensuction.twin.parameter import ParameterValues
from opensuction.twin.patient.patient import Patient

UPTAKE_PA_S = 1.0
"""Viscosity for which the uptake of mucus is given."""
FREE_MM = 90.0
"""Free length for which the tip's buckling load is given: the paper's travel."""
HOLDING_SHARE = 1.0 / 3.0
"""Share of the tube over which the tip is free too, for the tube holds it loosely; assumed."""
FIRM_MOST_N = 0.15
"""[design] Tips come in hardnesses: one that would buckle above this at the patient's free length
is left for the next softer one. A buckled tip gives up to 0.15 N more on the last 10 mm of a search
[computed], and the carina shall bear 0.3 N at most."""
SOFT_SHARE = 0.65
"""[design] Buckling load of a tip over that of the next harder one: PVC of 15 and 10 MPa, and 6.5.
The softest that is taken still buckles at 1.2 times what closes the switch."""
REPLACED = (
    "carina_mm",
    "carina_n_per_mm",
    "secretion_ml",
    "secretion_above_carina_mm",
    "secretion_spread_mm",
    "mucus_pa_s",
    "mucus_yield_pa",
)
"""Parameters of the bench's rubber trachea that a patient's own take the place of."""


def _soften_n(buckling_n: float) -> float:
    """Buckling load of the hardest tip that spares the carina."""
    while buckling_n > FIRM_MOST_N:
        buckling_n *= SOFT_SHARE
    return buckling_n


def adapt(values: ParameterValues, patient: Patient) -> ParameterValues:
    """A machine's parameters with a patient's carina and secretions in place of the bench's.

    Uptake falls with viscosity (a viscous plug), the buckling load with the square of the free
    length (Euler); where that would press too hard, a softer tip is taken.
    """
    secretion = patient.secretion
    free = FREE_MM / (patient.carina_mm + HOLDING_SHARE * patient.tube_length_mm)
    uptake = values["uptake_ml_per_s_per_mmhg"]
    return {
        **values,
        "carina_mm": patient.carina_mm,
        "carina_n_per_mm": patient.carina_n_per_mm,
        "buckling_n": _soften_n(free * free * values["buckling_n"]),
        "secretion_ml": secretion.volume_ml,
        "mucus_pa_s": secretion.viscosity_pa_s,
        "mucus_yield_pa": secretion.yield_pa,
        "secretion_above_carina_mm": patient.carina_mm - secretion.depth_mm,
        "secretion_spread_mm": secretion.spread_mm,
        "uptake_ml_per_s_per_mmhg": uptake * UPTAKE_PA_S / secretion.viscosity_pa_s,
    }
