"""What the patient's monitor says against the patient's limits, and for how long it has said so.

How long something must hold is chosen for what the reading is worth. The saturation is 10 to 30 s
old when it is shown [K]: in a cycle it can only tell of what began before, so waiting 2 s more for
an artefact to pass costs nothing, and no abort relies on it alone. Heart rate (an average of
seconds already) and airway pressure are what act within a cycle.

The airway pressure is read at the connector, against the ventilator's settings: every breath must
cross a line just above PEEP, both ways. Suction that takes more than the ventilator gives empties
the lung, and the pressure falls below PEEP - 5 cmH2O [design]; a circuit that has come off leaves
the connector at the pressure of the room, whatever is sucked: with more PEEP than 5 cmH2O volume is
lost then too. A pressure that no breath moves is
ventilation that fails, an expiration that is blocked or a reading that is frozen.
"""

import math
from typing import NamedTuple

from opensuction.kernel.age_group import AgeGroup
from opensuction.kernel.compiled import compiled
from opensuction.kernel.monitor import Monitor
from opensuction.safety.trip import Trip

SPO2_S = 2.0
"""How long the saturation must be low: four values of the display."""
HEART_RATE_S = 1.0
"""How long the heart rate must be low: it is an average of beats already."""
HIGH_S = 0.2
"""How long the pressure must be too high: longer than a cough, shorter than an inspiration."""
LOW_S = 0.3
"""How long the pressure must be too low: a stroke of the valve shakes it for less."""
LINK_S = 2.0
"""How long a value may be missing: a monitor repeats itself within a second."""
LOST_CMH2O = 5.0
"""Pressure below PEEP at which lung volume is being lost. Source: DESIGN section 7."""
TRANSDUCER_CMH2O = 0.2
"""Error of the pressure that is no loss; assumed."""
ROOM_CMH2O = 1.0
"""Nearer than this to the atmosphere the connector may be open to the room."""
BREATH_CMH2O = 2.0
"""Above PEEP by this lies the line that each breath crosses."""
LEAST_PEEP_CMH2O = 3.0
"""With less PEEP an expiration looks like a circuit that is open to the room."""
OPEN_S = 1.0
"""How long the connector must be at the room's pressure to count as open; with little PEEP longer
than an expiration: as long as a breath may take. Suction that empties the lung passes through it in
half a second; assumed."""


class AgeLimits(NamedTuple):
    """What is set by age; sources in `SOURCES`."""

    spo2_percent: float
    heart_rate_per_min: float
    airway_most_cmh2o: float
    breath_s: float


AGE_LIMITS: dict[AgeGroup, AgeLimits] = {
    AgeGroup.NEONATE: AgeLimits(80.0, 100.0, 30.0, 4.0),
    AgeGroup.CHILD: AgeLimits(80.0, 80.0, 35.0, 6.0),
    AgeGroup.ADULT: AgeLimits(80.0, 50.0, 40.0, 10.0),
}
"""Limits by age group."""

SOURCES: dict[str, str] = {
    "spo2_percent": "[assumed] 88, the least aimed at in acute lung injury [K], less 5 that "
    "suction may take [F: Simarmata 2019, weak] and 3 of the oximeter [K]",
    "heart_rate_per_min": "bradycardia by age [K]",
    "airway_most_cmh2o": "usual upper alarm limit of ventilators [assumed]",
    "breath_s": "[assumed] apnoea alarms wait for 10 to 20 s [K]; sooner with small stores of "
    "oxygen",
}
"""Where each limit comes from."""

MEANINGS: dict[str, str] = {
    "spo2_percent": "lowest saturation, as the oximeter shows it",
    "heart_rate_per_min": "lowest heart rate",
    "airway_most_cmh2o": "highest pressure at the connector",
    "breath_s": "longest time in which no breath moves the pressure",
}
"""What each limit bounds."""


class PatientLimits(NamedTuple):
    """The limits of one patient."""

    monitored: bool
    """Whether a monitor belongs to the machine: without one nothing here is judged."""
    spo2_percent: float
    heart_rate_per_min: float
    airway_most_cmh2o: float
    airway_least_cmh2o: float
    """Below it lung volume is being lost."""
    breath_cmh2o: float
    """Every breath crosses it twice."""
    breath_s: float
    open_s: float


class PatientWatch(NamedTuple):
    """For how long without a break, s; a value that is missing neither counts nor ends it."""

    spo2_low_s: float
    heart_rate_low_s: float
    high_s: float
    low_s: float
    open_s: float
    """Connector at the room's pressure."""
    breath_s: float
    """Since the pressure last crossed the line."""
    raised: bool
    """On which side of it the pressure was last."""
    missing_s: float
    """Since every value was there."""
    conditions: int
    """Bit mask of what holds now, by the numbers of `trip.Trip`."""


