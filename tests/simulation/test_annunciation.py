"""Source and time of each notice, read from the annunciator."""

import numpy as np

from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import encode
from opensuction.simulation import outcome
from opensuction.simulation.outcome import COLUMNS, Annunciation
from opensuction.simulation.trace import Columns

TICKS = 1000
DT_S = 0.001


def quiet() -> Columns:
    """Ten seconds after the start of a day nothing is shown."""
    return {
        "time_s": np.asarray(10.0 + np.arange(TICKS) * DT_S, dtype=np.float64),
        **{name: np.zeros(TICKS) for name in COLUMNS},
    }


def test_nothing_is_told_where_nothing_is_shown() -> None:
    assert outcome.told(quiet()) == []


def test_what_the_controller_says_is_told_when_it_begins() -> None:
    columns = quiet()
    both = encode({Condition.CATHETER_JAMMED, Condition.CARRIAGE_READING_INVALID})
    columns["annunciator.said"][100:] = encode({Condition.CATHETER_JAMMED})
    columns["annunciator.said"][300:] = both
    assert outcome.told(columns) == [
        Annunciation(Condition.CATHETER_JAMMED, 10.1, "controller"),
        Annunciation(Condition.CARRIAGE_READING_INVALID, 10.3, "controller"),
    ]


def test_what_comes_again_is_told_again() -> None:
    columns = quiet()
    for begin in (0, 500):
        columns["annunciator.said"][begin : begin + 100] = encode({Condition.SPO2_LOW})
    assert [found.at_s for found in outcome.told(columns)] == [10.0, 10.5]


def test_each_line_is_told_by_its_own() -> None:
    columns = quiet()
    columns["annunciator.reserve_used"][200:] = 1.0
    columns["annunciator.message_late"][206:] = 1.0
    columns["annunciator.watchdog_fired"][221:] = 1.0
    assert outcome.told(columns) == [
        Annunciation(Condition.RESERVE_ENERGY_USED, 10.2, "power"),
        Annunciation(Condition.MESSAGE_LATE, 10.206, "drives"),
        Annunciation(Condition.WATCHDOG_FIRED, 10.221, "drives"),
    ]


def test_a_line_and_the_controller_tell_a_condition_once() -> None:
    columns = quiet()
    columns["annunciator.watchdog_fired"][200:] = 1.0
    columns["annunciator.said"][250:] = encode({Condition.WATCHDOG_FIRED})
    assert outcome.told(columns) == [Annunciation(Condition.WATCHDOG_FIRED, 10.2, "drives")]
