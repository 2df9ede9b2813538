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
    "invalid.head": (Condition.HEAD_READING_INVALID, INVALID_TICKS),
    "invalid.carriage": (Condition.CARRIAGE_READING_INVALID, INVALID_TICKS),
    "invalid.cam": (Condition.CAM_READING_INVALID, INVALID_TICKS),
    "invalid.vacuum": (Condition.VACUUM_READING_INVALID, INVALID_TICKS),
    "invalid.contact": (Condition.CONTACT_READING_INVALID, INVALID_TICKS),
    "durations.disagreeing_s": (Condition.HEAD_SENSORS_DISAGREE, 1.0),
    "durations.adrift_s": (Condition.HEAD_SENSORS_DISAGREE, 1.5),
    "durations.remaining_s": (Condition.HEAD_SENSORS_DISAGREE, 1.5),
    "durations.absent_s": (Condition.TIP_DETACHED, 1.0),
    "durations.off_command_s": (Condition.HEAD_NOT_FOLLOWING, 1.0),
    "durations.stalled_s": (Condition.HEAD_STALLED, 1.0),
    "durations.jammed_s": (Condition.CATHETER_JAMMED, 1.0),
    "durations.overforce_s": (Condition.DRIVE_OVERFORCE, 1.0),
    "durations.overpressure_s": (Condition.VACUUM_EXCEEDED, 1.0),
}
"""What alone is each trip, and a value beyond its limit."""


def found(*causes: str) -> set[Condition]:
    known = seen(PARK_MM, **{cause: CAUSES[cause][1] for cause in causes})
    return set(decode_trips(judgement.judge(LIMITS, known, staying(PARK_MM), False)))


@pytest.mark.parametrize("cause", CAUSES)
def test_each_is_found_alone(cause: str) -> None:
    assert found(cause) == {CAUSES[cause][0]}


@pytest.mark.parametrize(("first", "second"), list(combinations(CAUSES, 2)))
def test_neither_hides_the_other(first: str, second: str) -> None:
    assert found(first, second) == {CAUSES[first][0], CAUSES[second][0]}


def test_nothing_is_found_where_nothing_is_wrong() -> None:
    assert found() == set()
