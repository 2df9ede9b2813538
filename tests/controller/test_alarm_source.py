"""Alarms that the controller raises itself, phase by phase and event by event."""

from functools import cache

import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller import alarm_source
from opensuction.controller.calibration import PLAIN_PD, assume_nominal
from opensuction.controller.record import Settings
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.interface import NO_MONITOR, Readings
from opensuction.kernel.vocabulary import AgeGroup, Phase
from opensuction.procedure.cycle import check, cycle, interlocks, schedule
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.schedule import Schedule, ScheduleMode, ScheduleState
from opensuction.procedure.cycle.transition import TRANSITIONS, Event
from opensuction.procedure.planning.planner import WAY_IN_MMHG
from opensuction.procedure.planning.protocol import PAPER
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode
from opensuction.simulation import rig as rigs

C = Condition
STOPPED = {C.AUTOMATION_STOPPED}


@cache
def settings() -> Settings:
    """The nominal bench's controller, uncalibrated."""
    rig = rigs.rig("bench", 1, nominal=True)
    known = assume_nominal(PUBLISHED, PLAIN_PD)
    return rigs.assemble(rig, PAPER, CompensationKind.NONE, known, run=2)[0].controller


def readings(contact: bool = False, vacuum_mmhg: float = 0.0, cam_rad: float = 0.0) -> Readings:
    """A machine at rest, but for what is given."""
    return Readings(
        head_mm=settings().plan.motion.park_head_mm,
        head_valid=True,
        carriage_mm=settings().plan.motion.park_head_mm,
        carriage_valid=True,
        cam_rad=cam_rad,
        cam_valid=True,
        line_vacuum_mmhg=vacuum_mmhg,
        vacuum_valid=True,
        contact_closed=contact,
        contact_valid=True,
        mouth_clear=True,
        insertion_current_a=0.0,
        monitor=NO_MONITOR,
    )


def found(
    before: Phase,
    phase: Phase,
    cause: Event,
    held: int = 0,
    seen: Readings | None = None,
    item: CheckItem = CheckItem.NONE,
    at_patient: bool = False,
) -> set[Condition]:
    """Reasons after a change of phase."""
    plan = settings().plan
    if at_patient:
        plan = plan._replace(bench_only=False, way_in_mmhg=WAY_IN_MMHG[AgeGroup.ADULT])
    tested = check.UNTESTED._replace(failed=int(item))
    now = cycle.begin(plan, phase)._replace(cause=int(cause), check=tested)
    seen = readings() if seen is None else seen
    return named(alarm_source.reasons(plan, int(before), now, held, seen))


def named(mask: int) -> set[Condition]:
    return {Condition(bit) for bit in decode(mask)}


def test_every_way_into_a_stop_but_a_persons_own_is_an_alarm() -> None:
    quiet = {Event.ABORT_REQUESTED, Event.CLEARED}
    for (before, event), phase in TRANSITIONS.items():
        if phase not in (Phase.ABORTING, Phase.HALTED):
            assert found(before, phase, event, held=alarm_source.STOPPED) == set()
        else:
            assert (found(before, phase, event) == set()) == (event in quiet), (before, event)


def test_reasons_last_from_the_stop_until_the_machine_is_parked() -> None:
    held = alarm_source.STOPPED | alarm_source.CARINA_MISSED
    named_held = named(held)
    assert found(Phase.ABORTING, Phase.ABORTING, Event.CONTACT_MISPLACED, held) == named_held
    assert found(Phase.ABORTING, Phase.HALTED, Event.CLEARED, held) == named_held
    assert found(Phase.HALTED, Phase.HALTED, Event.CLEARED, held) == named_held
    # A reset that must first bring the head home: dealt with, but not yet back to work.
    assert found(Phase.HALTED, Phase.ABORTING, Event.RECOVERY_REQUESTED, held) == STOPPED
    assert found(Phase.HALTED, Phase.PARKED, Event.RESET_REQUESTED, held) == set()


def test_contact_in_the_wrong_place_is_told_from_none() -> None:
    way = (Phase.INSERTING, Phase.ABORTING, Event.CONTACT_MISPLACED)
    assert found(*way, seen=readings(contact=True)) == STOPPED | {C.CONTACT_STUCK_CLOSED}
    assert found(*way) == STOPPED | {C.CARINA_MISSED}
    # A switch that drawing back does not open may chatter.
    back = (Phase.BACKING_OFF, Phase.ABORTING, Event.CONTACT_MISPLACED)
    for closed in (False, True):
        stuck = found(*back, seen=readings(contact=closed))
        assert stuck == STOPPED | {C.CONTACT_STUCK_CLOSED}


@pytest.mark.parametrize("item", CheckItem)
def test_each_item_of_the_pre_use_test_says_what_it_found(item: CheckItem) -> None:
    own = {alarm_source.FOUND[item]} if item in alarm_source.FOUND else set()
    way = (Phase.CHECKING, Phase.ABORTING, Event.CHECK_FAILED)
    assert found(*way, item=item) == STOPPED | {C.CHECK_FAILED} | own


