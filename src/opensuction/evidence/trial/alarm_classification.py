"""True and false alarms of a cycle without faults.

An alarm from the patient monitor is compared with the truth of the patient: a saturation below its
limit is told rightly, and so is the contact of a tip that touches. Any other alarm of a sound
machine is false.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from opensuction.kernel.phase import Phase
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.safety.patient_limit import PatientLimits
from opensuction.simulation import annunciation
from opensuction.simulation.trace import Columns

TOUCHED_TICKS = 500
"""For how long the tip must have touched something: less than contact is waited for."""
BROKEN_OFF = "broken off"
"""Said of a cycle that ends early and names no condition."""
COLUMNS = (
    "time_s",
    "phase",
    "verdict.trips",
    "truth.spo2_percent",
    "truth.heart_rate_per_min",
    "truth.airway_pressure_cmh2o",
    "truth.contact_n",
    *annunciation.COLUMNS,
)
"""What is looked at."""


def _is_desaturated(columns: Columns, limits: PatientLimits) -> bool:
    return bool(columns["truth.spo2_percent"].min() < limits.spo2_percent)


def _is_bradycardic(columns: Columns, limits: PatientLimits) -> bool:
    return bool(columns["truth.heart_rate_per_min"].min() < limits.heart_rate_per_min)


def _is_pressure_unsafe(columns: Columns, limits: PatientLimits) -> bool:
    pressure = columns["truth.airway_pressure_cmh2o"]
    least, most = limits.airway_least_cmh2o, limits.airway_most_cmh2o
    return bool(pressure.min() < least or pressure.max() > most)


def _is_losing_volume(columns: Columns, limits: PatientLimits) -> bool:
    return bool(columns["truth.airway_pressure_cmh2o"].min() < limits.airway_losing_cmh2o)


def _is_touching(columns: Columns, _: PatientLimits) -> bool:
    """Something was in the tip's way, such as the carina of a patient who has been moved."""
    return bool(columns["truth.contact_n"][-TOUCHED_TICKS:].min() > 0.0)


TRUE_WHERE: dict[Condition, Callable[[Columns, PatientLimits], bool]] = {
    Condition.SPO2_LOW: _is_desaturated,
    Condition.HEART_RATE_LOW: _is_bradycardic,
    Condition.AIRWAY_PRESSURE_UNSAFE: _is_pressure_unsafe,
    Condition.LUNG_VOLUME_LOST: _is_losing_volume,
    Condition.CONTACT_STUCK_CLOSED: _is_touching,
}
"""Conditions of the patient that may be there without any fault, and whether one was, by the truth
up to when it was said."""
CONSEQUENCES = (Condition.AUTOMATION_STOPPED,)
"""Said of every cycle that is broken off: as true as what has broken it off."""


class Spoken(NamedTuple):
    """False and true alarms of a sound cycle, by name."""

    false: tuple[str, ...]
    true: tuple[str, ...]


def _list_said(columns: Columns) -> dict[Condition, float]:
    """Conditions that tripped or were told, and when first."""
    first: dict[Condition, float] = {}
    for one in annunciation.told(columns):
        first.setdefault(one.condition, one.at_s)
    masks = columns["verdict.trips"].astype(np.int64)
    for trip in condition_mask.decode_trips(int(np.bitwise_or.reduce(masks))):
        at_s = float(columns["time_s"][np.argmax(masks >> int(trip) & 1)])
        first[trip] = min(at_s, first.get(trip, at_s))
    return first


def _is_so(condition: Condition, at_s: float, columns: Columns, limits: PatientLimits) -> bool:
    """True if what an alarm said at an instant had come to pass by then."""
    if condition not in TRUE_WHERE:
        return False
    ticks = int(np.searchsorted(columns["time_s"], at_s, side="right"))
    until = {name: columns[name][:ticks] for name in COLUMNS}
    return TRUE_WHERE[condition](until, limits)


def listen(columns: Columns, limits: PatientLimits) -> Spoken:
    """False and true alarms of a run, or a part of it from its start, in which nothing was wrong.

    columns: at least `COLUMNS`. limits: of the patient, as the controller has them.
    """
    said = _list_said(columns)
    held = {one for one, at_s in said.items() if _is_so(one, at_s, columns, limits)}
    if held:
        held |= {one for one in said if one in CONSEQUENCES}
    false = [one.name for one in said if one not in held]
    if not said and np.isin(columns["phase"], (Phase.ABORTING, Phase.HALTED)).any():
        false.append(BROKEN_OFF)
    return Spoken(tuple(false), tuple(one.name for one in said if one in held))
