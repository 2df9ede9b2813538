"""Cycles without a fault, one error of the machine's sensors larger than it is sold.

The others are drawn as sold. Every machine and patient is another one, by turns of all presets of
patients and both approaches.
"""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from opensuction.evidence.campaign import played_cycle
from opensuction.evidence.trial import judged_cycle, trial
from opensuction.evidence.trial.judged_cycle import JUDGED
from opensuction.kernel.errors import InputError
from opensuction.result.trial_result import Trial
from opensuction.safety.condition import Condition
from opensuction.simulation.injection.faulty_run import RowBuffer
from opensuction.twin import parameter
from opensuction.twin.parameter import SENSORS
from opensuction.twin.parameter_row import Parameter
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

TRIAL = Trial(faults="none", seed=1123)
CYCLES = 256
"""With errors at the largest value that a file may set, and parts at the end of what is drawn."""
SOLD_CYCLES = 2048
"""As sold."""
RUNG_CYCLES = 64
"""With a multiple of the worst machine's."""
MULTIPLES = (1.0, 2.0, 3.0, 5.0, 8.0, 13.0, 20.0)
IDEAL = {"vacuum_gain": 1.0, "current_gain": 1.0}
"""What has no error; 0 where nothing is written."""
ERRORS = (
    "vacuum_noise_mmhg",
    "vacuum_offset_mmhg",
    "vacuum_drift_mmhg",
    "vacuum_gain",
    "vacuum_step_mmhg",
    "vacuum_lag_s",
    "carriage_noise_mm",
    "carriage_zero_mm",
    "carriage_sensor_mm",
    "cam_noise_rad",
    "cam_zero_rad",
    "cam_encoder_rad",
    "current_noise_a",
    "current_offset_a",
    "current_drift_a",
    "current_gain",
    "current_step_a",
    "current_lag_s",
    "late_share",
)
CORNERS: dict[str, dict[str, int]] = {
    "relief": {"relief_mmhg": 1, "relief_ml_per_s_per_mmhg": -1, "pump_free_l_per_min": 1}
    | {"pump_occluded_mmhg": 1, "vacuum_gain": 1, "vacuum_noise_mmhg": 1},
    "leak": {"leak_ml_per_s_per_mmhg": 1, "canister_ml": -1, "vacuum_noise_mmhg": 1},
    "open line": {"pump_free_l_per_min": -1, "bore_l_per_min": 1, "vacuum_noise_mmhg": 1},
    "clogged": {"pump_free_l_per_min": 1, "bore_l_per_min": -1, "vacuum_noise_mmhg": 1},
    "apart": {"gear_backlash_mm": 1, "carriage_noise_mm": 1, "carriage_zero_mm": 1},
    "jam": {"insertion_friction_v": 1, "drive_a_per_n": 1, "current_gain": 1, "current_noise_a": 1},
    "force": {"drive_force_n": 1, "drive_a_per_n": 1, "current_gain": 1, "current_noise_a": 1},
    "drifting": {"no_load_mm_per_s": 1, "insertion_friction_v": 1, "drive_a_per_n": 1},
}
"""Parts that are all 2.5 standard deviations off at once, and which way; by what that is near."""
Row = dict[str, Any]


def worst(name: str) -> float:
    """By how much the worst machine that is drawn is off."""
    row = SENSORS[name]
    return row.value - IDEAL.get(name, 0.0) + parameter.SPREAD_LIMIT * row.spread


def is_two_sided(name: str) -> bool:
    """Whether the error may be either way."""
    return SENSORS[name].low < IDEAL.get(name, 0.0)


@contextmanager
def changed(values: dict[str, float], lively: bool = False) -> Iterator[None]:
    """Machines with these values, without a spread; lively: their patients are, else quiet."""
    tables = (parameter.BENCH, parameter.CLINICAL, *PATIENT_TABLES.values())
    kept = [dict(table) for table in tables]
    for table in tables:
        for name in values.keys() & table.keys():
            table[name] = table[name]._replace(value=values[name], spread=0.0)
        if "lively" in table:
            table["lively"] = table["lively"]._replace(value=float(lively), spread=0.0)
    try:
        yield
    finally:
        for table, before in zip(tables, kept, strict=True):
            table.update(before)


