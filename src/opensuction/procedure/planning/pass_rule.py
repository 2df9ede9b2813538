"""Rules of repeated passes by age: their number, the rest between them, pre-oxygenation.

Tags: docs/sources.md. Reasons: docs/decisions/0017.
"""

from opensuction.kernel.age_group import AgeGroup
from opensuction.procedure.cycle.episode import PassRule

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

SOURCES: dict[str, str] = {
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
