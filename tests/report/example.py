"""A made-up cycle for the tests of the report: plausible numbers, no simulation."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from opensuction.result.cycle_result import CycleResult
from opensuction.result.plain import measured
from tests.report.record import record_of

Trace = dict[str, npt.NDArray[np.float64]]

TRIP = {
    "name": "vacuum-exceeded",
    "sentence": "the line vacuum is above its limit",
    "time_s": 16.9,
}
ALARM = {
    "condition": "vacuum-exceeded",
    "priority": "high",
    "sentence": "the line vacuum is above its limit",
    "remedy": "Check the regulator.",
    "started_s": 16.9,
    "ended_s": None,
    "latched": True,
    "acknowledged_s": None,
}


SUMMARY: dict[str, Any] = {
    "outcome": "completed",
    "machine": "bench",
    "protocol": "paper",
    "approach": "travel",
    "compensation": "exact-inverse",
    "patient": None,
    "seed": 1,
    "spread": 1.0,
    "version": "0.1.0",
    "phases": [
        {"name": "checking", "start_s": 0.0, "end_s": 0.5},
        {"name": "preloading", "start_s": 0.5, "end_s": 0.501},
        {"name": "inserting", "start_s": 0.501, "end_s": 10.5},
        {"name": "opening", "start_s": 10.5, "end_s": 12.5},
        {"name": "suctioning", "start_s": 12.5, "end_s": 19.5},
        {"name": "withdrawing", "start_s": 19.5, "end_s": 29.5},
        {"name": "closing", "start_s": 29.5, "end_s": 31.5},
    ],
    "tip": {
        "target_mm": 90.0,
        "reached_mm": 90.5,
        "stop_error_mm": 0.5,
        "rmse_mm": 0.76,
        "peak_error_mm": 2.0,
        "deepest_mm": 90.7,
        "end_mm": -0.2,
        "inside_at_end": False,
    },
    "timing": {
        "cycle_s": 31.5,
        "in_airway_s": 29.0,
        "negative_pressure_s": 20.4,
        "negative_pressure_budget_s": 24.0,
        "guideline_s": 15.0,
    },
    "vacuum": {"setpoint_mmhg": 120.0, "peak_mmhg": 124.0},
    "carina_force_peak_n": 0.0,
    "secretion": {"removed_ml": 2.53, "removed_percent": 84.3},
    "spo2_nadir_percent": None,
    "lung_volume_loss_ml": None,
    "trips": [],
    "alarms": [],
    "warnings": ["negative pressure lasts 21 s: over the guideline's 15 s; bench only"],
    "anatomy": {"carina_mm": 100.0, "cap_mm": 95.0, "tube_end_mm": 0.0},
    "identification": {"model": "modified-dahl", "slope": 0.9677},
    "wall_s": 0.2,
    "realtime_factor": 600.0,
}
"""A completed cycle of the paper's protocol, as JSON has it."""
GOOD = SUMMARY | {
    "timing": SUMMARY["timing"] | {"negative_pressure_s": 14.5, "negative_pressure_budget_s": 15.0},
    "warnings": [],
}
"""A completed cycle with nothing to look at."""
ABORTED = SUMMARY | {
    "outcome": "aborted",
    "phases": [
        {"name": "inserting", "start_s": 0.5, "end_s": 10.5},
        {"name": "suctioning", "start_s": 10.5, "end_s": 17.0},
        {"name": "aborting", "start_s": 17.0, "end_s": 24.0},
    ],
    "trips": [TRIP],
    "alarms": [ALARM],
}
"""A cycle that a safety limit ended at 17 s."""


def cycle(data: Mapping[str, Any]) -> CycleResult:
    """A cycle by what its JSON object has; without ``told`` every alarm was shown."""
    shown = [
        {"what": alarm.get("condition"), "at_s": alarm.get("started_s"), "by": "controller"}
        | {key: alarm.get(key) for key in ("priority", "sentence", "remedy")}
        for alarm in data.get("alarms") or ()
    ]
    return measured(record_of(CycleResult, {"told": shown, **data}))


def summary(**changes: Any) -> CycleResult:
    """A completed cycle of the paper's protocol, with top-level keys replaced."""
    return cycle(SUMMARY | changes)


def good(**changes: Any) -> CycleResult:
    """A completed cycle with nothing to look at, with top-level keys replaced."""
    return cycle(GOOD | changes)


def aborted(**changes: Any) -> CycleResult:
    """A cycle that a safety limit ended at 17 s, with top-level keys replaced."""
    return cycle(ABORTED | changes)


VITALS = {
    "spo2_percent": {
        "before": 96.1,
        "lowest": 91.4,
        "highest": 96.1,
        "at_end": 95.4,
        "is_back": True,
        "recovered_s": 71.0,
        "usual_least": 88.0,
        "usual_most": None,
        "limit_least": 80.0,
        "limit_most": None,
    },
    "heart_rate_per_min": {
        "before": 90.0,
        "lowest": 84.0,
        "highest": 90.0,
        "at_end": 90.0,
        "is_back": True,
        "recovered_s": 25.0,
        "usual_least": 72.0,
        "usual_most": None,
        "limit_least": 50.0,
        "limit_most": None,
    },
    "airway_pressure_cmh2o": {
        "before": 6.1,
        "lowest": 2.3,
        "highest": 15.7,
        "at_end": 6.0,
        "is_back": True,
        "recovered_s": 24.0,
        "usual_least": 0.8,
        "usual_most": 40.0,
        "limit_least": None,
        "limit_most": None,
    },
    "lung_volume_loss_ml": {
        "before": 0.0,
        "lowest": 0.0,
        "highest": 412.0,
        "at_end": 70.0,
        "is_back": False,
        "recovered_s": None,
        "usual_least": None,
        "usual_most": 488.0,
        "limit_least": None,
        "limit_most": None,
    },
}
"""Vital signs of a patient who bore a cycle well."""


