"""Faults as a person writes them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.session.choice import CycleChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

CHOICE = CycleChoice(protocol="adult", compensation="exact-inverse")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("valve-jammed", Injection(Fault.VALVE_JAMMED, AT_START, 0.0)),
        ("line-leak=0.5", Injection(Fault.LINE_LEAK, AT_START, 0.5)),
        ("line-leak", Injection(Fault.LINE_LEAK, AT_START, 2.0)),
        ("pump-lost@12.5", Injection(Fault.PUMP_LOST, FaultInstant(None, 12.5), 0.0)),
        (
            "tick-late@suctioning+2=0.3",
            Injection(Fault.TICK_LATE, FaultInstant(Phase.SUCTIONING, 2.0), 0.3),
        ),
        (
            "valve-slow@backing-off",
            Injection(Fault.VALVE_SLOW, FaultInstant(Phase.BACKING_OFF, 0.0), 0.8),
        ),
    ],
)
def test_a_fault_is_read_as_it_is_written(text: str, expected: Injection) -> None:
    assert resolution.parse(text) == expected


@given(
    st.sampled_from([fault for fault, row in ROWS.items() if row.strength is not None]),
    st.sampled_from([None, *resolution.PHASES.values()]),
    st.floats(0.0, 179.0),
    st.floats(allow_nan=False, allow_infinity=False),
)
def test_what_is_written_out_is_read_back(
    fault: Fault, phase: Phase | None, after_s: float, strength: float
) -> None:
    name = "" if phase is None else f"{phase.name.lower()}+"
    text = f"{fault.title}@{name}{after_s!r}={strength!r}"
    assert resolution.parse(text) == Injection(fault, FaultInstant(phase, after_s), strength)


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        (["valve-stuk"], "unknown fault 'valve-stuk': did you mean 'valve-stuck-open'"),
        ([""], "unknown fault ''; all 103 are in"),
        (["line-leak=900"], "strength 900 mL/s/mmHg (leak in addition): 0.02 to 50 mL/s/mmHg"),
        (["line-leak=much"], "the strength 'much' is not a number"),
        (["line-leak=nan"], "the strength 'nan' is not a number"),
        (["valve-jammed=1"], "'valve-jammed' has no strength: leave '=1' out"),
        (["pump-lost@-1"], "at -1 s: an instant is from 0 s to less than 180 s"),
        (["pump-lost@suctioning+180"], "at 180 s: an instant is from 0 s to less than 180 s"),
        (["pump-lost@soon"], "unknown phase of a fault 'soon'"),
        (["pump-lost@closing+x"], "the time into the phase 'x' is not a number"),
        (["pump-lost@suctioning-2"], "unknown phase of a fault 'suctioning-2'"),
        (["pump-lost@"], "the instant '' is not a number; give NAME[@S][=STRENGTH], S in seconds"),
        (["pump-lost@teaching+1"], "unknown phase of a fault 'teaching'"),
        (["pump-lost@backing_off"], "approach 'travel' has no phase backing_off"),
        (["pump-lost@1@2"], "should be NAME[@S][=STRENGTH]"),
        (["wrong-preset@2"], "one of the set-up: it can only be there from the start"),
        (["pump-lost", "pump-weak", "line-leak"], "3 faults at once: at most 2"),
    ],
)
def test_what_cannot_be_meant_is_refused_in_one_line(texts: list[str], said: str) -> None:
    with pytest.raises(InputError) as refused:
        resolution.resolve_faults(texts, "travel")
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("wrong-preset", "this protocol is for adult, the patient is neonate"),
        ("catheter-too-wide", "it should be below 0.5"),
    ],
)
def test_a_wrong_set_up_is_refused_before_anything_moves(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        cycle_run.prepare(resolution.resolve(CHOICE._replace(faults=(text,))))


def test_other_faults_leave_the_set_up_alone() -> None:
    choice = CHOICE._replace(faults=("line-leak", "encoder-frozen@5"))
    found = resolution.resolve(choice)
    assert found.choice == choice
    assert found.equipment == resolution.resolve(CHOICE).equipment
