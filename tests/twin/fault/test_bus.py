"""A bus that takes its time: how long messages take, and that none is obeyed twice or too late."""

import numpy as np
import pytest

from opensuction.kernel.errors import InputError
from opensuction.twin.fault import bus, link
from opensuction.twin.fault.bus import Bus
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.link import SILENT, Link, LinkState
from tests.settled import settled
from tests.twin.fault.test_link import DT_S, FIRST, faulty, message, readings, sent_through

HEALTHY = link.healthy(seed=1)
TICKS = 4000


taken_ticks = settled(bus.taken_ticks)


def on(carrier: Bus) -> Link:
    return link.on_bus(HEALTHY, carrier, DT_S)


def ages(carrier: Bus) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By tick how old the readings are and the command is; whether the command is new."""
    arrived, obeyed, news = sent_through(on(carrier), TICKS)
    ticks = np.arange(TICKS)
    read = ticks - np.array([one.head_mm for one in arrived])
    sent = ticks - np.array([one.number for one in obeyed])
    return read[100:], sent[100:], np.array(news)[100:]


def test_a_bus_that_takes_no_time_and_loses_nothing_is_none() -> None:
    assert on(Bus(0.0, 0.0, 0.0)) == HEALTHY


@pytest.mark.parametrize("ticks", [1, 3, 12])
def test_whole_ticks_without_jitter_are_a_delay(ticks: int) -> None:
    """A message that is sent within a tick and takes whole ones comes after as many."""
    read, sent, news = ages(Bus(ticks * DT_S, 0.0, 0.0))
    assert (read == ticks).all()
    assert (sent == ticks).all()
    assert news.all()


def test_half_a_tick_delays_half_of_the_messages_by_one() -> None:
    read, sent, news = ages(Bus(0.0005, 0.0003, 0.0))
    # Four standard deviations of 3,900 draws: .032.
    assert np.mean(read == 1) == pytest.approx(0.5, abs=0.032)
    assert set(sent) == {0.0, 1.0}
    assert np.mean(sent) == pytest.approx(0.5, abs=0.032)
    # One that is late while the next is not has been overtaken, and is no news.
    overtaken = (sent[:-1] == 1) & (sent[1:] == 0)
    assert np.count_nonzero(~news) == pytest.approx(np.count_nonzero(overtaken), abs=1)


def test_what_a_message_takes_is_spread_evenly_over_the_jitter() -> None:
    spread = bus.spread_of(Bus(0.01, 0.004, 0.0), DT_S)
    taken = [taken_ticks(spread, HEALTHY.stream, bus.COMMANDS, tick) for tick in range(TICKS)]
    assert (min(taken), max(taken)) == (6, 14)
    assert np.mean(taken) == pytest.approx(10.0, abs=4.0 * 2.33 / TICKS**0.5)
    # 8 ticks wide and one for where within its tick it is sent.
    assert np.var(taken) == pytest.approx(8.0**2 / 12.0 + 1.0 / 6.0, rel=0.1)
    other = [taken_ticks(spread, HEALTHY.stream, bus.READINGS, tick) for tick in range(TICKS)]
    assert abs(np.corrcoef(taken, other)[0, 1]) < 4.0 / TICKS**0.5


def test_the_newest_that_has_come_is_obeyed_and_nothing_older_again() -> None:
    carrier = Bus(0.01, 0.008, 0.0)
    _, obeyed, news = sent_through(on(carrier), TICKS)
    spread = bus.spread_of(carrier, DT_S)
    comes = [
        tick + bus.taken_ticks(spread, HEALTHY.stream, bus.COMMANDS, tick) for tick in range(TICKS)
    ]
    for tick in range(TICKS):
        there = [sent for sent in range(max(tick - 40, 0), tick + 1) if comes[sent] <= tick]
        expected = max(there, default=-1)
        assert obeyed[tick] == message(expected)
        assert news[tick] == (tick > 0 and expected > obeyed[tick - 1].number)


@pytest.mark.parametrize("latency_s", [0.0, 0.003])
def test_so_many_are_lost_and_do_not_come_later(latency_s: float) -> None:
    """Whoever gets none keeps the last, and no flag tells."""
    arrived, obeyed, news = sent_through(on(Bus(latency_s, 0.0, 0.05)), TICKS)
    tolerance = 4.0 * (0.05 * 0.95 / TICKS) ** 0.5
    assert all(one.head_valid for one in arrived)
    head_mm = np.array([one.head_mm for one in arrived])
    same = np.diff(head_mm) == 0.0
    assert np.mean(same) == pytest.approx(0.05, abs=tolerance)
    assert np.mean([not new for new in news]) == pytest.approx(0.05, abs=tolerance)
    assert np.mean(same & ~np.array(news)[1:]) < 0.01  # each way for itself
    late = {tick - one.number for tick, one in enumerate(obeyed) if news[tick]}
    assert late == {round(latency_s / DT_S)}
    assert set((np.arange(TICKS) - head_mm)[1:][~same][10:]) == late


def test_of_a_bus_that_loses_everything_nothing_comes() -> None:
    arrived, obeyed, news = sent_through(on(Bus(0.001, 0.0005, 1.0)), 100)
    assert arrived == [FIRST.readings] * 100
    assert obeyed == [FIRST.message] * 100
    assert not any(news)


def test_a_controller_that_sends_at_half_the_rate_is_heard_as_well() -> None:
    """What was not sent overtakes nothing."""
    joint, state, rings = on(Bus(0.0015, 0.001, 0.0)), FIRST, link.rings(FIRST)
    numbers = []
    for tick in range(TICKS):
        sent = message(tick) if tick % 4 == 0 else message(tick)._replace(number=SILENT)
        past = link.recall(joint, *rings, tick)
        there, _ = link.receive_message(joint, state, sent, past, tick)
        link.keep(readings(tick), sent, *rings, tick)
        state = LinkState(FIRST.readings, there)
        numbers.append(there.number)
    # It takes 2.5 ticks at most and is sent once in four: each comes, and none is overtaken.
    assert set(numbers) >= set(range(0, TICKS - 4, 4))


def test_faults_come_on_top_of_a_bus() -> None:
    late = faulty(Fault.MESSAGE_LATE, 0.005)
    joint = link.on_bus(late, Bus(0.002, 0.0, 0.0), DT_S)
    _, obeyed, _ = sent_through(joint, 100)
    assert [one.number for one in obeyed[20:]] == [tick - 7 for tick in range(20, 100)]
    lost = faulty(Fault.MESSAGE_LOST, 0.5)
    _, _, news = sent_through(link.on_bus(lost, Bus(0.002, 0.0, 0.1), DT_S), TICKS)
    assert np.mean(news) == pytest.approx(0.45, abs=4.0 * 0.5 / TICKS**0.5)
    flagged, _, _ = sent_through(
        link.on_bus(faulty(Fault.READING_LOST, 0.5), Bus(0.002, 0.0, 0.0), DT_S), TICKS
    )
    assert np.mean([one.head_valid for one in flagged]) == pytest.approx(0.5, abs=0.04)


@pytest.mark.parametrize(
    ("carrier", "what"),
    [
        (Bus(-0.001, 0.0, 0.0), "latency"),
        (Bus(0.001, 0.002, 0.0), "jitter"),
        (Bus(0.6, 0.0, 0.0), "0.5 s"),
        (Bus(float("nan"), 0.0, 0.0), "latency"),
        (Bus(0.001, 0.0, 1.5), "share"),
    ],
)
def test_what_no_bus_does_is_refused(carrier: Bus, what: str) -> None:
    with pytest.raises(InputError, match=what):
        on(carrier)
