"""Limits of the clinical guidelines by age: the planner enforces them, the report shows them.

Tags: docs/sources.md.
"""

from typing import NamedTuple

from opensuction.kernel.age_group import AgeGroup


class Guideline(NamedTuple):
    """Limits for one age group, each with its source in `SOURCES`; or what a plan would do."""

    vacuum_mmhg: float
    """Highest vacuum with the tip occluded."""
    negative_pressure_s: float
    """Longest suction."""
    in_airway_s: float
    """Longest stay of the catheter below the tube's upper end."""
    catheter_ratio: float
    """Catheter diameter over tube diameter must stay below this."""
    speed_mm_per_s: float
    """Fastest motion inwards beyond the tube."""


GUIDELINES: dict[AgeGroup, Guideline] = {
    AgeGroup.ADULT: Guideline(
        vacuum_mmhg=150.0,
        negative_pressure_s=15.0,
        in_airway_s=30.0,
        catheter_ratio=0.5,
        speed_mm_per_s=10.0,
    ),
    AgeGroup.CHILD: Guideline(
        vacuum_mmhg=120.0,
        negative_pressure_s=5.0,
        in_airway_s=20.0,
        catheter_ratio=0.5,
        speed_mm_per_s=10.0,
    ),
    AgeGroup.NEONATE: Guideline(
        vacuum_mmhg=100.0,
        negative_pressure_s=5.0,
        in_airway_s=20.0,
        catheter_ratio=0.7,
        speed_mm_per_s=10.0,
    ),
}
"""Limits by age group; strict: there is no way to pass them but the bench."""

SOURCES: dict[str, str] = {
    "vacuum_mmhg": "adult: pump to be used at no more than 150, [paper] II-B, and under 150, "
    "[AARC-2010] [K]; child: under 120, [AARC-2022]; neonate: 80 to 100, [AARC-2010] [K]",
    "negative_pressure_s": "adult: at most 15, [AARC-2010] and [AARC-2022]; child and neonate: 5, "
    "[paper] II-A, and under 5, [ATS-2000]",
    "in_airway_s": "[design-airway] no guideline found for a machine that inserts at 10 mm/s",
    "catheter_ratio": "under .5 of the diameter, neonates under .7, [AARC-2010] and [AARC-2022]",
    "speed_mm_per_s": "around 10 mm/s, [paper] II-A",
}
"""Where each limit comes from."""


class GuidelineCheck(NamedTuple):
    """One requirement held against a plan."""

    name: str
    """What is limited, in words."""
    value: float
    limit: float
    unit: str
    strict: bool
    """The value must stay below the limit; otherwise it may reach it."""
    source: str

    @property
    def ok(self) -> bool:
        """True where the requirement is met."""
        return self.value < self.limit if self.strict else self.value <= self.limit


def checks(age: AgeGroup, planned: Guideline) -> list[GuidelineCheck]:
    """The clinical requirements of the paper's section II-A. planned: what a plan would do."""
    words = (
        ("vacuum", "mmHg"),
        ("suction time", "s"),
        ("time in the airway", "s"),
        ("catheter over tube diameter", ""),
        ("speed inwards", "mm/s"),
    )
    rows = zip(words, Guideline._fields, planned, GUIDELINES[age], strict=True)
    return [
        GuidelineCheck(name, value, limit, unit, field == "catheter_ratio", SOURCES[field])
        for (name, unit), field, value, limit in rows
    ]
