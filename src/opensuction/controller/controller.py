"""The controller: readings and requests in, commands out, one pure step a tick.

procedure (what) -> control (how) -> governor (may it?) -> servos -> commands, and alarms. The
servos come after the governor because its own reactions, hold and withdraw, need them too.
"""

from opensuction.control import compensation, servo
from opensuction.control.backlash_inverse import HeadState
from opensuction.control.compensation import Branches
from opensuction.control.servo import ServoState
from opensuction.controller import alarm_source, head_command, record
from opensuction.controller.record import CoreState, Inputs, Outputs, Settings, State
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Commands, Readings, Requests, Setpoints
from opensuction.kernel.record import make_zero
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.procedure.cycle import button, cycle, interlocks, lock_out, progress
from opensuction.procedure.cycle.demand import Demand
from opensuction.procedure.cycle.interlocks import Interlocks, Service
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.plan import Plan
from opensuction.procedure.cycle.progress import ProcedureState
from opensuction.safety.alarm import alarm, alarm_state
from opensuction.safety.alarm.alarm_state import SILENT, Signals
from opensuction.safety.condition import Condition
from opensuction.safety.governor import governor
from opensuction.safety.governor.governor import Verdict
from opensuction.safety.handling import Reaction
from opensuction.safety.watch.watch_state import Watch


def start(settings: Settings, head_mm: float, catheter_age_s: float) -> State:
    """State at power-up with the head read at ``head_mm``.

    catheter_age_s: since the catheter's first use; not known (nan) is over its life.
    With the head in front of its park position the catheter may be in the airway: it is drawn out
    at once, without being asked, and then the machine halts until a person resets it. With the
    head behind it, or not known (nan), the machine halts: nothing goes in unasked.
    The patient then rests as after a pass. Passes and resets of before are not known here: see
    `restart`.
    Raises InputError for settings with a number that is none (`settings_check.check`).
    """
    record.check(settings)
    motion = settings.plan.motion
    parked = abs(head_mm - motion.park_head_mm) <= motion.settle_mm + progress.HOME_MM
    away = Phase.ABORTING if head_mm > motion.park_head_mm else Phase.HALTED
    procedure = cycle.begin(settings.plan, Phase.PARKED if parked else away)
    head = compensation.park(settings.compensation, settings.parked)
    watch = governor.start(settings.limits, head_mm)
    kept = interlocks.start(catheter_age_s)
    if not parked:
        head = head._replace(head_mm=watch.last.head_mm)
        kept = interlocks.rest_first(kept, settings.service.passes)
    core = make_zero(
        CoreState,
        procedure=procedure,
        upkeep=kept,
        governor=watch,
        reasons=alarm_source.NONE if parked else alarm_source.RECOVERY,
    )
    return State(core=core, compensation=head, alarms=alarm_state.START)


def restart(
    settings: Settings, head_mm: float, kept: Interlocks, off_s: float, phase: int = Phase.PARKED
) -> State:
    """As `start`, with the upkeep of the controller before: power cycling does not reset limits.

    kept: its upkeep, from whoever kept it. off_s: how long no controller ran.
    phase: in which the one before ended. Where it was not at rest the drives may have brought the
    head home since: the machine halts, says so, and waits for a person.
    """
    state = start(settings, head_mm, kept.catheter_age_s + off_s)
    core = state.core
    if phase not in RESTING and core.procedure.phase == Phase.PARKED:
        halted = cycle.begin(settings.plan, Phase.HALTED)
        core = core._replace(procedure=halted, reasons=alarm_source.STOPPED)
        state = state._replace(core=core)
    return with_upkeep(state, interlocks.carry_over(state.core.upkeep, kept, off_s))


def with_upkeep(state: State, kept: Interlocks) -> State:
    """The same controller with another upkeep: an older catheter, clocks that went on."""
    return state._replace(core=state.core._replace(upkeep=kept))


@compiled
def _pulls_only(verdict: Verdict) -> bool:
    """True where the insertion motor may pull and never push.

    Drawn out by sensors that do not tell where the head is, or tell it late: a servo on those
    swings, and drives the head in half of the time. Without volts the motor brakes.
    """
    doubtful = verdict.trips >> Condition.HEAD_SENSORS_DISAGREE & 1 == 1
    return doubtful and verdict.reaction == Reaction.WITHDRAW


