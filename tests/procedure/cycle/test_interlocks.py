"""The catheter's life, and who may start when."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import ABORT, CHANGED, NO_REQUESTS, START, Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import interlocks, schedule
from opensuction.procedure.cycle.interlocks import LIFE_S, Interlocks, Service
from opensuction.procedure.cycle.lock_out import SENTENCES, Refusal
from opensuction.procedure.cycle.schedule import ScheduleMode, ScheduleState
from opensuction.procedure.planning import guideline
from opensuction.safety.condition import Condition

CYCLE_S = 100.0
TIMED = schedule.schedule(ScheduleMode.TIMED, 3600.0)
SERVICE = Service(
    life_s=LIFE_S, cycle_s=CYCLE_S, schedule=schedule.ON_REQUEST_ONLY, passes=guideline.BENCH
)
CLOCKED = SERVICE._replace(schedule=TIMED)
FRESH = interlocks.start(0.0)
DUE = FRESH._replace(schedule=ScheduleState(4000.0, 4000.0))


def refused(
    state: Interlocks, phase: Phase = Phase.PARKED, known: bool = True, patient: int = 0
) -> Refusal:
    return Refusal(interlocks.refusal(SERVICE, state, int(phase), known, patient))


@pytest.mark.requirement("OS-R22")
@given(st.floats(0.0, 2.0 * LIFE_S))
def test_no_cycle_outlives_the_catheter(age_s: float) -> None:
    code = refused(FRESH._replace(catheter_age_s=age_s))
    if age_s >= LIFE_S:
        assert code == Refusal.CATHETER_LIFE_OVER
    elif age_s + CYCLE_S > LIFE_S:
        assert code == Refusal.CATHETER_LIFE_ENDS
    else:
        assert code == Refusal.NONE


def test_an_age_that_is_not_known_is_over() -> None:
    assert refused(interlocks.start(float("nan"))) == Refusal.CATHETER_LIFE_OVER
    assert refused(interlocks.start(-1.0)) == Refusal.CATHETER_LIFE_OVER


def test_a_machine_that_waits_for_a_person_says_why_it_does_not_start() -> None:
    assert refused(FRESH, Phase.OUT_OF_SERVICE) == Refusal.OUT_OF_SERVICE
    assert refused(FRESH, Phase.HALTED) == Refusal.HALTED
    assert refused(FRESH, known=False) == Refusal.NOT_TAUGHT
    assert set(SENTENCES) == set(Refusal)


PATIENT = [c for c in Condition if Condition.SPO2_LOW <= c <= Condition.MONITOR_LINK_LOST]


@given(st.sets(st.sampled_from(PATIENT)))
def test_no_cycle_begins_while_the_patient_is_out_of_limits_or_unseen(
    wrong: set[Condition],
) -> None:
    code = refused(FRESH, patient=sum(1 << each for each in wrong))
    if Condition.MONITOR_LINK_LOST in wrong:
        assert code == Refusal.MONITOR_LINK_LOST
    else:
        assert code == (Refusal.PATIENT_UNSAFE if wrong else Refusal.NONE)


@given(st.sampled_from(Phase), st.booleans())
def test_the_clock_asks_only_a_parked_machine(phase: Phase, due: bool) -> None:
    asked = interlocks.is_asked(CLOCKED, DUE if due else FRESH, int(phase), NO_REQUESTS)
    assert asked == (due and phase == Phase.PARKED)
    assert not interlocks.is_asked(CLOCKED, DUE, int(phase), ABORT)


@given(st.sampled_from(Phase))
def test_a_start_in_the_middle_of_something_is_not_even_refused(phase: Phase) -> None:
    waiting = phase in {Phase.PARKED, Phase.HALTED, Phase.OUT_OF_SERVICE}
    assert interlocks.is_asked(SERVICE, FRESH, int(phase), START) == waiting


@given(
    st.lists(
        st.tuples(st.sampled_from(Phase), st.sampled_from([NO_REQUESTS, START, CHANGED])),
        max_size=50,
    )
)
def test_only_a_change_out_of_service_makes_the_catheter_new(
    history: list[tuple[Phase, Requests]],
) -> None:
    state, before, age_s = interlocks.start(1000.0), Phase.PARKED, 1000.0
    for phase, requests in history:
        state = interlocks.step(SERVICE, state, int(before), int(phase), False, 0, requests, 1.0)
        new = before == Phase.OUT_OF_SERVICE and requests.changed
        age_s = 0.0 if new else age_s + 1.0
        assert state.catheter_age_s == age_s
        before = phase


def test_a_machine_put_back_to_work_waits_a_whole_interval() -> None:
    for before in (Phase.HALTED, Phase.OUT_OF_SERVICE):
        after = interlocks.step(
            SERVICE, DUE, int(before), int(Phase.PARKED), False, 0, NO_REQUESTS, 0.001
        )
        assert after.schedule == schedule.restart()
    waiting = interlocks.step(
        SERVICE, DUE, int(Phase.HALTED), int(Phase.HALTED), False, 0, NO_REQUESTS, 0.001
    )
    assert waiting.schedule.since_cycle_s > 3600.0


def test_the_last_refusal_stays_until_a_start_is_accepted() -> None:
    parked, checking = int(Phase.PARKED), int(Phase.CHECKING)
    over = int(Refusal.CATHETER_LIFE_OVER)
    said = interlocks.step(SERVICE, FRESH, parked, parked, True, over, START, 0.001)
    assert said.refusal == over
    later = interlocks.step(SERVICE, said, parked, parked, False, 0, NO_REQUESTS, 0.001)
    assert later.refusal == over
    accepted = interlocks.step(SERVICE, later, parked, checking, True, 0, START, 0.001)
    assert accepted.refusal == Refusal.NONE
