"""Two things wrong at once, for as long: neither may hide the other."""

from itertools import combinations

import pytest

from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.safety.governor import judgement
from opensuction.safety.invalid_ticks import INVALID_TICKS
from tests.safety.observer import seen
from tests.safety.watchdog import LIMITS, PARK_MM, staying

CAUSES = {
    Condition.HEAD_READING_INVALID: ("invalid.head", INVALID_TICKS),
    Condition.CARRIAGE_READING_INVALID: ("invalid.carriage", INVALID_TICKS),
    Condition.CAM_READING_INVALID: ("invalid.cam", INVALID_TICKS),
    Condition.VACUUM_READING_INVALID: ("invalid.vacuum", INVALID_TICKS),
    Condition.CONTACT_READING_INVALID: ("invalid.contact", INVALID_TICKS),
    Condition.HEAD_SENSORS_DISAGREE: ("durations.disagreeing_s", 1.0),
    Condition.HEAD_NOT_FOLLOWING: ("durations.off_command_s", 1.0),
    Condition.HEAD_STALLED: ("durations.stalled_s", 1.0),
    Condition.CATHETER_JAMMED: ("durations.jammed_s", 1.0),
    Condition.DRIVE_OVERFORCE: ("durations.overforce_s", 1.0),
    Condition.VACUUM_EXCEEDED: ("durations.overpressure_s", 1.0),
}
"""What alone is each trip, and a value beyond its limit."""


def found(*conditions: Condition) -> set[Condition]:
    known = seen(PARK_MM, **dict(CAUSES[one] for one in conditions))
    return set(decode_trips(judgement.judge(LIMITS, known, staying(PARK_MM), False)))


@pytest.mark.parametrize("condition", CAUSES)
def test_each_is_found_alone(condition: Condition) -> None:
    assert found(condition) == {condition}


@pytest.mark.parametrize(("first", "second"), list(combinations(CAUSES, 2)))
def test_neither_hides_the_other(first: Condition, second: Condition) -> None:
    assert found(first, second) == {first, second}


def test_nothing_is_found_where_nothing_is_wrong() -> None:
    assert found() == set()