@compiled
def _actuate(
    settings: Settings,
    state: CoreState,
    allowed: Setpoints,
    verdict: Verdict,
    seen: Watch,
    dt_s: float,
) -> tuple[ServoState, ServoState, Commands]:
    """Servos of both axes on the setpoints that were let through.

    verdict: which may have torque, and whether the insertion drive is told the opposite.
    """
    cam, cam_speed = servo.step_valve(
        settings.valve_motion, state.cam_rad, allowed.valve_open, dt_s
    )
    insertion, insertion_v = servo.step(
        settings.insertion_servo,
        state.insertion_servo,
        allowed.head_mm,
        allowed.head_mm_per_s,
        seen.head_mm,
        dt_s,
    )
    if _pulls_only(verdict):
        insertion_v = min(insertion_v, 0.0)
    if verdict.turned:
        insertion_v = -insertion_v
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
def _is_attended(before: int, requests: Requests) -> bool:
    """True where a person resets the machine or returns it to service in this tick."""
    cleared = (before == Phase.HALTED and requests.reset) or (
        before == Phase.OUT_OF_SERVICE and requests.return_to_service
    )
    return cleared and not requests.abort


@compiled
def _begin_again(settings: Settings, state: CoreState) -> tuple[CoreState, HeadState]:
    """A person has dealt with what halted the machine: the head begins again from where it is."""
    released = governor.reset(settings.limits, state.governor)
    head = compensation.after_retract(
        settings.compensation, settings.parked, released.last.head_mm, 0.0
    )
    return state._replace(governor=released, tripped=False, powerless=False), head


@compiled
def _proposal(head: HeadState, demand: Demand) -> Setpoints:
    """Setpoints that procedure and control propose together."""
    return Setpoints(
        head_mm=head.head_mm,
        head_mm_per_s=head.head_mm_per_s,
        insertion_on=demand.insertion_on,
        valve_open=demand.valve_open,
        pump_on=demand.pump_on,
        vacuum_mmhg=demand.vacuum_mmhg,
    )


@compiled
def _outputs(
    service: Service,
    procedure: ProcedureState,
    kept: Interlocks,
    commands: Commands,
    demand: Demand,
    verdict: Verdict,
    late_share: float,
) -> Outputs:
    """Outputs of the controller, its alarms silent; procedure and upkeep as the tick ended.

    late_share: of its ticks, averaged.
    """
    return Outputs(
        commands=commands,
        demand=demand,
        verdict=verdict,
        signals=SILENT,
        phase=procedure.phase,
        cause=procedure.cause,
        check_item=procedure.check.item,
        check_failed=procedure.check.failed,
        assessment_due=interlocks.is_prompting(service, kept, procedure.phase),
        counters=interlocks.count(kept, late_share),
    )


@compiled
def _wrong(
    plan: Plan,
    service: Service,
    state: CoreState,
    procedure: ProcedureState,
    kept: Interlocks,
    inputs: Inputs,
    trips: int,
) -> tuple[int, int]:
    """Reasons why the machine halts, and all conditions that hold: masks of alarm conditions.

    state: as the tick began. procedure, kept: as it ended.
    """
    held = alarm_source.reasons(
        plan, state.procedure.phase, procedure, state.reasons, inputs.readings
    )
    refused = interlocks.refusal(
        service, kept, procedure.phase, plan.travel_known, state.governor.patient.conditions
    )
    return held, alarm_source.conditions(
        service, kept, procedure.phase, refused, held, trips, inputs.host.conditions
    )


@compiled
def _decide(
    settings: Settings,
    heads_mm: Branches | None,
    state: CoreState,
    head: HeadState,
    readings: Readings,
    requests: Requests,
    dt_s: float,
) -> tuple[ProcedureState, Demand, HeadState]:
    """Procedure and control: the cycle one tick on, what it asks for, and the head's command.

    readings: with the head where it is taken to be. requests: what is asked for in this tick; a
    start is one that was granted, a person's or the clock's.
    """
    touched = state.procedure.phase == Phase.INSERTING and progress.is_contact(readings)
    here, feedback = head_command.feedback(
        settings, heads_mm, state, head, readings, touched, requests.confirm
    )
    procedure, demand = cycle.step(
        settings.plan, state.procedure, readings, requests, feedback, dt_s
    )
    origin = here if touched and procedure.phase == Phase.BACKING_OFF else head
    let_through_mm = state.governor.last.head_mm
    head = head_command.step(
        settings, heads_mm, head, origin, let_through_mm, demand, procedure.phase, dt_s
    )
    return procedure, demand, head


@compiled
def _press(
    settings: Settings, state: CoreState, inputs: Inputs
) -> tuple[Requests, Interlocks, bool]:
    """Requests of the buttons, interlocks with their answers, and true where a halt is to be reset.

    A button acts once. A reset that the lock-out refuses is taken out.
    """
    requests = button.press_once(inputs.requests, state.held)
    phase = state.procedure.phase
    kept = interlocks.hear(settings.service, state.upkeep, phase, requests)
    asked = phase == Phase.HALTED and requests.reset and not requests.abort
    home = progress.is_home(settings.plan.motion, inputs.readings)
    if not lock_out.lets_reset(kept.lock, home):
        requests = requests._replace(reset=False)
    return requests, kept, asked


