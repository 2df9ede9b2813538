"""What a patient monitor at the bedside tells the controller, where there is one."""

from typing import NamedTuple


class Monitor(NamedTuple):
    """Readings of a patient monitor, each with a flag: an invalid value is data, never a guess."""

    connected: bool
    """The link is up and values arrive."""
    spo2_percent: float
    """Oxygen saturation as the oximeter shows it: tens of seconds late."""
    spo2_valid: bool
    heart_rate_per_min: float
    """Averaged over some beats."""
    heart_rate_valid: bool
    airway_pressure_cmh2o: float
    """At the connector above the tube, against the atmosphere."""
    airway_pressure_valid: bool


ABSENT = Monitor(
    connected=False,
    spo2_percent=0.0,
    spo2_valid=False,
    heart_rate_per_min=0.0,
    heart_rate_valid=False,
    airway_pressure_cmh2o=0.0,
    airway_pressure_valid=False,
)
"""No monitor: on the bench, or where its link is lost."""