def _play(number: int, room: RowBuffer) -> tuple[str, ...]:
    """What stopped a cycle without a fault, or was said of it; nothing if all is well."""
    try:
        prepared, _ = trial.find_machine(TRIAL, number, lambda one: one)
    except InputError:
        return ("refused",)
    played = played_cycle.play_sound(prepared, room)
    case = judged_cycle.judge(number, played)
    trips = played.run.columns["verdict.trips"].astype(np.int64)
    first = int(trips[int(np.argmax(trips != 0))])
    said = tuple(f"trip {one.name}" for one in Condition if first >> one & 1)
    said += tuple(f"false alarm {name}" for name in case.false_alarms)
    said += tuple(f"bound {harm}" for harm in case.breaches)
    return said if said or case.completed else ("stopped without a trip",)


def play(values: list[dict[str, float]], cycles: int, room: RowBuffer, lively: bool = False) -> Row:
    """So many cycles, by turns of eight with each of the values; how many went wrong, and how."""
    found: Counter[str] = Counter()
    wrong = 0
    for number in range(cycles):
        with changed(values[number // 8 % len(values)], lively):
            said = _play(number, room)
        wrong += bool(said)
        found.update(said)
    return {"cycles": cycles, "wrong": wrong, "what": dict(found.most_common())}


def _settings(name: str, error: float) -> list[dict[str, float]]:
    ideal = IDEAL.get(name, 0.0)
    signs = (1.0, -1.0) if is_two_sided(name) else (1.0,)
    return [{name: ideal + sign * error} for sign in signs]


def measure(name: str, room: RowBuffer) -> Row:
    """One error at the largest value of a file, and by multiples of the worst machine's."""
    row = SENSORS[name]
    ends = (row.high, row.low) if is_two_sided(name) else (row.high,)
    largest = play([{name: end} for end in ends], CYCLES, room)
    rungs: list[Row] = []
    for multiple in MULTIPLES:
        error = multiple * worst(name)
        rungs.append({"multiple": multiple, "error": error})
        rungs[-1] |= play(_settings(name, error), RUNG_CYCLES, room)
        if rungs[-1]["wrong"]:
            break
    return {"error": name, "largest_value": row.high, "largest": largest, "rungs": rungs}


def measure_together(room: RowBuffer) -> Row:
    """As sold; with patients who cough, breathe and move; with every error at once."""
    worst_drawn = [
        {name: _settings(name, worst(name))[way * is_two_sided(name)][name] for name in ERRORS}
        for way in (0, 1)
    ]
    largest = [
        {name: row.low if way and is_two_sided(name) else row.high for name, row in _rows()}
        for way in (0, 1)
    ]
    return {
        "sold": play([{}], SOLD_CYCLES, room),
        "lively": play([{}], SOLD_CYCLES, room, lively=True),
        "worst": play(worst_drawn, CYCLES, room),
        "largest": play(largest, CYCLES, room),
    }


def measure_corners(room: RowBuffer) -> Row:
    """Machines whose parts are all at the end of what is drawn that brings them near a trip."""
    found: Row = {}
    for name, ways in CORNERS.items():
        values = {
            part: row.value + way * parameter.SPREAD_LIMIT * row.spread
            for part, way in ways.items()
            for row in (parameter.CLINICAL[part],)
        }
        found[name] = {"values": values} | play([values], CYCLES, room)
    return found


def _rows() -> list[tuple[str, Parameter]]:
    return [(name, SENSORS[name]) for name in ERRORS]


def make_room() -> RowBuffer:
    """Room for the cycles of a process."""
    return played_cycle.make_room(JUDGED)
