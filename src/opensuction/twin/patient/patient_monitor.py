"""The patient monitor at the bedside: what it passes on of saturation, heart rate and pressure.

The saturation comes from the oximeter, late; the heart rate from the electrocardiogram, averaged
over some beats; the pressure from the connector above the tube, a hundred times a second.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.readings import NO_MONITOR, Monitor


class PatientMonitor(NamedTuple):
    """One monitor and its cables."""

    present: bool
    """Whether the machine has one: a setting, not a fault."""
    linked: bool
    """Whether its values arrive."""
    probe_on: bool
    """Whether the oximeter's probe is on the finger."""
    beat_average_s: float
    """Time constant over which the heart rate is averaged."""


@compiled
def average(
    monitor: PatientMonitor, shown_per_min: float, rate_per_min: float, dt_s: float
) -> float:
    """Heart rate shown after a step, from the one shown before and the true one."""
    share = dt_s / (monitor.beat_average_s + dt_s)
    return shown_per_min + share * (rate_per_min - shown_per_min)


@compiled
def read(
    monitor: PatientMonitor,
    spo2_percent: float,
    heart_rate_per_min: float,
    airway_pressure_cmh2o: float,
) -> Monitor:
    """Monitor values that arrive at the machine."""
    if not (monitor.present and monitor.linked):
        return NO_MONITOR
    return Monitor(
        connected=True,
        spo2_percent=spo2_percent if monitor.probe_on else 0.0,
        spo2_valid=monitor.probe_on,
        heart_rate_per_min=heart_rate_per_min,
        heart_rate_valid=True,
        airway_pressure_cmh2o=airway_pressure_cmh2o,
        airway_pressure_valid=True,
    )
