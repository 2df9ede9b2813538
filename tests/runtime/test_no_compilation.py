"""Nothing of the control loop is compiled once it is built, whatever comes: a tick would take 41 s.

Whoever compiles, or loads what was compiled before, takes numba's lock: that is what is counted.
"""

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call"

import ctypes
import gc
import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core import event

from opensuction.ipc import mailbox
from opensuction.kernel.arithmetic import extend_duration
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import ABORT, NO_REQUESTS, START, Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.twin.twin_machine import READINGS
from opensuction.simulation.injection.fault_instant import is_of_machine
from opensuction.simulation.machine_side import MachineSide
from opensuction.twin.fault.fault_table import ROWS
from tests.controller.bedside import at_bed
from tests.runtime.stepped_room import SteppedRoom

pytestmark = pytest.mark.skipif(
    os.environ.get("NUMBA_DISABLE_JIT", "0") != "0", reason="in plain Python nothing is compiled"
)
LOCK = "numba:compiler_lock"
STRANGE = (math.nan, math.inf, -math.inf, 0, 1, -7, 2**40, True, np.float32(0.5), np.int64(3))
"""Readings that are no floats of Python's, or none at all."""
WORDS = ("", "a" * mailbox.NAME_MOST, "\u00e4\u20ac\U0001f600", '"\\')
EACH_TICKS = 20
"""Ticks with each fault."""


@contextmanager
def counted() -> Iterator[list[object]]:
    """What takes the lock meanwhile."""
    taken: list[object] = []

    class Listener(event.Listener):
        def on_start(self, event: object) -> None:
            taken.append(event)

        def on_end(self, event: object) -> None:
            pass

    listener = Listener()
    event.register(LOCK, listener)
    try:
        yield taken
    finally:
        event.unregister(LOCK, listener)


@pytest.fixture
def room(tmp_path: Path) -> Iterator[SteppedRoom]:
    made = SteppedRoom(tmp_path, *at_bed("neonate"))
    yield made
    made.close()


def test_what_is_counted_is_compilation() -> None:
    with counted() as taken:
        numba.njit(lambda value: value + 1)(1)
    assert taken
    extend_duration(0.0, True, 0.001)
    with counted() as taken:
        extend_duration(0.0, True, 0.001)
    assert not taken
    with counted() as taken:
        extend_duration(np.float32(0.0), True, 0.001)  # type: ignore[arg-type]  # another one: all anew
    assert taken


def press_everything(room: SteppedRoom) -> None:
    """Each button, and all of them, in whatever phase the machine is."""
    for name in Requests._fields:
        room.step(NO_REQUESTS._replace(**{name: True}))
        room.run(0.01)
    room.step(Requests(*(True for _ in Requests._fields)))
    for word in WORDS:
        room.buttons.answers = [mailbox.MailboxAnswer(word, word, "start", word, "pressed")]
        room.step()


def falsify_everything(room: SteppedRoom) -> None:
    """Each reading as anything, for a tick; all of them; and none that is new."""
    for place in range(len(READINGS)):
        for value in STRANGE:
            room.machine.falsified = {place: value}
            room.step()
    for value in STRANGE:
        room.machine.falsified = dict.fromkeys(range(len(READINGS)), value)
        room.step()
    room.machine.falsified, room.machine.stands_still = {}, True
    room.run(0.1)
    room.machine.stands_still = False
    room.step(skipped=7)


def break_everything(room: SteppedRoom) -> None:
    """Each fault of machine and patient for a while, one after the other."""
    sound_row = room.machine.call.side_row.copy()
    sound = plain_row.unpack(MachineSide, sound_row)
    for fault, row in ROWS.items():
        if is_of_machine(fault):
            strength = 0.0 if row.strength is None else row.strength.default
            broken = sound._replace(machine=row.change_machine(sound.machine, strength))
            room.machine.call.side_row[:] = plain_row.pack(MachineSide, broken)
            for _ in range(EACH_TICKS):
                room.step()
    room.machine.call.side_row[:] = sound_row


class Heap(ctypes.Structure):
    """What the C library has handed out: ``mallinfo2``."""

    _fields_ = tuple((name, ctypes.c_size_t) for name in "abcdefghij")


def taken_memory() -> tuple[int, int]:
    """Blocks that Python has, and bytes that all have."""
    heap = ctypes.CDLL(None).mallinfo2
    heap.restype = Heap
    return sys.getallocatedblocks(), heap().h


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="another C library")
def test_ten_thousand_ticks_leave_no_memory_behind(room: SteppedRoom) -> None:
    """Without a collector, as in the process: what is not freed by its references alone stays."""
    room.step(START)
    room.run(1.0)

    def play(ticks: int) -> None:
        for _ in range(ticks):
            room.loop.step(0, 0)

    gc.collect()
    gc.disable()
    try:
        play(1000)
        blocks, held = taken_memory()
        play(10_000)
        more_blocks, more = taken_memory()
    finally:
        gc.enable()
    assert more_blocks - blocks < 100  # a hundredth of a block a tick
    assert more - held < 10_000


def test_a_whole_cycle_with_every_request_fault_and_reading_compiles_nothing(
    room: SteppedRoom,
) -> None:
    with counted() as taken:
        room.cycle()
        assert room.phase() == Phase.PARKED
        press_everything(room)
        room.step(ABORT)
        room.step(START)
        room.run(6.0)
        falsify_everything(room)
        break_everything(room)
        press_everything(room)
        room.run(2.0)
    assert taken == []
    columns = room.columns()
    visited = {Phase(int(value)) for value in np.unique(columns["outputs.phase"])}
    assert {Phase.SUCTIONING, Phase.WITHDRAWING, Phase.HALTED} <= visited
    assert np.unique(columns["outputs.verdict.trips"]).size > 1
    assert np.isnan(columns["inputs.readings.head_mm"]).any()
