"""Clinical requirements held against the plan of a cycle, as rows of a table."""

from typing import NamedTuple

from opensuction.report.summary import Summary, number, rows, text, value
from opensuction.report.wording import amount


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
    return listed
