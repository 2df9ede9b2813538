"""Frames between processes of one computer, and over python-can."""

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import frame_bus
from opensuction.machine.canopen.device import Bus
from opensuction.machine.canopen.frame_bus import (
    CanFrame,
    DatagramBus,
    FrameBus,
    PythonCanBus,
    open_bus,
)
from tests.machine.canopen.stepped_bus import SteppedClock, stepped_host

UNIX = Bus(frame_bus.UNIX, "bus", 0, 0.004)
FRAMES = st.lists(st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(max_size=8)))


@pytest.fixture
def folder() -> Iterator[Path]:
    """A short path: a socket's address has room for 107 characters."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


def both(folder: Path) -> tuple[FrameBus, FrameBus]:
    return (
        open_bus(UNIX, THIS_COMPUTER, "host", folder),
        open_bus(UNIX, THIS_COMPUTER, "drives", folder),
    )


@given(FRAMES)
def test_frames_come_out_of_a_datagram_as_they_went_in(frames: list[CanFrame]) -> None:
    assert frame_bus.unpack(frame_bus.pack(frames)) == frames


@given(st.binary(max_size=40))
def test_nonsense_gives_frames_or_nothing(datagram: bytes) -> None:
    for one in frame_bus.unpack(datagram):
        assert len(one.data) <= 8


def test_a_participant_sees_every_other_ones_frames_in_their_order(folder: Path) -> None:
    host, drives = both(folder)
    third = open_bus(UNIX, THIS_COMPUTER, "third", folder)
    other = open_bus(UNIX._replace(channel="bus.2"), THIS_COMPUTER, "host", folder)
    sent = [CanFrame(0x80, b""), CanFrame(0x181, bytes(8))]
    host.send(sent)
    assert list(drives.receive()) == list(third.receive()) == sent
    assert not list(host.receive())
    assert not list(other.receive())
    for one in (host, drives, third, other):
        one.close()
    assert not list(folder.iterdir())


def test_to_look_for_others_puts_no_names_into_the_interpreters_table(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the table is made anew, which comes once in minutes, a tick took 8 to 28 ms."""
    clock = SteppedClock()
    host, drives = (
        DatagramBus(folder / "bus", name, stepped_host(clock)) for name in ("host", "drives")
    )
    host.send([])
    names: list[str] = []

    def intern(name: str) -> str:
        names.append(name)
        return name

    monkeypatch.setattr(sys, "intern", intern)
    for number in range(100):
        clock.now_ns += frame_bus.LOOK_NS
        host.send([CanFrame(number, b"")])
        assert list(drives.receive()) == [CanFrame(number, b"")]
    assert not names
    third = DatagramBus(folder / "bus", "third", stepped_host(clock))
    names.clear()
    clock.now_ns += frame_bus.LOOK_NS
    host.send([CanFrame(1, b"")])
    assert list(third.receive()) == [CanFrame(1, b"")]
    assert names  # it would have been seen
    for one in (host, drives, third):
        one.close()


def test_who_has_left_or_takes_nothing_holds_nobody_up(folder: Path) -> None:
    host, drives = both(folder)
    for number in range(1000):
        host.send([CanFrame(number, b"")])
    came = list(drives.receive())
    assert came == [CanFrame(number, b"") for number in range(len(came))]
    drives.close()
    host.send([CanFrame(1, b"")])
    again = DatagramBus(folder / "bus", "drives", THIS_COMPUTER)
    host.send([CanFrame(2, b"")])
    assert list(again.receive()) == [CanFrame(2, b"")]
    host.close()
    again.close()


def test_a_bus_that_cannot_be_is_refused_in_one_line(folder: Path) -> None:
    for bus in (UNIX._replace(channel="x" * 200), UNIX._replace(interface="no-such-bus")):
        with pytest.raises(InputError) as refused:
            open_bus(bus, THIS_COMPUTER, "host", folder)
        assert "\n" not in str(refused.value)


def test_python_can_carries_the_same_frames() -> None:
    bus = Bus("virtual", "frames", 0, 0.004)
    host, drives = (open_bus(bus, THIS_COMPUTER, name) for name in ("host", "drives"))
    with can.Bus(interface="virtual", channel="frames") as other:
        other.send(can.Message(arbitration_id=0x10000, is_extended_id=True))
        other.send(can.Message(arbitration_id=0x10, is_extended_id=False, is_remote_frame=True))
        sent = [CanFrame(0x80, b""), CanFrame(0x181, b"12345678")]
        host.send(sent)
        assert list(drives.receive()) == sent
    host.close()
    drives.close()


def test_an_interface_that_gives_only_errors_ends_a_look(monkeypatch: pytest.MonkeyPatch) -> None:
    bus = PythonCanBus(Bus("virtual", "down", 0, 0.004))

    def fail(timeout: float | None = None) -> None:
        raise can.CanOperationError(f"the network is down ({timeout})")

    monkeypatch.setattr(bus._bus, "recv", fail)
    try:
        assert list(bus.receive()) == []
    finally:
        bus.close()