@compiled
def alarm_step(
    settings: Settings,
    alarms: alarm_state.AlarmState,
    wrong: int,
    phase: int,
    requests: Requests,
    dt_s: float,
) -> tuple[alarm_state.AlarmState, Signals]:
    """The last part of a tick: what people are told of what is wrong.

    wrong: mask of alarm conditions. phase: as the tick ended.
    """
    buttons = alarm_state.Buttons(
        acknowledge=requests.acknowledge,
        audio_pause=requests.audio_pause,
        # Who puts the machine back to work has dealt with the alarms.
        reset=(requests.reset or requests.return_to_service) and not requests.abort,
    )
    planned_work = phase == Phase.OUT_OF_SERVICE
    return alarm.step(settings.alarms, alarms, wrong, planned_work, buttons, dt_s)


@compiled
def control_step(
    settings: Settings, heads_mm: Branches | None, state: CoreState, head: HeadState, inputs: Inputs
) -> tuple[CoreState, HeadState, Outputs, int]:
    """A tick without its alarms: all that moves anything.

    head: the compensation's state. Returns what is remembered, the head's command, what leaves
    (its signals silent), and the mask of alarm conditions that `alarm_step` must hear of.
    """
    readings, dt_s = inputs.readings, inputs.dt_s
    plan, service, before = settings.plan, settings.service, state.procedure.phase
    requests, heard, resets = _press(settings, state, inputs)
    if _is_attended(before, requests):
        state, head = _begin_again(settings, state)
    patient = state.governor.patient.conditions
    asked = interlocks.is_asked(service, heard, before, requests)
    refused = interlocks.refusal(service, heard, before, plan.travel_known, patient)
    start = asked and refused == Refusal.NONE
    vote = governor.locate(settings.limits, state.governor, readings, state.driven_v, dt_s)
    located = readings._replace(
        head_mm=vote.head_mm,
        head_valid=vote.unseen_ticks == 0,
        line_vacuum_mmhg=governor.line_vacuum_mmhg(state.governor, readings, dt_s),
    )
    procedure, demand, head = _decide(
        settings, heads_mm, state, head, located, requests._replace(start=start), dt_s
    )
    watch, allowed, verdict = governor.step(
        settings.limits,
        state.governor,
        _proposal(head, demand),
        readings,
        vote,
        inputs.host.overrun,
        dt_s,
    )
    # Out of service hands are in the machine: nothing moves, not even to withdraw.
    in_service = procedure.phase != Phase.OUT_OF_SERVICE
    powered = verdict.insertion_on and in_service
    valve_on = verdict.valve_on and demand.valve_on and in_service
    driving = verdict._replace(insertion_on=powered, valve_on=valve_on)
    insertion, valve_state, commands = _actuate(
        settings, state, allowed, driving, watch.watch, dt_s
    )
    kept = interlocks.step(service, heard, before, procedure.phase, asked, refused, requests, dt_s)
    granted = resets and requests.reset
    said = verdict.trips if granted else verdict.trips | state.reasons
    kept = interlocks.watch_resets(kept, before, procedure.phase, resets, granted, said)
    inputs, trips = inputs._replace(readings=located), verdict.trips | verdict.patient
    reasons, wrong = _wrong(plan, service, state, procedure, kept, inputs, trips)
    following = CoreState(
        procedure=procedure,
        upkeep=kept,
        insertion_servo=insertion,
        valve_servo=valve_state,
        cam_rad=commands.cam_rad,
        driven_v=-commands.insertion_v if verdict.turned else commands.insertion_v,
        governor=watch,
        tripped=verdict.trips != 0,
        powerless=verdict.reaction == Reaction.TORQUE_OFF,
        reasons=reasons,
        held=button.hold(inputs.requests),
    )
    outputs = _outputs(service, procedure, kept, commands, demand, verdict, watch.watch.late_share)
    return following, head, outputs, wrong


@compiled
def step(
    settings: Settings, heads_mm: Branches | None, state: State, inputs: Inputs
) -> tuple[State, Outputs]:
    """One tick of the controller; no clock, no I/O, nothing hidden.

    heads_mm: branches of the compensation's curves, apart from its settings: see `Branches`.
    """
    core, head, outputs, wrong = control_step(
        settings, heads_mm, state.core, state.compensation, inputs
    )
    alarms, signals = alarm_step(
        settings, state.alarms, wrong, outputs.phase, inputs.requests, inputs.dt_s
    )
    return State(core, head, alarms), outputs._replace(signals=signals)
