"""Catheters and the conduits they run in: sizes, and what changes with them.

The machine's parameters are those of the paper's catheter; another one scales them by mechanics:
axial stiffness goes with the wall's area, the buckling load with its second moment, gas through the
bore flows turbulently or just not yet, mucus as a viscous plug. Material and length stay the same.
The gap of the transmission is the conduit's bend times its clearance.
"""

import math
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le

from opensuction.kernel.errors import InputError
from opensuction.kernel.unit import BLASIUS_POWER, PA_PER_MMHG
from opensuction.kernel.vocabulary import AgeGroup, Meaning
from opensuction.twin.airway.airway import DENSITY_KG_PER_M3, VISCOSITY_M2_PER_S
from opensuction.twin.parameter import BENCH, ParameterValues
from opensuction.twin.patient.patient import Patient

LENGTH_M = 2.0
"""Of every catheter [paper]."""
BORE_MMHG = 100.0
"""Vacuum at which the flow of the bore is given."""
L_PER_MIN_PER_M3_PER_S = 6.0e4
CRITICAL_REYNOLDS = 2300.0
"""Flow in a pipe is laminar up to here."""


class Catheter(NamedTuple):
    """A catheter's cross-section."""

    outer_mm: Annotated[float, Gt(0), Le(8), Meaning("outer diameter")]
    bore_mm: Annotated[float, Gt(0), Le(8), Meaning("inner diameter")]


class Conduit(NamedTuple):
    """Conduit that a catheter runs in, and how it is laid."""

    bore_mm: Annotated[float, Gt(0), Le(12), Meaning("inner diameter")]
    length_mm: Annotated[float, Ge(300), Le(2000), Meaning("length")]
    bend_rad: Annotated[float, Ge(1), Le(25), Meaning("total bend, 2 pi for each full turn")]


PAPER = Catheter(outer_mm=4.0, bore_mm=3.5)
"""[paper] PTFE, 2 m, 12 Fr."""
WALL_MM = 0.25
"""[paper] (4.0 - 3.5) / 2; [assumed] for every other size."""
CLEARANCE_MM = BENCH["clearance_mm"].value
"""[paper] A conduit chosen by name leaves this much, so that every catheter has the same gap."""
PAPER_BEND_RAD = BENCH["bend_rad"].value
LEAST_CLEARANCE_MM = BENCH["clearance_mm"].low
"""[assumed] A catheter with less binds in the bends."""
MOST_CLEARANCE_MM = BENCH["clearance_mm"].high
"""[assumed] A catheter with more buckles in its conduit instead of advancing."""
STROKE_MM = 300.0
"""[computed] Catheter needed outside the conduit: 180 mm from park to the end of the longest tube,
100 mm to the carina, and a gap of 20 mm."""
SIZES_FR = (6, 8, 10, 12, 14)
MM_PER_FR = 1.0 / 3.0
"""[ISO-8836] A size in Fr is three times the outer diameter in mm."""


def _of_size(fr: int) -> Catheter:
    outer_mm = fr * MM_PER_FR
    return Catheter(outer_mm=outer_mm, bore_mm=outer_mm - 2.0 * WALL_MM)


CATHETERS = {f"{fr}fr": PAPER if fr == 12 else _of_size(fr) for fr in SIZES_FR}
"""Catheters by name."""
CATHETER_SOURCES = {
    name: "[paper]" if catheter == PAPER else "[computed] Fr / 3; the paper's wall of 0.25 mm"
    for name, catheter in CATHETERS.items()
}


class Route(NamedTuple):
    """Length and bend of a conduit as it is laid."""

    length_mm: float
    bend_rad: float
    source: str


ROUTES = {
    "standard": Route(
        1500.0, PAPER_BEND_RAD, "[paper] length; bend [calibrated], see `bend_rad` of the machine"
    ),
    "short": Route(1000.0, math.tau, "[assumed] a machine at the bed's head: one full turn"),
    "looped": Route(1500.0, 2.0 * math.tau, "[assumed] two full turns, as when coiled to store"),
}
"""Ways to lay a conduit, by name; the first is the default."""

