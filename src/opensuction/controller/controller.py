"""The controller: readings and requests in, commands out, one pure step a tick.

procedure (what) -> control (how) -> governor (may it?) -> servos -> commands, and alarms. The
servos come after the governor because its own reactions, hold and withdraw, need them too.
"""

from typing import NamedTuple

from opensuction.control import compensation, servo, valve
from opensuction.control.compensation import Compensation, Rest
from opensuction.control.exact_inverse import HeadState
from opensuction.control.servo import Servo, ServoState
from opensuction.control.valve import ValveMotion
from opensuction.controller import alarm_source
from opensuction.kernel.commands import Commands, Setpoints
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.kernel.readings import Readings, is_number
from opensuction.kernel.requests import Host, Requests
from opensuction.procedure import cycle, progress, upkeep
from opensuction.procedure.cycle import Demand
from opensuction.procedure.plan import Plan
from opensuction.procedure.progress import ProcedureState, Surroundings
from opensuction.procedure.upkeep import Refusal, Service, Upkeep
from opensuction.safety import alarm, alarm_state, governor
from opensuction.safety.alarm_state import SILENT, Signals
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
    alarms: alarm_state.Settings


class Axes(NamedTuple):
    """How both axes are driven."""

    insertion: Servo
    valve: Servo
    valve_motion: ValveMotion


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
    reasons: int
    """Alarm conditions for which it halts; see `alarm_source.reasons`."""
    alarms: alarm_state.State


class Memory(NamedTuple):
    """State without alarms and compensation: no array is in it, so handing it on costs nothing.

    Whoever takes a record with an array in it counts a reference to it, every tick: so here
    records with arrays go only where the arrays are used.
    """

    procedure: ProcedureState
    upkeep: Upkeep
    insertion_servo: ServoState
    valve_servo: ServoState
    cam_rad: float
    governor: GovernorState
    tripped: bool
    powerless: bool
    reasons: int


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
    signals: Signals
    """Alarms: what people are told."""
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
        reasons=alarm_source.NONE if parked else alarm_source.RECOVERY,
        alarms=alarm_state.start(),
    )


def waited(state: State, duration_s: float) -> State:
    """The controller after a time parked, in which its host did not step it: its clocks go on.

    Nothing else of it changes by itself while it is parked.
    """
    return state._replace(upkeep=upkeep.waited(state.upkeep, duration_s))


@compiled
def _head_mm(known_mm: float, readings: Readings) -> float:
    """Head as it is read in this tick; the last that was known where it is not."""
    if readings.head_valid and is_number(readings.head_mm):
        return readings.head_mm
    return known_mm


