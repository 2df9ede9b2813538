"""Catheters and the conduits they run in: sizes, and what changes with them.

The machine's parameters are those of the paper's catheter; another one scales them by mechanics:
axial stiffness goes with the wall's area, the buckling load with its second moment, gas through the
bore flows turbulently or just not yet, mucus as a viscous plug. Material and length stay the same.
"""

import math
from typing import NamedTuple

from opensuction.kernel.age_group import AgeGroup
from opensuction.twin.patient import Patient
from opensuction.twin.tube import DENSITY_KG_PER_M3, VISCOSITY_M2_PER_S

LENGTH_M = 2.0
"""Of every catheter [paper]."""
BORE_MMHG = 100.0
"""Vacuum at which the flow of the bore is given."""
PA_PER_MMHG = 133.322
L_PER_MIN = 6.0e4
"""L/min for each m3/s."""
CRITICAL_REYNOLDS = 2300.0
"""Flow in a pipe is laminar up to here."""
BLASIUS_POWER = 19.0 / 7.0
"""Turbulent flow at a given pressure loss grows with this power of the bore."""


class Catheter(NamedTuple):
    """A catheter in its conduit."""

    outer_mm: float
    bore_mm: float
    conduit_mm: float
    """Bore of the conduit."""


PAPER = Catheter(outer_mm=4.0, bore_mm=3.5, conduit_mm=6.0)
"""[paper] PTFE, 2 m, 12 Fr."""

CATHETERS = {
    "12fr": PAPER,
    # [computed] 2 mm is 6 Fr; the paper's wall of 0.25 mm; [assumed] a conduit with the paper's
    # clearance of 2 mm, so that the catheter has the same gap.
    "6fr": Catheter(outer_mm=2.0, bore_mm=1.5, conduit_mm=4.0),
}
"""Catheters by name."""

BY_AGE_GROUP = {AgeGroup.ADULT: "12fr", AgeGroup.CHILD: "6fr", AgeGroup.NEONATE: "6fr"}
"""Which of them a patient is suctioned with."""


def suited(patient: Patient | None) -> Catheter:
    """The catheter for a patient's age; the paper's on the bench."""
    if patient is None:
        return PAPER
    return CATHETERS[BY_AGE_GROUP[AgeGroup(patient.age_group)]]


def wall_mm2(catheter: Catheter) -> float:
    """Cross-section of the wall: axial stiffness and weight follow it."""
    outer, bore = catheter.outer_mm, catheter.bore_mm
    return 0.25 * math.pi * (outer * outer - bore * bore)


def second_moment_mm4(catheter: Catheter) -> float:
    """Second moment of area of the wall: bending stiffness and buckling load follow it."""
    return math.pi / 64.0 * (catheter.outer_mm**4 - catheter.bore_mm**4)


def free_flow_l_per_min(catheter: Catheter, paper_l_per_min: float) -> float:
    """Free-air flow through the bore at 100 mmHg, of which PAPER passes ``paper_l_per_min``.

    Laminar (Hagen and Poiseuille) up to its critical Reynolds number, turbulent (Blasius) where
    that is more; between the two no flow is steady, and it stays at the critical one.
    [computed] A bore of 1.5 mm: 1.8 turbulent, 2.8 laminar, 2.4 at the critical Reynolds number.
    """
    turbulent = paper_l_per_min * math.pow(catheter.bore_mm / PAPER.bore_mm, BLASIUS_POWER)
    bore_m = catheter.bore_mm * 1e-3
    viscosity_pa_s = VISCOSITY_M2_PER_S * DENSITY_KG_PER_M3
    laminar = math.pi * bore_m**4 * BORE_MMHG * PA_PER_MMHG / (128.0 * viscosity_pa_s * LENGTH_M)
    critical = 0.25 * math.pi * bore_m * VISCOSITY_M2_PER_S * CRITICAL_REYNOLDS
    return min(laminar * L_PER_MIN, max(turbulent, critical * L_PER_MIN))


def fitted(values: dict[str, float], catheter: Catheter) -> dict[str, float]:
    """A machine's parameters with another catheter and its conduit; with PAPER unchanged.

    Stretch stays: friction falls with the catheter's weight as axial stiffness does.
    """
    width = (catheter.conduit_mm - catheter.outer_mm) / (PAPER.conduit_mm - PAPER.outer_mm)
    bore = catheter.bore_mm / PAPER.bore_mm
    axial = wall_mm2(catheter) / wall_mm2(PAPER)
    bending = second_moment_mm4(catheter) / second_moment_mm4(PAPER)
    return {
        **values,
        "clearance_mm": width * values["clearance_mm"],
        "width_spread_mm": width * values["width_spread_mm"],
        "catheter_n_per_mm": axial * values["catheter_n_per_mm"],
        "buckling_n": bending * values["buckling_n"],
        "bore_l_per_min": free_flow_l_per_min(catheter, values["bore_l_per_min"]),
        # A plug of given length and viscosity: Hagen and Poiseuille.
        "uptake_ml_per_s_per_mmhg": bore**4 * values["uptake_ml_per_s_per_mmhg"],
        # The reach in front of the tip is some diameters.
        "reach_mm": catheter.outer_mm / PAPER.outer_mm * values["reach_mm"],
    }
