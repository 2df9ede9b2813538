"""Trends over days: outcomes from the records, quantities from the recordings' figures."""

from collections.abc import Iterable, Mapping
from datetime import date, datetime, timedelta, timezone
from statistics import median
from typing import Any, NamedTuple

from opensuction.records.entry import Outcome
from opensuction.records.history import PastCycle

QUANTITIES = (
    "removed_ml",
    "dwell_s",
    "suction_s",
    "in_airway_s",
    "vacuum_mmhg",
    "airway_lowest_cmh2o",
    "airway_highest_cmh2o",
    "spo2_percent",
    "heart_rate_per_min",
    "deepest_mm",
    "contact_mm",
    "gap_mm",
    "alarms",
)
"""Names of figures, as `work_process.figures` gives them."""
RUNNING = "running"
OUTCOMES = (*map(str, Outcome), RUNNING)


class DaySpread(NamedTuple):
    """A quantity over a day's cycles."""

    cycles: int
    lowest: float
    median: float
    highest: float
    total: float


class Day(NamedTuple):
    """Outcomes and quantities of one day, in the time zone of the request."""

    day: date
    outcomes: dict[str, int]
    quantities: dict[str, DaySpread | None]
    """None: no recording of that day knows it."""


def _spread(values: list[float]) -> DaySpread | None:
    if not values:
        return None
    return DaySpread(len(values), min(values), median(values), max(values), sum(values))


def days(
    cycles: Iterable[tuple[PastCycle, Mapping[str, Any] | None]], ahead_of_utc: timedelta
) -> list[Day]:
    """Days with a cycle on them, the first one first.

    cycles: each with the figures of its recording, where they are known. ahead_of_utc: the clock by
    which a day is one.
    """
    zone = timezone(ahead_of_utc)
    found: dict[date, list[tuple[PastCycle, Mapping[str, Any] | None]]] = {}
    for cycle, figures in cycles:
        found.setdefault(_day_of(cycle.started_at, zone), []).append((cycle, figures))
    return [_day(on, found[on]) for on in sorted(found)]


def _day_of(instant: datetime, zone: timezone) -> date:
    return instant.astimezone(zone).date()


def _day(on: date, cycles: list[tuple[PastCycle, Mapping[str, Any] | None]]) -> Day:
    outcomes = dict.fromkeys(OUTCOMES, 0)
    for cycle, _ in cycles:
        outcomes[RUNNING if cycle.outcome is None else str(cycle.outcome)] += 1
    quantities = {}
    for name in QUANTITIES:
        known = [figures.get(name) for _, figures in cycles if figures is not None]
        quantities[name] = _spread([float(one) for one in known if isinstance(one, int | float)])
    return Day(on, outcomes, quantities)