def test_a_valve_item_that_finds_vacuum_blames_what_draws() -> None:
    way = (Phase.CHECKING, Phase.ABORTING, Event.CHECK_FAILED)
    seen = readings(vacuum_mmhg=80.0)
    assert C.PUMP_RUNAWAY in found(*way, seen=seen, item=CheckItem.VALVE_OPENS)
    assert C.VALVE_STUCK_CLOSED not in found(*way, seen=seen, item=CheckItem.VALVE_OPENS)


def test_a_phase_that_takes_too_long_says_what_did_not_move() -> None:
    late = Event.PHASE_OVERDUE
    plan = settings().plan
    opening = (Phase.OPENING, Phase.ABORTING, late)
    built = readings(vacuum_mmhg=plan.check.ready_mmhg)
    half = readings(vacuum_mmhg=0.5 * plan.vacuum_mmhg, cam_rad=0.5 * plan.cam_open_rad)
    for seen in (built, half):
        assert found(*opening, seen=seen, at_patient=True) == STOPPED | {C.VALVE_STUCK_CLOSED}
    # Behind the closed valve it was the vacuum that did not come; a bench waits for none.
    assert found(*opening, at_patient=True) == STOPPED | {C.VACUUM_LOST}
    assert found(*opening) == STOPPED | {C.VALVE_STUCK_CLOSED}
    # With the vacuum there it waited for what the tip touches to go away.
    touching = built._replace(contact_closed=True)
    assert found(*opening, seen=touching, at_patient=True) == STOPPED | {C.CONTACT_TIME}
    preloading = (Phase.PRELOADING, Phase.ABORTING, late)
    assert found(*preloading, at_patient=True) == STOPPED | {C.VACUUM_LOST}
    assert found(*preloading) == STOPPED | {C.HEAD_NOT_FOLLOWING}
    assert C.VALVE_STUCK_OPEN in found(Phase.CLOSING, Phase.ABORTING, late)
    kept = readings(vacuum_mmhg=WAY_IN_MMHG[AgeGroup.ADULT])
    for phase in (Phase.PRELOADING, Phase.INSERTING, Phase.BACKING_OFF):
        stopped = found(phase, Phase.ABORTING, late, seen=kept, at_patient=True)
        assert stopped == STOPPED | {C.HEAD_NOT_FOLLOWING}
    assert found(Phase.WITHDRAWING, Phase.ABORTING, late) == STOPPED
    aborted = (Phase.ABORTING, Phase.HALTED, late)
    assert found(*aborted, seen=readings(cam_rad=0.5)) == STOPPED | {C.VALVE_STUCK_OPEN}
    away = readings()._replace(head_mm=settings().plan.motion.park_head_mm + 30.0)
    assert found(*aborted, seen=away) == STOPPED | {C.WITHDRAWAL_TIME}
    behind = readings()._replace(head_mm=settings().plan.motion.park_head_mm - 5.0)
    assert found(*aborted, seen=behind) == STOPPED


def wrong(
    age_s: float = 0.0,
    phase: Phase = Phase.PARKED,
    refused: Refusal = Refusal.NONE,
    timed: Schedule = schedule.ON_REQUEST_ONLY,
    trips: int = 0,
    host: int = 0,
) -> set[Condition]:
    """Conditions with intervals of which an hour has passed."""
    service = settings().service._replace(schedule=timed)
    kept = interlocks.start(age_s)._replace(schedule=ScheduleState(3600.0, 3600.0))
    return named(alarm_source.conditions(service, kept, int(phase), int(refused), 0, trips, host))


def test_the_catheters_end_is_announced_and_then_an_alarm() -> None:
    life_s = settings().service.life_s
    assert wrong(life_s - alarm_source.ENDING_S - 1.0) == set()
    assert wrong(life_s - alarm_source.ENDING_S) == {C.CATHETER_LIFE_ENDING}
    assert wrong(life_s - 1.0) == {C.CATHETER_LIFE_ENDING}
    assert wrong(life_s) == wrong(float("inf")) == {C.CATHETER_LIFE_OVER}


@pytest.mark.parametrize("mode", [ScheduleMode.TIMED, ScheduleMode.PROMPT])
def test_what_is_due_and_cannot_be_served_is_an_alarm(mode: ScheduleMode) -> None:
    due, later = schedule.schedule(mode, 3600.0), schedule.schedule(mode, 3700.0)
    halted = (0.0, Phase.HALTED, Refusal.HALTED)
    assert wrong(*halted, timed=due) == STOPPED
    assert wrong(*halted, timed=later) == wrong(*halted) == set()
    assert wrong(0.0, Phase.PARKED, Refusal.NOT_TAUGHT, due) == STOPPED
    assert wrong(0.0, Phase.PARKED, Refusal.NONE, due) == set()
    # A cycle that runs is what was due.
    assert wrong(0.0, Phase.SUCTIONING, Refusal.CATHETER_LIFE_ENDS, due) == set()


def test_trips_and_what_the_host_sees_are_passed_on() -> None:
    bit = 1 << Condition.HEAD_STALLED
    assert wrong(trips=bit, phase=Phase.SUCTIONING) == {C.HEAD_STALLED}
    assert wrong(trips=bit, phase=Phase.HALTED) == {C.HEAD_STALLED, C.AUTOMATION_STOPPED}
    lost = 1 << C.MESSAGE_LATE | 1 << C.CONSOLE_LOST
    assert wrong(host=lost) == {C.MESSAGE_LATE, C.CONSOLE_LOST}
