"""Interface of the controller, once in each tick: readings and requests in, commands out.

Readings of the machine and the patient monitor; people's requests, and the reports of the host
process; commands to the actuators; the message to the drives and the bedside annunciator.
"""

from typing import NamedTuple

from opensuction.kernel.codegen import row
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import make_zero


class Requests(NamedTuple):
    """Buttons of one tick; each is true as long as it is pressed.

    It acts once (`opensuction.procedure.cycle.button`); only `abort` acts as long as it is held.
    """

    start: bool
    """Begin a cycle (PARKED only)."""
    identify: bool
    """Bench: run the identification excitation (PARKED only)."""
    abort: bool
    """Stop and come out, whatever is going on."""
    reset: bool
    """Leave HALTED after the cause has been dealt with; clear alarms that have ended."""
    teach: bool
    """Let a person move the catheter (PARKED only)."""
    confirm: bool
    """Teaching: the tip is at the carina."""
    home: bool
    """Teaching: the drive shall bring the head home."""
    service: bool
    """Everything off for catheter change or cleaning (PARKED, or HALTED with the head home; locked
    out, wherever it is)."""
    changed: bool
    """Out of service: the catheter is a new one."""
    return_to_service: bool
    """Out of service: hands are off, the machine may be used."""
    not_needed: bool
    """The assessment that was due found nothing to suction."""
    acknowledge: bool
    """Alarms: silence what is shown now."""
    audio_pause: bool
    """Alarms: begin an audio pause, or end the one that runs."""
    assessed: bool
    """A person has looked at the patient: passes are counted anew (at rest only)."""
    oxygenated: bool
    """The pre-oxygenation that was asked for has been given (PARKED only)."""
    oxygen_skipped: bool
    """A person decides to go without it; takes nothing back that was confirmed (PARKED only)."""


STOP = "abort"
"""The button that stops: it acts as long as it is held, and waits for nothing."""


class Host(NamedTuple):
    """Reports of the process around the core on itself."""

    overrun: bool
    """The previous tick ended after its deadline."""
    conditions: int
    """What only the host can see, as a mask of alarm conditions (`condition_mask`): a late
    message, a recorder or console that is lost, reserve energy in use. It can only add alarms."""


NO_REQUESTS = make_zero(Requests)
START = NO_REQUESTS._replace(start=True, oxygen_skipped=True)
"""Begin at once: the pre-oxygenation that a patient needs is skipped, on record, unless it has been
confirmed before."""
IDENTIFY = NO_REQUESTS._replace(identify=True)
ABORT = NO_REQUESTS._replace(abort=True)
RESET = NO_REQUESTS._replace(reset=True)
TEACH = NO_REQUESTS._replace(teach=True)
CONFIRM = NO_REQUESTS._replace(confirm=True)
HOME = NO_REQUESTS._replace(home=True)
SERVICE = NO_REQUESTS._replace(service=True)
CHANGED = NO_REQUESTS._replace(changed=True)
RETURN_TO_SERVICE = NO_REQUESTS._replace(return_to_service=True)
ASSESSED = NO_REQUESTS._replace(assessed=True)
OXYGENATED = NO_REQUESTS._replace(oxygenated=True)
OXYGEN_SKIPPED = NO_REQUESTS._replace(oxygen_skipped=True)


class Setpoints(NamedTuple):
    """Setpoints of the machine in a tick, before the servos turn them into volts.

    Procedure and control propose one of these; the governor may only narrow it.
    """

    head_mm: float
    """Catheter head position (u_FF)."""
    head_mm_per_s: float
    """Velocity that belongs to it; the feedforward uses it."""
    insertion_on: bool
    """Torque of the insertion drive; off, a hand may move the head."""
    valve_open: bool
    """Cam towards open or towards closed, at the machine's cam speed."""
    pump_on: bool
    vacuum_mmhg: float
    """Regulator set point."""


class Commands(NamedTuple):
    """Actuator commands of one tick, as the governor let them through."""

    head_mm: float
    insertion_v: float
    insertion_on: bool
    """Torque of the insertion drive."""
    cam_rad: float
    valve_v: float
    valve_on: bool
    """Torque of the valve drive; off, the spring closes the valve."""
    pump_on: bool
    vacuum_mmhg: float


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


class DriveMessage(NamedTuple):
    """Commands of a tick, and what people shall be told with them."""

    commands: Commands
    wanted: int
    """Mask of the conditions that people shall be told."""
    reset: bool
    """A person pressed the button."""
    released: bool
    """The controller has just started: drives that act on their own obey it again."""
    head_mm_per_s: float = 0.0
    """Speed that belongs to the commanded head position, for drives with a servo of their own. It
    is the plan's where that position is bound to where the head was read."""


MESSAGE_COLUMNS = row.columns(DriveMessage)
"""Columns of the row that passes."""
