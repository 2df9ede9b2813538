"""Readings of the machine and the patient monitor in each tick."""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero

LARGEST = 1.0e6
"""Largest reading in mm, rad, mmHg or A that is a number: no machine comes near it, and no speed or
force that is computed from it overflows."""


class Monitor(NamedTuple):
    """Values of a patient monitor at the bedside, where there is one; with flags as `Readings`."""

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


NO_MONITOR = make_zero(Monitor)
"""No monitor: on the bench, or where its link is lost."""


class Readings(NamedTuple):
    """Sensor values of one tick, each with a flag: an invalid value is data, never a guess.

    There is no tip position here: only whether the tip is out at the tube's mouth.
    """

    head_mm: float
    """Insertion axis encoder: position of the catheter head (x)."""
    head_valid: bool
    carriage_mm: float
    """Second sensor of the same position, on the catheter head itself: behind gear and rack, in the
    same zero as the encoder, which sits on the motor."""
    carriage_valid: bool
    cam_rad: float
    """Valve axis encoder: angle of the cam; 0 is closed."""
    cam_valid: bool
    line_vacuum_mmhg: float
    """Vacuum in the canister, positive below atmosphere."""
    vacuum_valid: bool
    contact_closed: bool
    """Contact switch at the tip."""
    contact_valid: bool
    """The switch's line is closed through a resistor in the tip: without tip, or cut, it is not."""
    mouth_clear: bool
    """Light barrier in the connector above the tube's mouth: no catheter in its beam. Dark, dirty
    or cut off it reads not clear, and so it has no flag."""
    insertion_current_a: float
    """Current of the insertion motor."""
    monitor: Monitor
    """Of the patient; its values are older than a tick."""


@compiled
def is_number(value: float) -> bool:
    """True where a reading can be one: not a number, infinite and absurdly large ones cannot.

    What is averaged from such a value would stay not a number for ever, and no comparison with a
    limit would hold any more.
    """
    return abs(value) <= LARGEST
