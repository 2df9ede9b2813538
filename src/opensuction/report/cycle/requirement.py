"""Clinical requirements held against the plan of a cycle, as rows of a table."""

from typing import NamedTuple

from opensuction.report.summary import Summary, number, rows, text, value
from opensuction.report.wording import amount

BY_DESIGN = (
    "below the tube the tip goes in at 10 mm/s and no faster, so the way in alone takes seconds "
    "that a hand does not; the time under suction is kept within 15 s"
)
"""Why a cycle stays in the airway for longer than a guideline for hands allows."""


class Requirement(NamedTuple):
    """One requirement in words and numbers."""

    name: str
    planned: str
    limit: str
    """With ``below`` or ``at most``."""
    met: bool | None
    """None where it is not known."""
    source: str


def requirements(summary: Summary) -> list[Requirement]:
    """Requirements in the order of the summary; empty where it has none."""
    listed = []
    for check in rows(summary, "checks"):
        unit = text(check, "unit") or ""
        word = "below" if value(check, "strict") is True else "at most"
        limit, met = number(check, "limit"), value(check, "ok")
        listed.append(
            Requirement(
                name=(text(check, "name") or "?").capitalize(),
                planned=amount(number(check, "value"), unit, 3),
                limit="-" if limit is None else f"{word} {amount(limit, unit, 3)}",
                met=met if isinstance(met, bool) else None,
                source=text(check, "source") or "",
            )
        )
    return listed + _by_hand(summary)


def _by_hand(summary: Summary) -> list[Requirement]:
    """From insertion to removal as a guideline for hands has it, where it applies, and why not."""
    limit = number(summary, "timing", "in_airway_guideline_s")
    planned = next(
        (number(check, "value") for check in rows(summary, "checks") if _is_stay(check)), None
    )
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


def _is_stay(check: Summary) -> bool:
    return text(check, "name") == "time in the airway"
