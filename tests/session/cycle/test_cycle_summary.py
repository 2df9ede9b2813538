"""Words and names in the summary of a cycle."""

from opensuction.procedure.cycle.transition import BROKEN_OFF
from opensuction.safety.alarm.alarm_log import Episode
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import WORD
from opensuction.safety.handling import Priority
from opensuction.session.cycle import cycle_summary


def test_every_event_that_breaks_a_cycle_off_has_its_sentence() -> None:
    assert set(cycle_summary.ABORT_SENTENCES) == {event for _, event in BROKEN_OFF}


def test_every_alarm_has_what_a_person_needs() -> None:
    unnamed = WORD  # every bit of a mask is a condition's: one that a newer version has
    found = [
        Episode(int(Condition.HEAD_STALLED), Priority.HIGH, 3.0, None, False, None),
        Episode(unnamed, Priority.HIGH, 4.0, 5.0, True, 4.5),
    ]
    stalled, unknown = cycle_summary.alarms(found)
    assert stalled.condition == "head-stalled"
    assert stalled.priority == "high"
    assert stalled.sentence
    assert stalled.remedy
    assert (stalled.started_s, stalled.ended_s) == (3.0, None)
    assert unknown.condition == f"unknown-{unnamed}"
    assert (unknown.latched, unknown.acknowledged_s) == (True, 4.5)
