"""Records of the controller: settings, state, inputs and outputs.

Check that the controller's settings are numbers, finite where required, of the right sign.

No value exceeds a limit of nan. With a negative gain of speed the limiter would let the head's
command further in than was proposed (docs/safety/proof.md).
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from opensuction.control.backlash_inverse import HeadState
from opensuction.control.compensation import Compensation, Rest
from opensuction.control.servo import Servo, ServoState, ValveMotion
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Commands, Host, Readings, Requests
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.interlocks import Counters, Interlocks, Service
from opensuction.procedure.cycle.plan import Plan
from opensuction.procedure.cycle.progress import ProcedureState
from opensuction.safety.alarm import alarm_state
from opensuction.safety.alarm.alarm_state import Signals
from opensuction.safety.governor.governor import GovernorState, Verdict
from opensuction.safety.limits import Limits


class Settings(NamedTuple):
    """Everything the controller is set to for one run."""

    plan: Plan
    service: Service
    compensation: Compensation
    parked: Rest
    """Where the compensator has the head parked."""
    insertion_servo: Servo
    valve_servo: Servo
    valve_motion: ValveMotion
    limits: Limits
    alarms: alarm_state.AlarmSettings


class CoreState(NamedTuple):
    """State of everything but compensation and alarms."""

    procedure: ProcedureState
    upkeep: Interlocks
    insertion_servo: ServoState
    valve_servo: ServoState
    cam_rad: float
    driven_v: float
    """Volts that the insertion motor had in the last tick, in the sense in which it obeys them."""
    governor: GovernorState
    tripped: bool
    powerless: bool
    reasons: int
    """Alarm conditions for which it halts; see `alarm_source.reasons`."""
    held: int
    """Mask of the buttons that were down in the last tick: one that is held asks once."""


class State(NamedTuple):
    """Everything the controller remembers."""

    core: CoreState
    compensation: HeadState
    alarms: alarm_state.AlarmState


class Inputs(NamedTuple):
    """Everything that reaches the controller in a tick."""

    tick: int
    dt_s: float
    """Length of a tick, the same in all of a run: time is counted in ticks, and one tick said to be
    twice as long would double all the time that has passed. A late tick is an overrun."""
    readings: Readings
    requests: Requests
    host: Host


class Outputs(NamedTuple):
    """Outputs of the controller in a tick; length taught and upkeep are in its state."""

    commands: Commands
    demand: Demand
    verdict: Verdict
    signals: Signals
    """Alarms: what people are told."""
    phase: int
    cause: int
    """Event that led into the phase."""
    check_item: int
    """Item of the pre-use test that is being tested; see `check_item.CheckItem`."""
    check_failed: int
    """Item of the last pre-use test that failed."""
    assessment_due: bool
    """A person shall look at the patient, and start a cycle or find none needed."""
    counters: Counters
    """Passes, rest, resets, pre-oxygenation, refusal, late ticks."""


OPEN = (
    "limits.line.clogged_share",
    "limits.driven_contact_s",
    "limits.mouth_mm",
    "limits.window.from_mm",
    "limits.window.by_mm",
    "plan.contact.suction_mm",
    "plan.limits_s",
)
"""What may be infinite: a line that cannot be told to be clogged, a contact that is searched for,
the light barrier of a bench that has none, a window as wide as the way, suction where the tip
stopped, and phases that wait for a person."""

POSITIVE = (
    "limits.drive.mm_per_s_per_v",
    "limits.drive.newton_per_a",
    "limits.drive.volts_per_a",
    "limits.head_mm_per_s2",
    "limits.head_speed_mm_per_s",
    "limits.leaving_mm_per_s",
    "limits.tip.gain",
)
"""What the controller divides by, or narrows with, and must be above 0."""
NOT_NEGATIVE = (
    "insertion_servo.back_emf_v_s",
    "insertion_servo.catch_up_v",
    "insertion_servo.voltage_limit_v",
    "limits.drive.supply_v",
    "limits.vacuum_mmhg",
    "limits.withdrawal_s",
    "valve_motion.open_rad",
    "valve_motion.speed_rad_per_s",
    "valve_servo.back_emf_v_s",
    "valve_servo.catch_up_v",
    "valve_servo.voltage_limit_v",
)
"""What must not be below 0: setpoints and volts would be outside their own limits."""


def _numbers(record: tuple[Any, ...], path: str) -> Iterator[tuple[str, float]]:
    """Every number with where it stands; those of a plain tuple under its own name."""
    names = getattr(record, "_fields", None)
    for i, value in enumerate(record):
        inner = path if names is None else f"{path}.{names[i]}".lstrip(".")
        if isinstance(value, tuple):
            yield from _numbers(value, inner)
        elif isinstance(value, float):
            yield inner, value


def check(settings: Settings) -> None:
    """Refuse settings in which a number is none, has no bound or the wrong sign.

    Raises InputError, which names it and says which it may have.
    """
    for path, value in _numbers(settings, ""):
        if math.isnan(value) or (math.isinf(value) and path not in OPEN):
            raise InputError(f"settings.{path} is {value}: it must be a finite number")
        if value < 0.0 and path in NOT_NEGATIVE:
            raise InputError(f"settings.{path} is {value}: it must not be below 0")
        if value <= 0.0 and path in POSITIVE:
            raise InputError(f"settings.{path} is {value}: it must be above 0")
