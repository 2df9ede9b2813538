"""Records of the controller: settings, state, inputs and outputs."""

from typing import NamedTuple

from opensuction.control.compensation import Compensation, Rest
from opensuction.control.exact_inverse import HeadState
from opensuction.control.servo import Servo, ServoState
from opensuction.control.valve import ValveMotion
from opensuction.kernel.commands import Commands
from opensuction.kernel.readings import Readings
from opensuction.kernel.requests import Host, Requests
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
