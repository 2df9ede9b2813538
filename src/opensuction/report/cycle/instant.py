"""Instants of a cycle at which something went wrong, as the plots mark them."""

from typing import NamedTuple

from opensuction.report.notice import notices
from opensuction.report.summary import Summary, number, rows

TOGETHER_S = 0.25
"""What comes within this time of the one before stands at one mark: their names would overlap."""


class Instant(NamedTuple):
    """An upright line across the plots, and its name."""

    label: str
    hue: str
    """Colour by its name in the style sheet."""
    time_s: float


def _found(summary: Summary, part: str, name: str, time: str) -> list[tuple[float, str]]:
    """Times and names of a list in the summary; what never came to pass is left out."""
    found = []
    for entry in rows(summary, part):
        time_s = number(entry, time)
        if time_s is not None:
            found.append((time_s, str(entry.get(name, "")).replace("-", " ")))
    return sorted(found)


def _raised(summary: Summary) -> list[tuple[float, str]]:
    """Times and names of alarms, whoever raised them."""
    return sorted(
        (notice.started_s, notice.condition.replace("-", " "))
        for notice in notices(summary)
        if notice.started_s is not None
    )


def _gather(what: str, hue: str, found: list[tuple[float, str]]) -> list[Instant]:
    groups: list[list[tuple[float, str]]] = []
    for entry in found:
        if groups and entry[0] - groups[-1][-1][0] <= TOGETHER_S:
            groups[-1].append(entry)
        else:
            groups.append([entry])
    return [
        Instant(f"{what}: {', '.join(dict.fromkeys(name for _, name in group))}", hue, group[0][0])
        for group in groups
    ]


def instants(summary: Summary) -> list[Instant]:
    """Injected faults, then alarms, each in the order of time."""
    return [
        *_gather("Fault", "fault", _found(summary, "faults", "name", "at_s")),
        *_gather("Alarm", "bad", _raised(summary)),
    ]
