"""The controller: readings and requests in, commands out, one pure step a tick.

procedure (what) -> control (how) -> governor (may it?) -> servos -> commands. The servos come
last because the governor's own reactions, hold and withdraw, need them too.
"""

import math
from typing import NamedTuple

from opensuction.control import compensation, servo, valve
from opensuction.control.compensation import Compensation
from opensuction.control.exact_inverse import HeadState
from opensuction.control.servo import Servo, ServoState
from opensuction.control.valve import ValveMotion
from opensuction.kernel.commands import Commands, Setpoints
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.kernel.readings import Readings
from opensuction.kernel.requests import Host, Requests
from opensuction.procedure import cycle, progress
from opensuction.procedure.cycle import Demand
from opensuction.procedure.plan import Plan
from opensuction.procedure.progress import ProcedureState, Surroundings
from opensuction.safety import governor
from opensuction.safety.governor import GovernorState, Verdict
from opensuction.safety.limits import Limits
from opensuction.safety.trip import Reaction
from opensuction.safety.watch import Watch


class Settings(NamedTuple):
    """Everything the controller is set to for one run."""

    plan: Plan
    compensation: Compensation
    parked: HeadState
    """Compensator with the head at its park position."""
    insertion_servo: Servo
    valve_servo: Servo
    valve_motion: ValveMotion
    limits: Limits


class State(NamedTuple):
    """Everything the controller remembers."""

    procedure: ProcedureState
    compensation: HeadState
    insertion_servo: ServoState
    valve_servo: ServoState
    cam_rad: float
    governor: GovernorState
    tripped: bool
    powerless: bool


class Inputs(NamedTuple):
    """Everything that reaches the controller in a tick."""

    tick: int
    dt_s: float
    readings: Readings
    requests: Requests
    host: Host


class Outputs(NamedTuple):
    """Everything that leaves the controller in a tick."""

    commands: Commands
    demand: Demand
    verdict: Verdict
    phase: int
    cause: int
    """Event that led into the phase."""


def start(settings: Settings, head_mm: float) -> State:
    """State at power-up with the head read at ``head_mm``.

    With the head away from its park position, or not known (nan), the machine halts: a reset then
    withdraws it first.
    """
    motion = settings.plan.motion
    parked = abs(head_mm - motion.park_head_mm) <= motion.settle_mm + progress.HOME_MM
    procedure = cycle.parked(settings.plan)
    led = settings.parked
    watch = governor.start(settings.limits, head_mm)
    if not parked:
        procedure = procedure._replace(phase=int(Phase.HALTED))
        led = led._replace(head_mm=watch.head_mm)
    return State(
        procedure=procedure,
        compensation=led,
        insertion_servo=ServoState(error=0.0, velocity=0.0),
        valve_servo=ServoState(error=0.0, velocity=0.0),
        cam_rad=0.0,
        governor=watch,
        tripped=False,
        powerless=False,
    )


@compiled
def _head_mm(state: State, readings: Readings) -> float:
    """Head as it is read in this tick; the last that was known where it is not."""
    if readings.head_valid and math.isfinite(readings.head_mm):
        return readings.head_mm
    return state.governor.watch.head_mm


@compiled
def _lead(
    settings: Settings, state: State, origin: HeadState, demand: Demand, phase: int, dt_s: float
) -> HeadState:
    """Head as the cycle wants it: home, kept where it is, or led from ``origin`` to the tip."""
    if phase == Phase.HALTED.value:
        return compensation.held(state.compensation, state.governor.head_mm, 0.0)
    if demand.homing:
        # From what was let through: the compensation may be far ahead of what the head can do.
        led = state.compensation
        let_through = compensation.held(led, state.governor.head_mm, led.head_mm_per_s)
        park_head_mm = settings.plan.motion.park_head_mm
        return compensation.home(settings.compensation, let_through, park_head_mm, dt_s)
    return compensation.step(
        settings.compensation,
        origin,
        demand.reference_mm,
        demand.reference_mm_per_s,
        demand.direction,
        demand.starts_in_s,
        dt_s,
    )


