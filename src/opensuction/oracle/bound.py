"""Bounds for the patient by age, from clinical sources alone, not from the machine's own limits.

The controller has tighter limits of its own; they are not considered here. Each bound has its
source in `SOURCES`. Tags: docs/sources.md.
"""

from typing import NamedTuple

from opensuction.kernel.age_group import AgeGroup


class AgeBounds(NamedTuple):
    """Bounds on the exposure of a patient of an age in a run; times are sums over all stretches."""

    contact_s: float
    """With the tip on the carina."""
    vacuum_mmhg: float
    """At the tip, in the airway."""
    suction_s: float
    """With vacuum at the tip, in the airway; `CLOSING_S` comes on top."""
    in_airway_s: float
    """With the tip below the tube's upper end."""
    pressure_s: float
    """With the airway's pressure too low or too high."""
    pressure_most_cmh2o: float
    """A higher one is too high."""
    lung_loss_ml_per_kg: float
    """Of end-expiratory volume, for each kilogram of predicted weight."""
    spo2_percent: float
    """Least saturation."""


BOUNDS: dict[AgeGroup, AgeBounds] = {
    AgeGroup.ADULT: AgeBounds(3.0, 200.0, 15.0, 30.0, 5.0, 40.0, 11.0, 83.0),
    AgeGroup.CHILD: AgeBounds(3.0, 120.0, 5.0, 20.0, 1.5, 35.0, 11.0, 83.0),
    AgeGroup.NEONATE: AgeBounds(3.0, 100.0, 5.0, 20.0, 1.5, 30.0, 11.0, 83.0),
}
"""Bounds by age group."""

FORCE_N = 0.3
"""[design-force] Force on the carina: a third of what punctures."""
ADVANCE_MM = 0.5
"""[design] Way in under vacuum: what a tip does while it settles, and no mucosa is stripped by."""
CLOSING_S = 1.0
"""[design] A time limit ends with the order to close: the cam's stroke of 0.5 s, and as much for
noticing and for what the line still holds."""
LOST_CMH2O = 5.0
"""[design-lung] Pressure below PEEP at which lung volume is being lost."""

SOURCES: dict[str, str] = {
    "contact_s": "[design-contact] 2 s, for a tip that closes its switch presses with more than "
    "the 30 mmHg of capillaries; 1 s in which a head at 30 mm/s crosses the widest gap, 26 mm",
    "vacuum_mmhg": "adult: under 200, child: under 120, [AARC-2022]; neonate: 80 to 100, "
    "[AARC-2010] [K]",
    "suction_s": "adult: at most 15, [AARC-2022]; child and neonate: under 5, [ATS-2000] and "
    "[paper] II-A",
    "in_airway_s": "[calc-apnoea] from total apnoea to a saturation of 90 %: an adult at room air "
    "30, an infant of 5 kg on 30 % oxygen 20; a catheter blocks a third of the tube at most",
    "pressure_s": "[calc-apnoea] a sixth of what apnoea at room air leaves until 90 %: an adult "
    "has 30, a child of 10 kg 9, a neonate no more",
    "pressure_most_cmh2o": "usual upper alarm limit of ventilators [assumed]",
    "lung_loss_ml_per_kg": "[Maggiore-2003] closed suction of adults loses 531 mL, SD 228: a "
    "standard deviation above that, over 70 kg; for other ages likewise [assumed], their lungs "
    "hold as much for each kilogram",
    "spo2_percent": "[assumed] 88, the least aimed at in acute lung injury [K], less 5 that "
    "suction may take [Simarmata-2019]",
}
"""Where each bound comes from."""
