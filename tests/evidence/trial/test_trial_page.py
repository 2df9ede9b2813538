"""The page of a trial says what its figures say, and what was asked of whom."""

import pytest

from opensuction.evidence.trial import trial as trial_module
from opensuction.evidence.trial import trial_page, trial_summary
from opensuction.evidence.trial.judged_cycle import Case
from opensuction.evidence.trial.trial import PlayedPart
from opensuction.evidence.trial.trial_summary import Effort
from opensuction.result.trial_result import Trial, TrialResult
from opensuction.twin.fault.fault import Fault
from tests.evidence.trial.example import BREACH, HARM, STAYS, case

EFFORT = Effort(workers=2, wall_s=60.0, cycles=120, date_utc="2026-11-23")
SINGLE = Trial()


def summary(*cases: Case, trial: Trial = SINGLE, asked: int | None = None) -> TrialResult:
    heading = trial_module.make_heading(trial, len(cases) if asked is None else asked)
    part = PlayedPart(0, cases, ("neonate, travel, seed 7: it cannot",))
    return trial_summary.summarise(heading, [part], EFFORT)


def page(*cases: Case, trial: Trial = SINGLE, asked: int | None = None) -> str:
    return trial_page.markdown(summary(*cases, trial=trial, asked=asked))


def test_it_says_what_was_asked_and_who_judged() -> None:
    text = page(case(1, Fault.PUMP_LOST), trial=Trial(seed=7, cohort="neonate"))
    assert text.startswith("# Trial: 1 cycles with a fault each\n\nDate: 2026-11-23. In-silico")
    assert "`opensuction trial --cycles 1 --faults single --cohort neonate --seed 7`" in text
    assert "with a drawn patient (`neonate`), by travel and contact" in text
    assert "`oracle/`, from the twin's truth alone" in text
    assert "\n**Scope.** 1 cycles on 1 drawn machines" in text
    assert "\n**Judgement.** What happened to the patient" in text
    assert "## Not asked" in text
    assert "Drawn machines refused before they began: 1, for example:" in text
    assert "2 cycles a second by 2 processes" in text


def test_counts_stand_with_their_bounds() -> None:
    sound = [case(number, Fault.PUMP_LOST) for number in range(1, 101)]
    text = page(*sound)
    assert "| bounds of the patient, one fault | 100 | 0 | 3 % |" in text
    assert "two faults |" not in text  # nobody asked
    assert "## Violations\n\nNone.\n" in text


def test_each_kind_of_violation_is_named_with_numbers_that_play_it() -> None:
    worse = HARM._replace(worst=0.6)
    cases = [case(number, Fault.PUMP_LOST)._replace(breaches=(HARM,)) for number in (3, 9)]
    cases[1] = cases[1]._replace(breaches=(worse,), commands=(BREACH,))
    text = page(*cases)
    assert "| pump-lost | force | 2 | 0.6 | 0.3 | 3, 9 |" in text
    assert "| pump-lost | a bound (command) | 1 | 2.5 | 0.5 | 9 |" in text
    assert "`opensuction trial --play NUMBER --faults single`" in text


def test_who_stays_inside_stands_there_with_the_reason() -> None:
    left = case(1, Fault.MOTOR_STALLED)._replace(left_inside=STAYS)
    needless = case(2, Fault.PUMP_LOST)._replace(
        left_inside=STAYS._replace(unavoidable="", in_time=False)
    )
    text = page(left, needless)
    assert "2 cycles ended with the tip in the airway; 1 of them nothing" in text
    assert "| 1 | `motor-stalled` 1 | it is held fast | Draw it out. |" in text
    assert "**something could have brought it out**" in text


def test_what_is_said_of_sound_cycles_stands_there_the_false_first() -> None:
    true = case(1)._replace(true_alarms=("SPO2_LOW",))
    false = case(2)._replace(false_alarms=("LINE_CLOGGED",), completed=False)
    text = page(true, false, case(3), trial=Trial(faults="none"))
    assert "## Alarms in cycles without a fault\n\nOf 3 cycles without a fault 1 tripped" in text
    first = text.index("| 2 | adult-icu, travel | LINE_CLOGGED | - | no |")
    assert first < text.index("| 1 | adult-icu, travel | - | SPO2_LOW | yes |")
    assert "| nothing said that is not so, no fault | 3 | 1 | 86 % |" in text
    assert "## Bounds that faults state" not in text


def test_what_was_said_before_a_fault_is_told_apart() -> None:
    early = case(1, Fault.PUMP_LOST)._replace(false_alarms=("LINE_CLOGGED",))
    found = summary(early)
    assert (found.false_before_fault, found.false_alarms) == (1, 0)
    assert "In 1 cycles something that was not so" in page(early)
    assert not early.is_broken
    assert early._replace(faults=()).is_broken


def test_what_came_too_late_is_listed_apart() -> None:
    pair = case(1, Fault.PUMP_LOST, Fault.LINE_LEAK)
    late = pair._replace(faults=(pair.faults[0], pair.faults[1]._replace(counts=False)))
    text = page(late, trial=Trial(faults="double"))
    assert "could do nothing any more: 1. Their cycles count with one." in text
    assert "`line-leak` 1" in text
    assert "| bounds of the patient, one fault | 1 | 0 |" in text


def test_endpoints_stand_by_patient() -> None:
    other = case(2)._replace(patient="neonate")
    text = page(case(1), other, trial=Trial(faults="none"))
    assert "|  | `adult-icu` | `neonate` |" in text
    assert "| suction time, s | 12.0 (12.0 to 12.0) | 12.0 (12.0 to 12.0) |" in text


def test_what_nothing_told_is_listed_and_nothing_else() -> None:
    told = case(2, Fault.GEAR_WORN)._replace(told=True)
    text = page(case(1, Fault.PUMP_LOST), told)
    assert "## Faults without an alarm\n" in text
    assert "| `pump-lost` | 1 | 1 |" in text
    assert "| `gear-worn` | 1" not in text


def test_a_trial_that_is_not_complete_says_so_and_is_not_good() -> None:
    found = summary(case(1, Fault.PUMP_LOST), asked=2)
    assert "**Not complete:** 1 of 2 cycles." in trial_page.markdown(found)
    assert not trial_summary.is_good(found)
    assert trial_summary.is_good(summary(case(1, Fault.PUMP_LOST)))


@pytest.mark.parametrize(
    ("broken", "good"),
    [
        (case(1, Fault.PUMP_LOST)._replace(breaches=(HARM,)), False),
        (case(1, Fault.PUMP_LOST, Fault.LINE_LEAK)._replace(breaches=(HARM,)), True),
        (case(1, Fault.PUMP_LOST, Fault.LINE_LEAK)._replace(commands=(BREACH,)), False),
        (case(1)._replace(false_alarms=("LINE_CLOGGED",)), False),
        (case(1)._replace(true_alarms=("SPO2_LOW",)), True),
        (case(1)._replace(breaches=(HARM,)), False),
    ],
)
def test_what_is_claimed_is_what_fails(broken: Case, good: bool) -> None:
    assert trial_summary.is_good(summary(broken)) == good


def test_the_command_that_plays_a_cycle_names_what_is_not_usual() -> None:
    chosen = Trial(faults="none", seed=3, compensation="my models/b.toml", preoxygenation="skipped")
    assert trial_summary.play_command(chosen, 17) == (
        "opensuction trial --play 17 --faults none --seed 3 --compensation 'my models/b.toml' "
        "--preoxygenation skipped"
    )
