"""Instants of a cycle at which something went wrong, as the plots mark them."""

from typing import NamedTuple

from opensuction.report.notice import notices
from opensuction.result.cycle_result import CycleResult

TOGETHER_S = 0.25
"""What comes within this time of the one before stands at one mark: their names would overlap."""


class Instant(NamedTuple):
    """An upright line across the plots, and its name."""

    label: str
    hue: str
    """Colour by its name in the style sheet."""
    time_s: float


def _injected(result: CycleResult) -> list[tuple[float, str]]:
    """Times and names of injected faults; one whose instant never came is left out."""
    return sorted(
        (fault.at_s, fault.name.replace("-", " "))
        for fault in result.faults
        if fault.at_s is not None
    )


def _raised(result: CycleResult) -> list[tuple[float, str]]:
    """Times and names of alarms, whoever raised them."""
    return sorted(
        (notice.started_s, notice.condition.replace("-", " "))
        for notice in notices(result)
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


def instants(result: CycleResult) -> list[Instant]:
    """Injected faults, then alarms, each in the order of time."""
    return [
        *_gather("Fault", "fault", _injected(result)),
        *_gather("Alarm", "bad", _raised(result)),
    ]