def vitals(key: str, **changes: float | bool | None) -> dict[str, Any]:
    """Vital signs with changes of one of them."""
    signs: dict[str, Any] = {name: dict(sign) for name, sign in VITALS.items()}
    signs[key] |= changes
    return signs


def told(what: str, by: str, at_s: float = 13.3, priority: str = "high") -> dict[str, Any]:
    """An entry of what the annunciator showed."""
    sentence = what.replace("-", " ")
    return {
        "what": what,
        "at_s": at_s,
        "by": by,
        "priority": priority,
        "sentence": sentence,
        "remedy": "Look at the patient.",
    }


def trace(rows: int = 31_501) -> Trace:
    """Trace of such a cycle at 1 kHz: a trapezoid, with the head ahead of the tip by the slack."""
    time_s = np.arange(rows) * 1e-3
    reference = np.interp(time_s, [0.5, 10.5, 19.5, 29.5], [0.0, 90.0, 90.0, 0.0])
    inward = time_s < 15.0
    tip = reference + 0.5 * np.sin(time_s)
    valve = np.interp(time_s, [10.5, 12.5, 29.5, 31.5], [0.0, 1.0, 1.0, 0.0])
    return {
        "time_s": time_s,
        "readings.head_mm": reference + np.where(inward, 20.0, 0.0) * (reference > 0.0),
        "demand.reference_mm": reference,
        "verdict.deepest_mm": reference + 3.0,
        "truth.tip_mm": tip,
        "truth.laser_mm": tip + 0.1 * np.sin(137.0 * time_s),
        "truth.valve_open_ratio": valve,
        "readings.line_vacuum_mmhg": np.full(rows, 120.0),
        "truth.tip_vacuum_mmhg": 100.0 * valve,
        "truth.secretion_removed_ml": np.interp(time_s, [12.5, 20.0], [0.0, 2.53]),
        "truth.contact_n": np.zeros(rows),
    }


CHECKS = [
    {
        "name": "vacuum",
        "value": 120.0,
        "limit": 150.0,
        "unit": "mmHg",
        "strict": False,
        "ok": True,
        "source": "pump to be used at no more than 150, [paper] II-B",
    },
    {
        "name": "catheter over tube diameter",
        "value": 0.533,
        "limit": 0.5,
        "unit": "",
        "strict": True,
        "ok": False,
        "source": "under .5 of the diameter, [AARC-2022]",
    },
]


ON_PATIENT: dict[str, Any] = SUMMARY | {
    "machine": "clinical",
    "protocol": "adult",
    "approach": "contact",
    "patient": "adult-icu",
    "phases": [
        *SUMMARY["phases"][:3],
        {"name": "backing_off", "start_s": 10.5, "end_s": 11.0},
        {"name": "opening", "start_s": 11.0, "end_s": 12.5},
        *SUMMARY["phases"][4:],
        {"name": "parked", "start_s": 31.5, "end_s": 121.5},
    ],
    "tip": SUMMARY["tip"]
    | {"target_mm": 90.0, "reached_mm": 90.4, "stop_error_mm": 0.4, "deepest_mm": 100.7},
    "carina_force_peak_n": 0.137,
    "spo2_nadir_percent": 91.4,
    "lung_volume_loss_ml": 412.0,
    "airway_pressure_least_cmh2o": -2.3,
    "checks": CHECKS,
    "abort": None,
    "warnings": [],
    "anatomy": {
        "carina_mm": 100.0,
        "cap_mm": 113.0,
        "tube_end_mm": 0.0,
        "patient_boundary_mm": -80.0,
    },
}
"""A cycle on a ventilated patient that stopped by contact."""


def on_patient(**changes: Any) -> CycleResult:
    """A cycle on a ventilated patient that stopped by contact, with top-level keys replaced."""
    return cycle(ON_PATIENT | changes)


def breathing_trace(rows: int = 121_500) -> Trace:
    """Trace of such a cycle, which parks behind the tube, and of the 90 s after it."""
    traced = trace(rows)
    time_s = traced["time_s"]
    depth = np.interp(time_s, [0.5, 10.5, 19.5, 29.5], [-100.0, 90.0, 90.0, -100.0])
    breath = 0.5 - 0.5 * np.cos(2.0 * np.pi * time_s / 4.0)
    loss = np.interp(time_s, [12.0, 20.0, 30.0, 121.0], [0.0, 412.0, 380.0, 60.0])
    suction = np.interp(time_s, [11.0, 12.5, 29.5, 31.5], [0.0, 7.0, 7.0, 0.0])
    return traced | {
        "demand.reference_mm": depth,
        "truth.tip_mm": depth + 0.4,
        "truth.laser_mm": depth + 0.5,
        "verdict.deepest_mm": depth + 3.0,
        "readings.head_mm": depth + np.where(time_s < 15.0, 10.0, 0.0),
        "truth.contact_n": np.interp(time_s, [10.3, 10.5, 10.8], [0.0, 0.137, 0.0]),
        "truth.airway_pressure_cmh2o": 8.0 + 14.0 * breath - suction,
        "truth.lung_volume_ml": 1700.0 + 420.0 * breath - loss,
        "truth.lung_volume_loss_ml": loss,
        "truth.heart_rate_per_min": np.interp(time_s, [10.0, 20.0, 30.0], [90.0, 84.0, 90.0]),
        "truth.spo2_percent": np.interp(time_s, [30.0, 55.0, 121.0], [97.0, 91.4, 95.5]),
    }