BY_AGE_GROUP = {AgeGroup.ADULT: "12fr", AgeGroup.CHILD: "6fr", AgeGroup.NEONATE: "6fr"}
"""Which catheter a patient is suctioned with where none is chosen."""


def for_patient(patient: Patient | None) -> Catheter:
    """The catheter for a patient's age; the paper's on the bench."""
    return CATHETERS[BY_AGE_GROUP[AgeGroup(patient.age_group)]] if patient is not None else PAPER


def lay(route: str, catheter: Catheter) -> Conduit:
    """A conduit by the name of its route, in the bore that leaves the paper's clearance."""
    chosen = ROUTES[route]
    return Conduit(catheter.outer_mm + CLEARANCE_MM, chosen.length_mm, chosen.bend_rad)


def gap_ratio(catheter: Catheter, conduit: Conduit) -> float:
    """Width of the gap over the paper's: it is bend angle times diametral clearance."""
    clearance = conduit.bore_mm - catheter.outer_mm
    return clearance / CLEARANCE_MM * (conduit.bend_rad / PAPER_BEND_RAD)


def check(catheter: Catheter, conduit: Conduit) -> None:
    """Refuse a catheter that cannot be, or not in this conduit; raises InputError with the sums."""
    outer, clearance = catheter.outer_mm, conduit.bore_mm - catheter.outer_mm
    if catheter.bore_mm >= outer:
        raise InputError(
            f"a catheter with an outer diameter of {outer:.3g} mm cannot have a bore of "
            f"{catheter.bore_mm:.3g} mm"
        )
    if not LEAST_CLEARANCE_MM <= round(clearance, 9) <= MOST_CLEARANCE_MM:
        raise InputError(
            f"a catheter of {outer:.3g} mm does not fit its conduit: a bore of "
            f"{conduit.bore_mm:.3g} mm less {outer:.3g} mm leaves {clearance:.3g} mm of "
            f"clearance, it should be {LEAST_CLEARANCE_MM:g} to {MOST_CLEARANCE_MM:g} mm"
        )
    left = 1000.0 * LENGTH_M - conduit.length_mm
    if left < STROKE_MM:
        raise InputError(
            f"a conduit of {conduit.length_mm:g} mm leaves {1000.0 * LENGTH_M:g} - "
            f"{conduit.length_mm:g} = {left:g} mm of the catheter outside, and the stroke needs "
            f"{STROKE_MM:g} mm: use a shorter conduit"
        )


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
    return min(laminar * L_PER_MIN_PER_M3_PER_S, max(turbulent, critical * L_PER_MIN_PER_M3_PER_S))


def adapt(values: ParameterValues, catheter: Catheter, conduit: Conduit) -> ParameterValues:
    """A machine's parameters with another catheter and conduit; unchanged with the paper's.

    Stretch does not depend on the catheter: friction falls with its weight as axial stiffness does.
    With the bend it grows: so does friction, nearly in proportion (capstan).
    """
    clearance = (conduit.bore_mm - catheter.outer_mm) / CLEARANCE_MM
    bend = conduit.bend_rad / PAPER_BEND_RAD
    bore = catheter.bore_mm / PAPER.bore_mm
    axial = wall_mm2(catheter) / wall_mm2(PAPER)
    bending = second_moment_mm4(catheter) / second_moment_mm4(PAPER)
    return {
        **values,
        "bend_rad": bend * values["bend_rad"],
        "clearance_mm": clearance * values["clearance_mm"],
        "width_spread_mm": gap_ratio(catheter, conduit) * values["width_spread_mm"],
        "stretch_mm": bend * values["stretch_mm"],
        "catheter_n_per_mm": axial * values["catheter_n_per_mm"],
        "buckling_n": bending * values["buckling_n"],
        "bore_l_per_min": free_flow_l_per_min(catheter, values["bore_l_per_min"]),
        # A plug of given length and viscosity: Hagen and Poiseuille.
        "uptake_ml_per_s_per_mmhg": bore**4 * values["uptake_ml_per_s_per_mmhg"],
        # The reach in front of the tip is some diameters.
        "reach_mm": catheter.outer_mm / PAPER.outer_mm * values["reach_mm"],
    }