@compiled
def _actuate(
    settings: Settings,
    state: State,
    allowed: Setpoints,
    verdict: Verdict,
    seen: Watch,
    dt_s: float,
) -> tuple[ServoState, ServoState, Commands]:
    """Servos of both axes on the setpoints that were let through."""
    cam, cam_speed = valve.step(settings.valve_motion, state.cam_rad, allowed.valve_open, dt_s)
    insertion, insertion_v = servo.step(
        settings.insertion_servo,
        state.insertion_servo,
        allowed.head_mm,
        allowed.head_mm_per_s,
        seen.head_mm,
        dt_s,
    )
    valve_state, valve_v = servo.step(
        settings.valve_servo, state.valve_servo, cam, cam_speed, seen.cam_rad, dt_s
    )
    commands = Commands(
        head_mm=allowed.head_mm,
        insertion_v=insertion_v if verdict.insertion_on else 0.0,
        insertion_on=verdict.insertion_on,
        cam_rad=cam,
        valve_v=valve_v if verdict.valve_on else 0.0,
        valve_on=verdict.valve_on,
        pump_on=allowed.pump_on,
        vacuum_mmhg=allowed.vacuum_mmhg,
    )
    return insertion, valve_state, commands


@compiled
def _acknowledged(settings: Settings, state: State) -> State:
    """A person has dealt with what halted the machine: the head begins again from where it is."""
    watch = governor.reset(settings.limits, state.governor)
    return State(
        procedure=state.procedure,
        compensation=compensation.held(settings.parked, watch.head_mm, 0.0),
        insertion_servo=state.insertion_servo,
        valve_servo=state.valve_servo,
        cam_rad=state.cam_rad,
        governor=watch,
        tripped=False,
        powerless=False,
    )


@compiled
def step(settings: Settings, state: State, inputs: Inputs) -> tuple[State, Outputs]:
    """One tick of the controller; no clock, no I/O, nothing hidden."""
    dt_s = inputs.dt_s
    requests = inputs.requests
    if state.procedure.phase == Phase.HALTED.value and requests.reset and not requests.abort:
        state = _acknowledged(settings, state)
    touched = state.procedure.phase == Phase.INSERTING.value and progress.is_contact(
        inputs.readings
    )
    here, here_mm = state.compensation, 0.0
    if touched:
        here, here_mm = compensation.stopped(
            settings.compensation, state.compensation, _head_mm(state, inputs.readings)
        )
    around = Surroundings(
        head_wanted_mm=state.compensation.head_mm,
        head_wanted_mm_per_s=state.compensation.head_mm_per_s,
        tripped=state.tripped,
        powerless=state.powerless,
        here_mm=here_mm,
    )
    procedure, demand = cycle.step(
        settings.plan, state.procedure, inputs.readings, requests, around, dt_s
    )
    from_here = touched and procedure.phase == Phase.BACKING_OFF.value
    origin = here if from_here else state.compensation
    led = _lead(settings, state, origin, demand, procedure.phase, dt_s)
    proposal = Setpoints(
        head_mm=led.head_mm,
        head_mm_per_s=led.head_mm_per_s,
        valve_open=demand.valve_open,
        pump_on=demand.pump_on,
        vacuum_mmhg=demand.vacuum_mmhg,
    )
    watch, allowed, verdict = governor.step(
        settings.limits, state.governor, proposal, inputs.readings, inputs.host.overrun, dt_s
    )
    insertion, valve_state, commands = _actuate(
        settings, state, allowed, verdict, watch.watch, dt_s
    )
    following = State(
        procedure=procedure,
        compensation=led,
        insertion_servo=insertion,
        valve_servo=valve_state,
        cam_rad=commands.cam_rad,
        governor=watch,
        tripped=verdict.trips != 0,
        powerless=verdict.reaction == Reaction.TORQUE_OFF.value,
    )
    return following, Outputs(
        commands=commands,
        demand=demand,
        verdict=verdict,
        phase=procedure.phase,
        cause=procedure.cause,
    )
