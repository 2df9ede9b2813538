"""The controller: readings and requests in, commands out, one pure step a tick.

procedure (what) -> control (how) -> governor (may it?) -> servos -> commands. The servos come
last because the governor's own reactions, hold and withdraw, need them too.
"""

import math
from typing import NamedTuple

from opensuction.control import compensation, servo, valve
from opensuction.control.compensation import Compensation, Rest
from opensuction.control.exact_inverse import HeadState
from opensuction.control.servo import Servo, ServoState
from opensuction.control.valve import ValveMotion
from opensuction.kernel.commands import Commands, Setpoints
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.kernel.readings import Readings
from opensuction.kernel.requests import Host, Requests
from opensuction.procedure import cycle, progress, upkeep
from opensuction.procedure.cycle import Demand
from opensuction.procedure.plan import Plan
from opensuction.procedure.progress import ProcedureState, Surroundings
from opensuction.procedure.upkeep import Refusal, Service, Upkeep
from opensuction.safety import governor
from opensuction.safety.governor import GovernorState, Verdict
from opensuction.safety.limits import Limits
from opensuction.safety.trip import Reaction
from opensuction.safety.watch import Watch


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


class State(NamedTuple):
    """Everything the controller remembers."""

    procedure: ProcedureState
    upkeep: Upkeep
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
    check_item: int
    """Item of the pre-use test that is being tested; see `check.CheckItem`."""
    check_failed: int
    """Item of the last pre-use test that failed."""
    taught: int
    """What became of the last confirmation; see `teaching.Taught`."""
    taught_mm: float
    """Travel length that was taught: tube's lower end to carina; 0 where none was taken."""
    refusal: int
    """Why the last start was refused; see `upkeep.Refusal`."""
    assessment_due: bool
    """A person shall look at the patient, and start a cycle or find none needed."""
    catheter_age_s: float


def start(settings: Settings, head_mm: float, catheter_age_s: float) -> State:
    """State at power-up with the head read at ``head_mm``.

    catheter_age_s: since the catheter's first use; not known (nan) is over its life.
    With the head away from its park position, or not known (nan), the machine halts: a reset then
    withdraws it first.
    """
    motion = settings.plan.motion
    parked = abs(head_mm - motion.park_head_mm) <= motion.settle_mm + progress.HOME_MM
    procedure = cycle.parked(settings.plan)
    led = compensation.parked(settings.compensation, settings.parked)
    watch = governor.start(settings.limits, head_mm)
    if not parked:
        procedure = procedure._replace(phase=int(Phase.HALTED))
        led = led._replace(head_mm=watch.last.head_mm)
    return State(
        procedure=procedure,
        upkeep=upkeep.start(catheter_age_s),
        compensation=led,
        insertion_servo=ServoState(error=0.0, velocity=0.0),
        valve_servo=ServoState(error=0.0, velocity=0.0),
        cam_rad=0.0,
        governor=watch,
        tripped=False,
        powerless=False,
    )


def waited(state: State, duration_s: float) -> State:
    """The controller after a time parked, in which its host did not step it: its clocks go on.

    Nothing else of it changes by itself while it is parked.
    """
    return state._replace(upkeep=upkeep.waited(state.upkeep, duration_s))


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
    by_hand = not demand.insertion_on
    if phase == Phase.HALTED.value or by_hand:
        return compensation.held(state.compensation, state.governor.last.head_mm, 0.0)
    if demand.homing:
        # From what was let through: the compensation may be far ahead of what the head can do.
        led = state.compensation
        let_through = compensation.held(led, state.governor.last.head_mm, led.head_mm_per_s)
        home_mm = settings.plan.motion.park_head_mm + demand.jog_mm
        speed = settings.plan.motion.abort_mm_per_s
        if phase == Phase.TEACHING.value:
            speed = settings.plan.teaching.home_mm_per_s
        sent = compensation.home(settings.compensation, let_through, home_mm, speed, dt_s)
        if phase == Phase.CHECKING.value:
            # The jog stays within the gap: it moves no tip, though the model has none so sharp.
            return compensation.rested(
                settings.compensation, settings.parked, led, sent.head_mm, sent.head_mm_per_s
            )
        return sent
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
    in_service: bool,
    dt_s: float,
) -> tuple[ServoState, ServoState, Commands]:
    """Servos of both axes on the setpoints that were let through.

    in_service: otherwise hands are in the machine, and nothing moves, not even to withdraw.
    """
    insertion_on = verdict.insertion_on and in_service
    valve_on = verdict.valve_on and in_service
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
        insertion_v=insertion_v if insertion_on else 0.0,
        insertion_on=insertion_on,
        cam_rad=cam,
        valve_v=valve_v if valve_on else 0.0,
        valve_on=valve_on,
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
        upkeep=state.upkeep,
        compensation=compensation.rested(
            settings.compensation, settings.parked, state.compensation, watch.last.head_mm, 0.0
        ),
        insertion_servo=state.insertion_servo,
        valve_servo=state.valve_servo,
        cam_rad=state.cam_rad,
        governor=watch,
        tripped=False,
        powerless=False,
    )


