import numpy as np

from opensuction.safety.alarm.alarm_log import AlarmEvent, Entry
from opensuction.safety.condition import Condition
from opensuction.simulation import outcome
from opensuction.simulation.closed_loop import COLUMNS
from opensuction.simulation.trace import Columns


def quiet(ticks: int) -> Columns:
    """A trace in which nothing happens."""
    columns: Columns = {name: np.zeros(ticks) for name in COLUMNS}
    columns["time_s"] = np.linspace(5.0, 5.0 + ticks * 0.001, ticks, endpoint=False)
    return columns


def test_a_quiet_run_and_an_empty_one_have_only_their_beginning() -> None:
    assert [entry.event for entry in outcome.log(quiet(20)).entries] == [AlarmEvent.STARTED]
    assert [entry.event for entry in outcome.log(quiet(0)).entries] == [AlarmEvent.STARTED]


def test_each_change_is_noted_at_its_tick() -> None:
    columns = quiet(100)
    bit = float(1 << Condition.WATCHDOG_FIRED)  # exact in a double, beyond 32 bits
    columns["signals.present"][10:40] = bit
    columns["signals.acknowledged"][20:] = bit
    columns["signals.latched"][40:60] = bit
    columns["signals.pause_left_s"][30:50] = np.linspace(2.0, 1.0, 20)
    columns["signals.acknowledged"][60:] = 0.0
    noted = [
        (round((entry.time_s - 5.0) * 1000.0), entry.event)
        for entry in outcome.log(columns).entries
    ]
    assert noted == [
        (0, AlarmEvent.STARTED),
        (10, AlarmEvent.RAISED),
        (20, AlarmEvent.ACKNOWLEDGED),
        (30, AlarmEvent.PAUSED),
        (40, AlarmEvent.LATCHED),
        (50, AlarmEvent.PAUSE_ENDED),
        (60, AlarmEvent.RESET),
    ]


def test_what_is_signalled_in_the_first_tick_is_raised_then() -> None:
    columns = quiet(3)
    columns["signals.present"][:] = float(1 << Condition.SPO2_LOW)
    assert outcome.log(columns).entries[1:] == (
        Entry(5.0, int(Condition.SPO2_LOW), AlarmEvent.RAISED),
    )
