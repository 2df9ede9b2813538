"""The controller: readings and requests in, commands out, one pure step a tick.

procedure (what) -> control (how) -> governor (may it?) -> servos -> commands, and alarms. The
servos come after the governor because its own reactions, hold and withdraw, need them too.
"""

from opensuction.control import compensation, servo, valve
from opensuction.control.exact_inverse import HeadState
from opensuction.control.servo import ServoState
from opensuction.controller import alarm_source, leading
from opensuction.controller.record import Axes, Inputs, Memory, Outputs, Settings, State
from opensuction.kernel.commands import Commands, Setpoints
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import Requests
from opensuction.procedure.cycle import cycle, progress, upkeep
from opensuction.procedure.cycle.cycle import Demand
from opensuction.procedure.cycle.plan import Plan
from opensuction.procedure.cycle.progress import ProcedureState
from opensuction.procedure.cycle.upkeep import Refusal, Service, Upkeep
from opensuction.safety.alarm import alarm, alarm_state
from opensuction.safety.alarm.alarm_state import SILENT, Signals
from opensuction.safety.governor import governor
from opensuction.safety.governor.governor import Verdict
from opensuction.safety.handling import Reaction
from opensuction.safety.limits import Limits
from opensuction.safety.watch.watch import Watch


def start(settings: Settings, head_mm: float, catheter_age_s: float) -> State:
    """State at power-up with the head read at ``head_mm``.

    catheter_age_s: since the catheter's first use; not known (nan) is over its life.
    With the head away from its park position, or not known (nan), the machine halts: a reset then
    withdraws it first.
    """
    motion = settings.plan.motion
    parked = abs(head_mm - motion.park_head_mm) <= motion.settle_mm + progress.HOME_MM
    procedure = cycle.begin(settings.plan, Phase.PARKED if parked else Phase.HALTED)
    led = compensation.parked(settings.compensation, settings.parked)
    watch = governor.start(settings.limits, head_mm)
    if not parked:
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
        alarms=alarm_state.START,
    )


def pass_idle_time(state: State, duration_s: float) -> State:
    """The controller after a time parked, in which its host did not step it: its clocks go on.

    Nothing else of it changes by itself while it is parked.
    """
    return state._replace(upkeep=upkeep.pass_idle_time(state.upkeep, duration_s))


@compiled
def _actuate(
    axes: Axes,
    state: Memory,
    allowed: Setpoints,
    insertion_on: bool,
    valve_on: bool,
    seen: Watch,
    dt_s: float,
) -> tuple[ServoState, ServoState, Commands]:
    """Servos of both axes on the setpoints that were let through.

    insertion_on, valve_on: which may have torque.
    """
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
    cleared = (before == Phase.HALTED and requests.reset) or (
        before == Phase.OUT_OF_SERVICE and requests.return_to_service
    )
    return cleared and not requests.abort


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
    inserting = state.procedure.phase == Phase.INSERTING
    touched = inserting and progress.is_contact(readings)
    here, around = leading.surroundings(settings, state, led, readings, touched, requests.confirm)
    procedure, demand = cycle.step(
        settings.plan, state.procedure, readings, _granted(requests, start), around, dt_s
    )
    from_here = touched and procedure.phase == Phase.BACKING_OFF
    origin = here if from_here else led
    let_through_mm = state.governor.last.head_mm
    led = leading.lead(settings, led, origin, let_through_mm, demand, procedure.phase, dt_s)
    return procedure, demand, led


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
    planned_work = phase == Phase.OUT_OF_SERVICE
    return alarm.step(settings.alarms, alarms, wrong, planned_work, _buttons(requests), dt_s)


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
    start = asked and refused == Refusal.NONE
    procedure, demand, led = _decide(settings, state, led, inputs, start)
    watch, allowed, verdict = governor.step(
        settings.limits, state.governor, _proposal(led, demand), readings, inputs.host.overrun, dt_s
    )
    # Out of service hands are in the machine: nothing moves, not even to withdraw.
    in_service = procedure.phase != Phase.OUT_OF_SERVICE
    insertion_on = verdict.insertion_on and in_service
    valve_on = verdict.valve_on and demand.valve_on and in_service
    axes = Axes(settings.insertion_servo, settings.valve_servo, settings.valve_motion)
    insertion, valve_state, commands = _actuate(
        axes, state, allowed, insertion_on, valve_on, watch.watch, dt_s
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
        powerless=verdict.reaction == Reaction.TORQUE_OFF,
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
