"""Long campaign: what a sound machine bears of its sensors' errors, by whole cycles and by hours.

What it writes is the page's docs/evidence/2026-11-23-tolerance.json.
"""

import json
from pathlib import Path

import pytest

from opensuction.kernel import random_stream
from opensuction.twin.sensor import sensor
from tests.evidence import tolerance_hour, tolerance_run
from tests.evidence.tolerance_loop import CALM

FOLDER = Path("runs") / "soak"
TICKS = 20_000


def count(name: str, errors: dict[str, float]) -> int:
    """How often something trips in 20 s with these errors."""
    sensors = tolerance_hour.sensors_of(errors)
    start = sensor.begin(sensors, CALM, random_stream.stream(5, 1))
    return tolerance_hour.hours()[name][1](sensors, start, TICKS)


@pytest.mark.parametrize(
    ("name", "errors"),
    [
        ("closed", {"vacuum_gain": 0.93}),
        ("resting", {"vacuum_noise_mmhg": 30.0}),
        ("vented", {"vacuum_offset_mmhg": 20.0}),
        ("cam", {"cam_zero_rad": 0.04}),
        ("head", {"carriage_zero_mm": 1.2}),
        ("head, sucking", {"carriage_sensor_mm": 0.6}),
        ("jam, bedside", {"current_gain": 1.3}),
        ("force, bedside", {"current_gain": 1.2}),
        ("force, bench", {"current_gain": 1.2}),
    ],
)
def test_an_hour_of_noise_would_show_a_threshold_that_is_too_near(
    name: str, errors: dict[str, float]
) -> None:
    assert count(name, errors) > 0
    assert count(name, {}) == 0


def test_a_leaking_line_fails_the_pre_use_test_and_a_sound_one_does_not() -> None:
    assert tolerance_hour.count_leaks(0.02, 5) == 0
    assert tolerance_hour.count_leaks(0.08, 5) == 5


@pytest.mark.soak
def test_sold_sensors_trip_nothing() -> None:
    """Figures to runs/soak."""
    room = tolerance_run.make_room()
    together = tolerance_run.measure_together(room)
    errors = [tolerance_run.measure(name, room) for name in tolerance_run.ERRORS]
    found = {
        "date": "2026-11-23",
        "seed": tolerance_run.TRIAL.seed,
        "together": together,
        "corners": tolerance_run.measure_corners(room),
        "errors": errors,
        "hours": tolerance_hour.measure(),
        "refusals": tolerance_hour.measure_refusals(),
        "force": tolerance_hour.measure_share(),
    }
    FOLDER.mkdir(parents=True, exist_ok=True)
    text = json.dumps(found, indent=1) + "\n"
    (FOLDER / "tolerance.json").write_text(text, encoding="utf-8")
    assert together["sold"]["wrong"] + together["worst"]["wrong"] == 0
    assert all(row["rungs"][0]["wrong"] == 0 for row in errors)
