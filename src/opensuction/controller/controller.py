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
from opensuction.procedure import cycle
from opensuction.procedure.cycle import Demand, ProcedureState, Surroundings
from opensuction.procedure.plan import Plan
from opensuction.safety import governor
from opensuction.safety.governor import GovernorState, Verdict
from opensuction.safety.limits import Limits
from opensuction.safety.trip import Reaction


class Settings(NamedTuple):
    """Everything the controller is set to for one run."""

    plan: Plan
    compensation: Compensation
    parked: HeadState
    """Compensator with the head at its park position; a reset goes back to it."""
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


def start(settings: Settings, head_mm: float) -> State:
    """State at power-up with the head read at ``head_mm``.

    With the head away from its park position the machine halts: a reset then withdraws it first.
    """
    away = abs(head_mm - settings.plan.motion.park_head_mm) > settings.plan.motion.settle_mm + 0.5
    procedure = cycle.parked()
    if away:
        procedure = procedure._replace(phase=int(Phase.HALTED))
    return State(
        procedure=procedure,
        compensation=settings.parked,
        insertion_servo=ServoState(error=0.0, velocity=0.0),
        valve_servo=ServoState(error=0.0, velocity=0.0),
        cam_rad=0.0,
        governor=governor.start(settings.limits, head_mm),
        tripped=False,
        powerless=False,
    )


@compiled
def _propose(
    settings: Settings, state: State, demand: Demand, held: bool, dt_s: float
) -> tuple[HeadState, Setpoints]:
    """Head command by the chosen compensation; a halted machine keeps its head where it is."""
    led = state.compensation
    if not held:
        led = compensation.step(
            settings.compensation,
            state.compensation,
            demand.reference_mm,
            demand.reference_mm_per_s,
            demand.direction,
            dt_s,
        )
    proposal = Setpoints(
        head_mm=state.governor.head_mm if held else led.head_mm,
        head_mm_per_s=0.0 if held else led.head_mm_per_s,
        valve_open=demand.valve_open,
        pump_on=demand.pump_on,
        vacuum_mmhg=demand.vacuum_mmhg,
    )
    return led, proposal


@compiled
def _actuate(
    settings: Settings,
    state: State,
    allowed: Setpoints,
    verdict: Verdict,
    inputs: Inputs,
    reading_mm: float,
) -> tuple[ServoState, ServoState, Commands]:
    """Servos of both axes on the setpoints that were let through."""
    dt_s = inputs.dt_s
    cam, cam_speed = valve.step(settings.valve_motion, state.cam_rad, allowed.valve_open, dt_s)
    insertion, insertion_v = servo.step(
        settings.insertion_servo,
        state.insertion_servo,
        allowed.head_mm,
        allowed.head_mm_per_s,
        reading_mm,
        dt_s,
    )
    cam_reading = inputs.readings.cam_rad if math.isfinite(inputs.readings.cam_rad) else cam
    valve_state, valve_v = servo.step(
        settings.valve_servo, state.valve_servo, cam, cam_speed, cam_reading, dt_s
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
def step(settings: Settings, state: State, inputs: Inputs) -> tuple[State, Outputs]:
    """One tick of the controller; no clock, no I/O, nothing hidden."""
    dt_s = inputs.dt_s
    around = Surroundings(
        head_command_mm=state.governor.head_mm, tripped=state.tripped, powerless=state.powerless
    )
    halted = state.procedure.phase == Phase.HALTED.value
    watch = state.governor
    led = state.compensation
    if halted and inputs.requests.reset:
        watch = governor.reset(watch)
        led = settings.parked
        around = Surroundings(
            head_command_mm=state.governor.head_mm, tripped=False, powerless=False
        )
    procedure, demand = cycle.step(
        settings.plan, state.procedure, inputs.readings, inputs.requests, around, dt_s
    )
    current = State(
        procedure=procedure,
        compensation=led,
        insertion_servo=state.insertion_servo,
        valve_servo=state.valve_servo,
        cam_rad=state.cam_rad,
        governor=watch,
        tripped=state.tripped,
        powerless=state.powerless,
    )
    held = procedure.phase == Phase.HALTED.value
    led, proposal = _propose(settings, current, demand, held, dt_s)
    watch, allowed, verdict = governor.step(
        settings.limits, watch, proposal, inputs.readings, inputs.host.overrun, dt_s
    )
    insertion, valve_state, commands = _actuate(
        settings, current, allowed, verdict, inputs, watch.reading_mm
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
        commands=commands, demand=demand, verdict=verdict, phase=procedure.phase
    )