UNSEEN = PatientWatch(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, raised=False, missing_s=0.0, conditions=0)
"""At power-up."""


def limits_of(age: AgeGroup, peep_cmh2o: float, monitored: bool) -> PatientLimits:
    """Limits for a patient of an age on a ventilator set to this PEEP."""
    chosen = AGE_LIMITS[age]
    return PatientLimits(
        monitored=monitored,
        spo2_percent=chosen.spo2_percent,
        heart_rate_per_min=chosen.heart_rate_per_min,
        airway_most_cmh2o=chosen.airway_most_cmh2o,
        airway_least_cmh2o=peep_cmh2o - LOST_CMH2O - TRANSDUCER_CMH2O,
        breath_cmh2o=peep_cmh2o + BREATH_CMH2O,
        breath_s=chosen.breath_s,
        open_s=OPEN_S if peep_cmh2o >= LEAST_PEEP_CMH2O else chosen.breath_s,
    )


@compiled
def _time(seconds: float, known: bool, holds: bool, dt_s: float) -> float:
    if not known:
        return seconds
    return seconds + dt_s if holds else 0.0


@compiled
def _bit(happened: bool, code: int) -> int:
    return 1 << code if happened else 0


@compiled
def step(
    limits: PatientLimits, watch: PatientWatch, monitor: Monitor, sucking: bool, dt_s: float
) -> PatientWatch:
    """Bring what is known of the patient up to this tick.

    sucking: the valve is not known to be closed. A pressure that is too low is then volume that
    suction takes; with the valve closed it is the ventilation.
    """
    if not limits.monitored:
        return watch
    pressure = monitor.airway_pressure_cmh2o
    has_spo2 = monitor.connected and monitor.spo2_valid and math.isfinite(monitor.spo2_percent)
    has_rate = (
        monitor.connected and monitor.heart_rate_valid and math.isfinite(monitor.heart_rate_per_min)
    )
    has_pressure = monitor.connected and monitor.airway_pressure_valid and math.isfinite(pressure)
    raised = pressure > limits.breath_cmh2o if has_pressure else watch.raised
    spo2_low_s = _time(watch.spo2_low_s, has_spo2, monitor.spo2_percent < limits.spo2_percent, dt_s)
    slow = monitor.heart_rate_per_min < limits.heart_rate_per_min
    heart_rate_low_s = _time(watch.heart_rate_low_s, has_rate, slow, dt_s)
    high_s = _time(watch.high_s, has_pressure, pressure > limits.airway_most_cmh2o, dt_s)
    low_s = _time(watch.low_s, has_pressure, pressure < limits.airway_least_cmh2o, dt_s)
    open_s = _time(watch.open_s, has_pressure, abs(pressure) <= ROOM_CMH2O, dt_s)
    breath_s = _time(watch.breath_s, has_pressure, raised == watch.raised, dt_s)
    missing_s = _time(watch.missing_s, True, not (has_spo2 and has_rate and has_pressure), dt_s)
    low = low_s > LOW_S
    # What suction took stays its doing while the valve closes.
    taken = sucking or watch.conditions >> Trip.LUNG_VOLUME_LOST & 1 == 1
    unsafe = high_s > HIGH_S or breath_s > limits.breath_s or (low and not taken)
    return PatientWatch(
        spo2_low_s=spo2_low_s,
        heart_rate_low_s=heart_rate_low_s,
        high_s=high_s,
        low_s=low_s,
        open_s=open_s,
        breath_s=breath_s,
        raised=raised,
        missing_s=missing_s,
        conditions=_bit(spo2_low_s > SPO2_S, Trip.SPO2_LOW)
        | _bit(heart_rate_low_s > HEART_RATE_S, Trip.HEART_RATE_LOW)
        | _bit(unsafe, Trip.AIRWAY_PRESSURE_UNSAFE)
        | _bit(low and taken, Trip.LUNG_VOLUME_LOST)
        | _bit(open_s > limits.open_s, Trip.CIRCUIT_DISCONNECTED)
        | _bit(missing_s > LINK_S, Trip.MONITOR_LINK_LOST),
    )


@compiled
def trips(conditions: int, inside: bool, entering: bool) -> int:
    """Those conditions that end a cycle: a bit mask of trips.

    inside: the tip may be in the airway. entering: since this tick. Outside there is nothing to
    withdraw, and what is wrong is the monitor's affair. Values that stay away inside do not end a
    cycle (docs/decisions/0009): they only keep the catheter from going in.
    """
    if not inside:
        return 0
    if entering:
        return conditions
    return conditions & ~(1 << Trip.MONITOR_LINK_LOST)
