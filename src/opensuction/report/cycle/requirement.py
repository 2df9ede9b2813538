"""Clinical requirements held against the plan of a cycle, as rows of a table."""

from typing import NamedTuple

from opensuction.report.wording import amount
from opensuction.result.cycle_result import CycleResult, PlannedCheck

BY_DESIGN = (
    "below the tube the tip goes in at 10 mm/s and no faster, so the way in alone takes seconds "
    "that a hand does not; the time under suction is kept within 15 s"
)
"""Why a cycle stays in the airway for longer than a guideline for hands allows."""
STAY = "time in the airway"
"""Name of the check that a guideline for hands has, too."""


class Requirement(NamedTuple):
    """One requirement in words and numbers."""

    name: str
    planned: str
    limit: str
    """With ``below`` or ``at most``."""
    met: bool
    source: str


def requirements(result: CycleResult) -> list[Requirement]:
    """Requirements in the order of the result; empty where it has none."""
    listed = []
    for check in _checks(result):
        word = "below" if check.strict else "at most"
        listed.append(
            Requirement(
                name=check.name.capitalize(),
                planned=amount(check.value, check.unit, 3),
                limit=f"{word} {amount(check.limit, check.unit, 3)}",
                met=check.ok,
                source=check.source,
            )
        )
    return listed + _by_hand(result)


def _checks(result: CycleResult) -> tuple[PlannedCheck, ...]:
    return () if result.simulated is None else result.simulated.checks


def _by_hand(result: CycleResult) -> list[Requirement]:
    """From insertion to removal as a guideline for hands has it, where it applies, and why not."""
    limit = result.timing.in_airway_guideline_s
    planned = next((check.value for check in _checks(result) if check.name == STAY), None)
    if limit is None or planned is None:
        return []
    met = planned <= limit
    return [
        Requirement(
            name="Insertion to removal, by hand",
            planned=amount(planned, "s", 3),
            limit=f"at most {amount(limit, 's', 3)}",
            met=met,
            source="[ACI-2014]" + ("" if met else f", exceeded by design: {BY_DESIGN}"),
        )
    ]
