"""A made-up day for the tests of its page."""

from typing import Any

import numpy as np

from opensuction.report.sheet import Values


def cycle(number: int, **changes: Any) -> dict[str, Any]:
    """One cycle of the key ``day``, with keys replaced."""
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
    return complete | changes


def data(*cycles: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """JSON of a day with these cycles."""
    day: dict[str, Any] = {
        "repeat": len(cycles),
        "every_min": 60.0,
        "cycles": list(cycles),
        "produced_ml": 6.5,
        "removed_ml": 8.1,
        "refusal": None,
        "notes": [],
    }
    names = dict.fromkeys(("machine", "patient", "protocol", "approach", "version"), "x")
    return {**names, "seed": 1, "day": day | changes}


def samples() -> dict[str, Values]:
    """Of the whole day."""
    names = ("time_s", "secretion_ml", "spo2_percent", "lung_volume_loss_ml")
    return {name: np.linspace(0.0, 1.0, 50) for name in names}
