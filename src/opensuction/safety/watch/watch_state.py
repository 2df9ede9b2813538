"""Records of the governor's watch: durations, readings and their evaluation."""

from typing import NamedTuple

from opensuction.kernel.record import make_zero
from opensuction.safety.head.drive_force import DriveForce
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.invalid_ticks import InvalidTicks
from opensuction.safety.limits import AdvanceBound, TipInterval
from opensuction.safety.watch.bus_watch import BusWatch
from opensuction.safety.watch.tip_force import ContactWindow, TipForce
from opensuction.safety.watch.vacuum_signature import LineFilter, LineWatch
from opensuction.safety.watch.valve_axis import ValveAxis


class Durations(NamedTuple):
    """Durations for which something has held without a break."""

    sucking_s: float
    """Valve not known to be closed."""
    inside_s: float
    """Tip possibly in the airway."""
    contact_s: float
    driven_contact_s: float
    """The same while the drive held the head, so that no hand moved it."""
    off_command_s: float
    """Head too far from its command."""
    stalled_s: float
    """Head reading frozen although the servo must be moving it."""
    overpressure_s: float
    jammed_s: float
    """Head held by more than friction."""
    overforce_s: float
    """Drive stronger than its current limit."""
    disagreeing_s: float
    """Motor and catheter head not at the same place."""
    adrift_s: float
    """Both sensors of the head away from what its motor can have done, together."""
    absent_s: float
    """No catheter at the tube's mouth, where it must be."""
    remaining_s: float
    """A catheter at the tube's mouth although its head is home."""


class Watch(NamedTuple):
    """Everything measured, up to this tick."""

    head_mm: float
    """Where its sensors and the motor have it, or had it last."""
    vote: HeadVote
    speed_mm_per_s: float
    """Measured head speed, averaged."""
    tip: TipInterval
    suction_start_mm: float
    """Least head reading since the valve left its seat."""
    advance: AdvanceBound
    runaway_ticks: int
    """For how long the head has been further in than its command explains."""
    overspeed_ticks: int
    """For how long it has been faster than any sound one."""
    cam_rad: float
    parked_closed: bool
    """Head parked and valve closed: whatever vacuum there is, it stays in the line."""
    open_contact_ticks: int
    bus: BusWatch
    late_ticks: int
    """In a row."""
    late_share: float
    """Of the ticks of the last `LATE_S`."""
    invalid: InvalidTicks
    durations: Durations
    drive: DriveForce
    window: ContactWindow
    pressed: TipForce
    """By the tip, whatever its switch says."""
    valve: ValveAxis
    line: LineWatch
    filter: LineFilter


NO_DURATIONS = make_zero(Durations)