@compiled
def _granted(requests: Requests, start: bool) -> Requests:
    """The same requests with the start that was granted, a person's or the clock's."""
    return Requests(
        start=start,
        identify=requests.identify,
        abort=requests.abort,
        reset=requests.reset,
        teach=requests.teach,
        confirm=requests.confirm,
        home=requests.home,
        service=requests.service,
        changed=requests.changed,
        return_to_service=requests.return_to_service,
        not_needed=requests.not_needed,
    )


@compiled
def step(settings: Settings, state: State, inputs: Inputs) -> tuple[State, Outputs]:
    """One tick of the controller; no clock, no I/O, nothing hidden."""
    dt_s = inputs.dt_s
    requests = inputs.requests
    before = state.procedure.phase
    cleared = (before == Phase.HALTED.value and requests.reset) or (
        before == Phase.OUT_OF_SERVICE.value and requests.return_to_service
    )
    if cleared and not requests.abort:
        state = _acknowledged(settings, state)
    asked = upkeep.is_asked(settings.service, state.upkeep, before, requests)
    refused = upkeep.refusal(settings.service, state.upkeep, before, settings.plan.travel_known)
    touched = state.procedure.phase == Phase.INSERTING.value and progress.is_contact(
        inputs.readings
    )
    here, here_mm, tip_mm = state.compensation, 0.0, 0.0
    if touched:
        head_mm = _head_mm(state, inputs.readings)
        here, here_mm = compensation.stopped(settings.compensation, state.compensation, head_mm)
    if touched or requests.confirm:
        head_mm = _head_mm(state, inputs.readings)
        tip_mm = compensation.pushed_mm(settings.compensation, settings.parked.head_mm, head_mm)
    around = Surroundings(
        head_wanted_mm=state.compensation.head_mm,
        head_wanted_mm_per_s=state.compensation.head_mm_per_s,
        tripped=state.tripped,
        powerless=state.powerless,
        here_mm=here_mm,
        tip_mm=tip_mm,
    )
    procedure, demand = cycle.step(
        settings.plan,
        state.procedure,
        inputs.readings,
        _granted(requests, asked and refused == Refusal.NONE.value),
        around,
        dt_s,
    )
    from_here = touched and procedure.phase == Phase.BACKING_OFF.value
    origin = here if from_here else state.compensation
    led = _lead(settings, state, origin, demand, procedure.phase, dt_s)
    proposal = Setpoints(
        head_mm=led.head_mm,
        head_mm_per_s=led.head_mm_per_s,
        insertion_on=demand.insertion_on,
        valve_open=demand.valve_open,
        pump_on=demand.pump_on,
        vacuum_mmhg=demand.vacuum_mmhg,
    )
    watch, allowed, verdict = governor.step(
        settings.limits, state.governor, proposal, inputs.readings, inputs.host.overrun, dt_s
    )
    insertion, valve_state, commands = _actuate(
        settings,
        state,
        allowed,
        verdict,
        watch.watch,
        procedure.phase != Phase.OUT_OF_SERVICE.value,
        dt_s,
    )
    kept = upkeep.step(state.upkeep, before, procedure.phase, asked, refused, requests, dt_s)
    following = State(
        procedure=procedure,
        upkeep=kept,
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
        check_item=procedure.check.item,
        check_failed=procedure.check.failed,
        taught=procedure.teaching.taught,
        taught_mm=procedure.teaching.taught_mm,
        refusal=kept.refusal,
        assessment_due=upkeep.is_prompting(settings.service, kept, procedure.phase),
        catheter_age_s=kept.catheter_age_s,
    )