@compiled
def _lead(
    settings: Settings,
    led: HeadState,
    origin: HeadState,
    let_through_mm: float,
    demand: Demand,
    phase: int,
    dt_s: float,
) -> HeadState:
    """Head as the cycle wants it: home, kept where it is, or led from ``origin`` to the tip.

    led: as the last tick led it. let_through_mm: what the governor let through of that.
    """
    by_hand = not demand.insertion_on
    if phase == Phase.HALTED.value or by_hand:
        return compensation.held(led, let_through_mm, 0.0)
    if demand.homing:
        # From what was let through: the compensation may be far ahead of what the head can do.
        let_through = compensation.held(led, let_through_mm, led.head_mm_per_s)
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
    axes: Axes,
    state: Memory,
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
    cam, cam_speed = valve.step(axes.valve_motion, state.cam_rad, allowed.valve_open, dt_s)
    insertion, insertion_v = servo.step(
        axes.insertion,
        state.insertion_servo,
        allowed.head_mm,
        allowed.head_mm_per_s,
        seen.head_mm,
        dt_s,
    )
    valve_state, valve_v = servo.step(
        axes.valve, state.valve_servo, cam, cam_speed, seen.cam_rad, dt_s
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
def _acknowledged(limits: Limits, state: Memory) -> Memory:
    """A person has dealt with what halted the machine: the head begins again from where it is."""
    return Memory(
        procedure=state.procedure,
        upkeep=state.upkeep,
        insertion_servo=state.insertion_servo,
        valve_servo=state.valve_servo,
        cam_rad=state.cam_rad,
        governor=governor.reset(limits, state.governor),
        tripped=False,
        powerless=False,
        reasons=state.reasons,
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
        acknowledge=requests.acknowledge,
        audio_pause=requests.audio_pause,
    )


@compiled
def _is_attended(before: int, requests: Requests) -> bool:
    """Whether a person resets the machine or returns it to service in this tick."""
    cleared = (before == Phase.HALTED.value and requests.reset) or (
        before == Phase.OUT_OF_SERVICE.value and requests.return_to_service
    )
    return cleared and not requests.abort


@compiled
def _surroundings(
    settings: Settings,
    state: Memory,
    led: HeadState,
    readings: Readings,
    touched: bool,
    confirm: bool,
) -> tuple[HeadState, Surroundings]:
    """What the procedure learns of the rest, and the head as it is led from where it touched.

    touched: the tip has met something on its way in. confirm: a person says where the tip is.
    """
    here, here_mm, tip_mm = led, 0.0, 0.0
    if touched or confirm:
        head_mm = _head_mm(state.governor.watch.head_mm, readings)
        tip_mm = compensation.pushed_mm(settings.compensation, settings.parked.head_mm, head_mm)
        if touched:
            here, here_mm = compensation.stopped(settings.compensation, led, head_mm)
    around = Surroundings(
        head_wanted_mm=led.head_mm,
        head_wanted_mm_per_s=led.head_mm_per_s,
        tripped=state.tripped,
        powerless=state.powerless,
        here_mm=here_mm,
        tip_mm=tip_mm,
    )
    return here, around


@compiled
def _proposal(led: HeadState, demand: Demand) -> Setpoints:
    """What procedure and control want together."""
    return Setpoints(
        head_mm=led.head_mm,
        head_mm_per_s=led.head_mm_per_s,
        insertion_on=demand.insertion_on,
        valve_open=demand.valve_open,
        pump_on=demand.pump_on,
        vacuum_mmhg=demand.vacuum_mmhg,
    )


@compiled
def _outputs(
    service: Service,
    procedure: ProcedureState,
    kept: Upkeep,
    commands: Commands,
    demand: Demand,
    verdict: Verdict,
    signals: Signals,
) -> Outputs:
    """What leaves the controller, with procedure and upkeep as the tick ended."""
    return Outputs(
        commands=commands,
        demand=demand,
        verdict=verdict,
        signals=signals,
        phase=procedure.phase,
        cause=procedure.cause,
        check_item=procedure.check.item,
        check_failed=procedure.check.failed,
        taught=procedure.teaching.taught,
        taught_mm=procedure.teaching.taught_mm,
        refusal=kept.refusal,
        assessment_due=upkeep.is_prompting(service, kept, procedure.phase),
        catheter_age_s=kept.catheter_age_s,
    )


@compiled
def _wrong(
    plan: Plan,
    service: Service,
    state: Memory,
    procedure: ProcedureState,
    kept: Upkeep,
    inputs: Inputs,
    trips: int,
) -> tuple[int, int]:
    """Why the machine halts, and all that is wrong: masks of alarm conditions.

    state: as the tick began. procedure, kept: as it ended.
    """
    held = alarm_source.reasons(
        plan, state.procedure.phase, procedure, state.reasons, inputs.readings
    )
    refused = upkeep.refusal(
        service, kept, procedure.phase, plan.travel_known, state.governor.patient.conditions
    )
    return held, alarm_source.conditions(
        service, kept, procedure.phase, refused, held, trips, inputs.host.conditions
    )


@compiled
def _buttons(requests: Requests) -> alarm_state.Buttons:
    """What people press about alarms; who puts the machine back to work has dealt with them."""
    return alarm_state.Buttons(
        acknowledge=requests.acknowledge,
        audio_pause=requests.audio_pause,
        reset=(requests.reset or requests.return_to_service) and not requests.abort,
    )


@compiled
def memory(state: State) -> Memory:
    """The state without alarms and compensation."""
    return Memory(
        procedure=state.procedure,
        upkeep=state.upkeep,
        insertion_servo=state.insertion_servo,
        valve_servo=state.valve_servo,
        cam_rad=state.cam_rad,
        governor=state.governor,
        tripped=state.tripped,
        powerless=state.powerless,
        reasons=state.reasons,
    )


@compiled
def _decide(
    settings: Settings, state: Memory, led: HeadState, inputs: Inputs, start: bool
) -> tuple[ProcedureState, Demand, HeadState]:
    """Procedure and control: the cycle one tick on, what it asks for, and where the head goes."""
    readings, requests, dt_s = inputs.readings, inputs.requests, inputs.dt_s
    inserting = state.procedure.phase == Phase.INSERTING.value
    touched = inserting and progress.is_contact(readings)
    here, around = _surroundings(settings, state, led, readings, touched, requests.confirm)
    procedure, demand = cycle.step(
        settings.plan, state.procedure, readings, _granted(requests, start), around, dt_s
    )
    from_here = touched and procedure.phase == Phase.BACKING_OFF.value
    origin = here if from_here else led
    let_through_mm = state.governor.last.head_mm
    leading = _lead(settings, led, origin, let_through_mm, demand, procedure.phase, dt_s)
    return procedure, demand, leading


@compiled
def joined(memory: Memory, led: HeadState, alarms: alarm_state.State) -> State:
    """The whole state of its parts."""
    return State(
        procedure=memory.procedure,
        upkeep=memory.upkeep,
        compensation=led,
        insertion_servo=memory.insertion_servo,
        valve_servo=memory.valve_servo,
        cam_rad=memory.cam_rad,
        governor=memory.governor,
        tripped=memory.tripped,
        powerless=memory.powerless,
        reasons=memory.reasons,
        alarms=alarms,
    )


@compiled
def announce(
    settings: Settings,
    alarms: alarm_state.State,
    wrong: int,
    phase: int,
    requests: Requests,
    dt_s: float,
) -> tuple[alarm_state.State, Signals]:
    """The other half of a tick: what people are told of what is wrong.

    wrong: mask of alarm conditions. phase: as the tick ended.
    """
    planned_work = phase == Phase.OUT_OF_SERVICE.value
    return alarm.step(settings.alarms, alarms, wrong, planned_work, _buttons(requests), dt_s)


@compiled
def is_silent(alarms: alarm_state.State, wrong: int, requests: Requests) -> bool:
    """Whether `announce` would change nothing and tell nothing: most ticks are so."""
    return alarm.is_idle(alarms, wrong, _buttons(requests))


@compiled
def act(
    settings: Settings, state: Memory, led: HeadState, inputs: Inputs
) -> tuple[Memory, HeadState, Outputs, int]:
    """One half of a tick, without the alarms: all that moves anything.

    led: the compensation's state. Returns what is remembered, where the head is led, what leaves
    (its signals silent), and the mask of alarm conditions that `announce` must hear of. A loop that
    carries the parts of the state apart spares itself the alarms' arrays in every tick: a sixth of
    it.
    """
    readings, requests, dt_s = inputs.readings, inputs.requests, inputs.dt_s
    plan, service, before = settings.plan, settings.service, state.procedure.phase
    if _is_attended(before, requests):
        state = _acknowledged(settings.limits, state)
        led = compensation.rested(
            settings.compensation, settings.parked, led, state.governor.last.head_mm, 0.0
        )
    patient = state.governor.patient.conditions
    asked = upkeep.is_asked(service, state.upkeep, before, requests)
    refused = upkeep.refusal(service, state.upkeep, before, plan.travel_known, patient)
    start = asked and refused == Refusal.NONE.value
    procedure, demand, led = _decide(settings, state, led, inputs, start)
    watch, allowed, verdict = governor.step(
        settings.limits, state.governor, _proposal(led, demand), readings, inputs.host.overrun, dt_s
    )
    in_service = procedure.phase != Phase.OUT_OF_SERVICE.value
    axes = Axes(settings.insertion_servo, settings.valve_servo, settings.valve_motion)
    insertion, valve_state, commands = _actuate(
        axes, state, allowed, verdict, watch.watch, in_service, dt_s
    )
    kept = upkeep.step(state.upkeep, before, procedure.phase, asked, refused, requests, dt_s)
    trips = verdict.trips | verdict.patient
    reasons, wrong = _wrong(plan, service, state, procedure, kept, inputs, trips)
    following = Memory(
        procedure=procedure,
        upkeep=kept,
        insertion_servo=insertion,
        valve_servo=valve_state,
        cam_rad=commands.cam_rad,
        governor=watch,
        tripped=verdict.trips != 0,
        powerless=verdict.reaction == Reaction.TORQUE_OFF.value,
        reasons=reasons,
    )
    silent = _outputs(service, procedure, kept, commands, demand, verdict, SILENT)
    return following, led, silent, wrong


@compiled
def told(outputs: Outputs, signals: Signals) -> Outputs:
    """The same outputs with these signals."""
    return Outputs(
        commands=outputs.commands,
        demand=outputs.demand,
        verdict=outputs.verdict,
        signals=signals,
        phase=outputs.phase,
        cause=outputs.cause,
        check_item=outputs.check_item,
        check_failed=outputs.check_failed,
        taught=outputs.taught,
        taught_mm=outputs.taught_mm,
        refusal=outputs.refusal,
        assessment_due=outputs.assessment_due,
        catheter_age_s=outputs.catheter_age_s,
    )


@compiled
def step(settings: Settings, state: State, inputs: Inputs) -> tuple[State, Outputs]:
    """One tick of the controller; no clock, no I/O, nothing hidden."""
    following, led, outputs, wrong = act(settings, memory(state), state.compensation, inputs)
    alarms, signals = announce(
        settings, state.alarms, wrong, outputs.phase, inputs.requests, inputs.dt_s
    )
    return joined(following, led, alarms), told(outputs, signals)
