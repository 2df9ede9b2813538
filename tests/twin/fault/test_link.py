"""Messages between controller and machine: on time, late, lost or repeated."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import NO_MONITOR, Commands, Monitor, Readings
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import FaultOnset
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.fault.link import MONITOR_TICKS, Link, LinkState, Message
from tests.settled import settled

HEALTHY = link.healthy(seed=1)
DT_S = 0.001


def readings(tick: int) -> Readings:
    """Readings that can be told apart."""
    return Readings(
        float(tick),
        True,
        float(tick),
        True,
        0.1,
        True,
        50.0,
        True,
        tick % 3 == 0,
        True,
        True,
        0.01,
        NO_MONITOR,
    )


def commands(tick: int) -> Commands:
    return Commands(float(tick), 1.0, True, 0.2, 2.0, False, tick % 2 == 0, 100.0)


def message(tick: int) -> Message:
    return Message(commands(tick), wanted=tick + 1, number=tick)


FIRST = LinkState(readings(-1), message(-1))


def faulty(fault: Fault, strength: float = 0.0, tick: int = 0) -> Link:
    return ROWS[fault].change_link(HEALTHY, FaultOnset(strength, tick, DT_S))


recall = settled(link.recall)
receive_readings = settled(link.receive_readings)
receive_message = settled(link.receive_message)
receive_monitor = settled(link.receive_monitor)
keep = settled(link.keep)


def sent_through(joint: Link, ticks: int) -> tuple[list[Readings], list[Message], list[bool]]:
    """What arrives each tick: readings, messages, and whether those are new."""
    state = FIRST
    rings = link.rings(FIRST)
    arrived, obeyed, news = [], [], []
    for tick in range(ticks):
        past = recall(joint, *rings, tick)
        here = receive_readings(joint, state, readings(tick), past, tick)
        there, new = receive_message(joint, state, message(tick), past, tick)
        keep(readings(tick), message(tick), *rings, tick)
        state = LinkState(here, there)
        arrived.append(here)
        obeyed.append(there)
        news.append(new)
    return arrived, obeyed, news


def test_a_healthy_link_lets_everything_through() -> None:
    arrived, obeyed, news = sent_through(HEALTHY, 200)
    assert arrived == [readings(tick) for tick in range(200)]
    assert obeyed == [message(tick) for tick in range(200)]
    assert all(news)


@given(st.integers(1, 60))
def test_late_messages_are_those_of_before(delay: int) -> None:
    arrived, _, _ = sent_through(faulty(Fault.READING_LATE, delay * DT_S), 150)
    _, obeyed, news = sent_through(faulty(Fault.MESSAGE_LATE, delay * DT_S), 150)
    assert arrived == [readings(max(tick - delay, -1)) for tick in range(150)]
    assert obeyed == [message(max(tick - delay, -1)) for tick in range(150)]
    assert news == [tick >= delay for tick in range(150)]


@given(begin=st.integers(1, 80), delay=st.integers(1, 60))
def test_what_was_obeyed_is_not_obeyed_again_once_messages_are_late(begin: int, delay: int) -> None:
    """The delay begins in the midst of a run: the drives keep their last command meanwhile."""
    late = faulty(Fault.MESSAGE_LATE, delay * DT_S)
    state = FIRST
    rings = link.rings(FIRST)
    for tick in range(150):
        joint = late if tick >= begin else HEALTHY
        past = recall(joint, *rings, tick)
        there, new = receive_message(joint, state, message(tick), past, tick)
        keep(FIRST.readings, message(tick), *rings, tick)
        expected = tick if tick < begin else max(tick - delay, begin - 1)
        assert there == message(expected)
        assert new == (there.number > state.message.number)
        state = LinkState(FIRST.readings, there)


@given(begin=st.integers(1, 80), delay=st.integers(1, 60))
def test_readings_are_late_by_the_whole_delay_from_the_instant_on(begin: int, delay: int) -> None:
    late = faulty(Fault.READING_LATE, delay * DT_S)
    rings = link.rings(FIRST)
    for tick in range(150):
        joint = late if tick >= begin else HEALTHY
        past = recall(joint, *rings, tick)
        read = receive_readings(joint, FIRST, readings(tick), past, tick)
        keep(readings(tick), FIRST.message, *rings, tick)
        assert read == readings(tick if tick < begin else max(tick - delay, -1))


def test_a_lost_reading_is_not_valid_and_keeps_its_value() -> None:
    arrived, _, _ = sent_through(faulty(Fault.READING_LOST, 1.0), 5)
    for read in arrived:
        flags = (read.head_valid, read.cam_valid, read.vacuum_valid, read.contact_valid)
        assert not any(flags)
        assert read.head_mm == -1.0


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_so_many_messages_are_lost_as_the_strength_says(share: float) -> None:
    arrived, _, _ = sent_through(faulty(Fault.READING_LOST, share), 2000)
    _, obeyed, news = sent_through(faulty(Fault.MESSAGE_LOST, share), 2000)
    # Four standard deviations of 2,000 draws.
    tolerance = 4.0 * (share * (1.0 - share) / 2000) ** 0.5
    assert np.mean([not read.head_valid for read in arrived]) == pytest.approx(share, abs=tolerance)
    assert np.mean([not new for new in news]) == pytest.approx(share, abs=tolerance)
    held = [obeyed[tick] == obeyed[tick - 1] for tick in range(1, 2000)]
    assert held == [not new for new in news[1:]]


def test_repeated_messages_never_change_and_are_no_news() -> None:
    arrived, _, _ = sent_through(faulty(Fault.READING_REPEATED), 5)
    _, obeyed, news = sent_through(faulty(Fault.MESSAGE_REPEATED), 5)
    assert arrived == [FIRST.readings] * 5
    assert obeyed == [FIRST.message] * 5
    assert not any(news)


@pytest.mark.parametrize(
    ("fault", "reserve"),
    [
        (Fault.POWER_LOST, True),
        (Fault.POWER_LOST_WITHOUT_RESERVE, False),
        (Fault.CONTROLLER_STOPPED, True),
    ],
)
def test_a_dead_controller_sends_nothing(fault: Fault, reserve: bool) -> None:
    dead = faulty(fault, 5.0)
    assert not any(sent_through(dead, 5)[2])
    assert dead.reserve == reserve
    assert dead.mains == (fault == Fault.CONTROLLER_STOPPED)


def test_late_ticks_end_after_their_time() -> None:
    assert faulty(Fault.TICK_LATE, 0.2, tick=100).late_until_tick == 300


@pytest.mark.parametrize("turn", [1, 4, 25])
def test_what_is_lost_by_turns_is_lost_for_as_long_as_it_comes_through(turn: int) -> None:
    arrived, _, _ = sent_through(faulty(Fault.READING_INTERMITTENT, turn * DT_S, tick=10), 200)
    _, _, news = sent_through(faulty(Fault.MESSAGE_INTERMITTENT, turn * DT_S, tick=10), 200)
    for tick in range(10, 200):
        is_there = (tick - 10) // turn % 2 == 0
        assert arrived[tick].head_valid != is_there
        assert news[tick] != is_there


def shown(tick: int) -> Monitor:
    """What the monitor shows: another value in each step of the bedside."""
    return NO_MONITOR._replace(connected=True, spo2_percent=float(tick // MONITOR_TICKS))


def watched(fault: Fault, strength: float, begin: int, ticks: int) -> list[float]:
    """Saturation as it arrives in each tick, under a fault from an instant on."""
    state, late = FIRST, faulty(fault, strength, tick=begin)
    rings = link.rings(FIRST)
    arrived = []
    for tick in range(ticks):
        joint = late if tick >= begin else HEALTHY
        past = recall(joint, *rings, tick)
        seen = receive_monitor(joint, state, shown(tick), past)
        keep(FIRST.readings._replace(monitor=shown(tick)), FIRST.message, *rings, tick)
        state = state._replace(readings=state.readings._replace(monitor=seen))
        arrived.append(seen.spo2_percent)
    return arrived


def test_a_frozen_monitor_shows_what_it_showed() -> None:
    arrived = watched(Fault.MONITOR_FROZEN, 0.0, begin=505, ticks=1000)
    assert arrived[:505] == [float(tick // MONITOR_TICKS) for tick in range(505)]
    assert arrived[505:] == [50.0] * 495


@pytest.mark.parametrize(
    "delay_s",
    [0.01, 20.0, *(pytest.param(one, marks=pytest.mark.soak) for one in (1.0, 5.0))],
)
def test_a_late_monitor_shows_what_was(delay_s: float) -> None:
    begin, ticks = 1000, 30_000
    arrived = watched(Fault.MONITOR_LATE, delay_s, begin, ticks)
    late = [max(tick // MONITOR_TICKS - round(delay_s * 100), 0) for tick in range(begin, ticks)]
    assert arrived[begin:] == late


def test_readings_that_fail_leave_the_monitor_alone() -> None:
    """It has a link of its own."""
    for fault in (Fault.READING_LOST, Fault.READING_LATE, Fault.READING_REPEATED):
        strength = ROWS[fault].default_strength
        arrived = watched(fault, strength, begin=0, ticks=100)
        assert arrived == [float(tick // MONITOR_TICKS) for tick in range(100)]
