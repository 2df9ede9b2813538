"""Cause of a cycle's end, in words for people."""

import pytest

from opensuction.console.live import hub
from opensuction.kernel.vocabulary import CYCLE, name_of
from opensuction.procedure.cycle import transition
from opensuction.safety.condition import Condition


def test_everything_that_breaks_a_cycle_off_has_words() -> None:
    """By the table of transitions itself."""
    breaking = {event for phase, event in transition.BROKEN_OFF if phase in CYCLE}
    assert breaking == set(hub.CAUSES)


@pytest.mark.parametrize("condition", Condition)
def test_a_limit_is_said_in_its_own_words(condition: Condition) -> None:
    assert hub.say(f"tripped, {name_of(condition)}") == condition.row.sentence
    both = hub.say(f"abort-requested, {name_of(condition)}")
    assert both == f"a person asked for it; {condition.row.sentence}"


@pytest.mark.parametrize("detail", ["", "nobody recorded how it ended", "tripped, something-new"])
def test_what_is_no_name_stands_for_itself(detail: str) -> None:
    assert hub.say(detail) == detail
