"""Limits of the clinical guidelines by age: the planner enforces them, the report shows them.

Tags: docs/sources.md.

Under which limits a person teaches the travel length, and which lengths are plausible.

Rules of repeated passes by age: their number, the rest between them, pre-oxygenation.

Tags: docs/sources.md. Reasons: docs/decisions/0017.
"""

import math
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.procedure.cycle.schedule import PassRule
from opensuction.procedure.cycle.teaching import PLAUSIBLE
from opensuction.procedure.planning.protocol import Protocol

MOST_PASSES = 3
"""Then a person looks at the patient: usual practice [K], for mucus that three passes leave needs
something else than a fourth."""

RULES: dict[AgeGroup, PassRule] = {
    AgeGroup.ADULT: PassRule(most_passes=MOST_PASSES, rest_s=180.0, asks_for_oxygen=True),
    AgeGroup.CHILD: PassRule(most_passes=MOST_PASSES, rest_s=120.0, asks_for_oxygen=True),
    AgeGroup.NEONATE: PassRule(most_passes=MOST_PASSES, rest_s=180.0, asks_for_oxygen=False),
}
"""For patients."""

BENCH = PassRule(most_passes=0, rest_s=0.0, asks_for_oxygen=False)
"""Nobody is there to rest."""

PASS_SOURCES: dict[str, str] = {
    "most_passes": "[K] at most three; [design] they follow each other until a person has looked, "
    "so that no clock goes round it",
    "rest_s": "[design] 120 s hold the minute of oxygen after a pass and the minute before the "
    "next [K]; lung volume is not back after 60 s [Maggiore-2003]; adults: half of what an ARDS "
    "lung lost is back after 95 s, three quarters after 200 s, and of a sound one after 120 s, "
    "with the lowest saturation shown 20 to 45 s after the pass [in-silico]; children: nine tenths "
    "are back after 130 s [in-silico]; neonates: three quarters after 90 s, nine tenths after "
    "230 s [in-silico], and no oxygen before",
    "asks_for_oxygen": "adults and children [AARC-2022]; neonates get no 100 % oxygen [K]",
}
"""Where each value comes from."""


def of(bench_only: bool, age: AgeGroup) -> PassRule:
    """The rule of a plan. bench_only: nobody is on the machine."""
    return BENCH if bench_only else RULES[age]


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


SEARCH_MARGIN_MM = 10.0
"""Beyond the plausible depth at which the governor takes the catheter out of the hand; assumed."""
IDLE_VACUUM_MMHG = 80.0
"""Set point of the plan that teaching runs under; the pump stays off."""
IDLE_DWELL_S = 2.0
"""Dwell of the plan that teaching runs under; no cycle is started with it."""


def protocol(age: AgeGroup, vacuum_mmhg: float) -> Protocol:
    """Limits under which a person teaches: the plausible range is the cap, no cycle is planned.

    vacuum_mmhg: any the machine can hold; the pump stays off.
    """
    guideline = GUIDELINES[age]
    most_mm = PLAUSIBLE[age].most_mm
    return Protocol(
        travel_mm=most_mm,
        cap_mm=most_mm + SEARCH_MARGIN_MM,
        insertion_mm_per_s=guideline.speed_mm_per_s,
        withdrawal_mm_per_s=guideline.speed_mm_per_s,
        contact_from_mm=0.0,
        backoff_mm=0.0,
        dwell_s=IDLE_DWELL_S,
        nothing_comes_s=0.0,
        vacuum_mmhg=vacuum_mmhg,
        negative_pressure_budget_s=60.0,  # the valve stays closed
        in_airway_budget_s=60.0,  # of the plan; the governor's limit is the guideline's
        bench_only=False,
    )


def check_plausible(age: AgeGroup, taught_mm: float, what: str) -> None:
    """Refuse a length that no such patient has. Raises InputError with the arithmetic.

    what: names the length in the message.
    """
    least, most = PLAUSIBLE[age]
    if least <= taught_mm <= most:
        return
    if not math.isfinite(taught_mm):
        raise InputError(
            f"{what} {taught_mm:g} mm is no length: measure from the tube's lower end to the "
            f"carina, {least:g} to {most:g} mm"
        )
    beyond = least - taught_mm if taught_mm < least else taught_mm - most
    where = "short of the least" if taught_mm < least else "beyond the most"
    limit = least if taught_mm < least else most
    raise InputError(
        f"{what} {taught_mm:g} mm is {beyond:.3g} mm {where} plausible for {age.name.lower()}, "
        f"{limit:g} mm: measure again from the tube's lower end to the carina, {least:g} to "
        f"{most:g} mm"
    )
