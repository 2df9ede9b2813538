"""A made-up day for the tests of its page."""

from typing import Any

import numpy as np

from opensuction.result.day_result import DayCycleResult, DayResult, DaySamples
from tests.report.record import record_of


def cycle(number: int, **changes: Any) -> DayCycleResult:
    """One cycle of a day, with keys of its JSON replaced."""
    complete: dict[str, Any] = {
        "number": number,
        "start_min": 60.0 * (number - 1),
        "outcome": "completed",
        "headline": "Completed",
        "verdict": "good",
        "report": f"cycle-{number:03d}.html",
        "rmse_mm": 0.1523,
        "secretion_before_ml": 2.6181,
        "removed_ml": 2.5631,
        "removed_percent": 97.9,
        "negative_pressure_s": 14.5123,
        "in_airway_s": 20.91,
        "inside_at_end": False,
        "harm": [],
        "told": [],
        "spo2_nadir_percent": 95.2341,
        "lung_volume_loss_ml": 248.31,
        "alarms": [],
        "catheter_age_h": 0.9751,
        "catheter_changed": False,
        "gap": None,
    }
    return record_of(DayCycleResult, complete | changes)


def day(*cycles: DayCycleResult, **changes: Any) -> DayResult:
    """A day with these cycles, with keys of its JSON replaced."""
    complete: dict[str, Any] = {
        "repeat": len(cycles),
        "every_min": 60.0,
        "produced_ml": 6.5,
        "removed_ml": 8.1,
    }
    return record_of(DayResult, complete | changes)._replace(cycles=cycles)


def samples() -> DaySamples:
    """Of the whole day."""
    return DaySamples(*(np.linspace(0.0, 1.0, 50) for _ in range(4)))
