"""Stretches in which a simulated computer's controller and twin tick, and nobody else is due.

They are most of a life's steps. One call plays them (`simulation.paired_ticks`) as the processes
themselves would, each step at the instant that the seed draws; it ends where one of the two has
more to do than its tick, and before anybody else's step. Where no controller lives the twin ticks
alone.
"""

from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from opensuction.controller import real_time_call
from opensuction.controller.loop_tick import NUMBER
from opensuction.controller.real_time_call import OUTPUT_COLUMNS
from opensuction.evidence.lives.simulated_process import Activity, SimulatedProcess
from opensuction.ipc.deadline_scheduler import DeadlineScheduler
from opensuction.ipc.ring import RingReader, RingWriter
from opensuction.kernel import slot
from opensuction.kernel.compiler.dispatcher import TypedCall
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.kernel.record import Array
from opensuction.machine.twin import twin_process
from opensuction.machine.twin.twin_machine import SHOWN_READINGS, TwinMachine
from opensuction.machine.twin.twin_process import Listener, Playing, TwinPlayer
from opensuction.runtime.loop import ControlLoop
from opensuction.simulation import paired_ticks
from opensuction.simulation.machine_side import MESSAGE
from opensuction.simulation.paired_ticks import (
    BUSY,
    CLOCK,
    DEADLINE,
    DUE,
    LOOP,
    MACHINE,
    SKIPPED,
    LoopSide,
    MachineRow,
    RingEnds,
    Stretch,
)

MOST = 1024
"""Steps of a stretch."""
SHORTEST_NS = 2_000_000
"""A shorter one is not worth the call."""
NEVER_NS = 1 << 62
_PHASE = OUTPUT_COLUMNS.index("phase")
_READINGS = np.array([SHOWN_READINGS.start, SHOWN_READINGS.stop])


class Pair(NamedTuple):
    """Activities of the two, the one whose turn it is first."""

    first: Activity
    second: Activity


class _Sides(NamedTuple):
    """Both sides as the call takes them, as long as they have the same settings and rings."""

    settings: Array
    shown: RingReader
    commands: RingReader
    taken: tuple[LoopSide, MachineRow, RingEnds, RingEnds, RingEnds]
    periods_ns: npt.NDArray[np.int64]


class StretchedComputer(Protocol):
    """The computer, as far as a stretch of its time is played elsewhere."""

    now_ns: int
    slow_until_ns: int
    slow: float
    """A step takes up to so many times as long until then."""
    step_s: Array
    """Longest step, and longest lateness of one."""

    def take_second(self, pair: Pair) -> tuple[int, int] | None:
        """Instants at which the second of a pair begins its next step, and anybody else is due.

        It is taken out of the queue; None, and it is not, where somebody else is due before.
        """

    def next_due_ns(self) -> int:
        """Instant at which anybody is due."""

    def put_back(self) -> None:
        """Put what was taken last into the queue again, in its old place."""

    def draws(self) -> Array:
        """Random numbers that come next."""

    def pass_by(self, at_ns: npt.NDArray[np.int64], pids: npt.NDArray[np.int64]) -> None:
        """Note steps that were done elsewhere; each has taken its random numbers."""

    def queue_at(self, activity: Activity, at_ns: int) -> None:
        """Have an activity go on at an instant."""


class PairedStretches:
    """Plays them for one computer."""

    def __init__(self, computer: StretchedComputer) -> None:
        self._computer = computer
        self._loop: tuple[Activity, ControlLoop, DeadlineScheduler] | None = None
        self._twin: tuple[Activity, Playing] | None = None
        self.seen_phase: float | None = None
        """A stretch begins only in the phase that was seen last; None: in any."""
        self._play = TypedCall(paired_ticks.play, lambda loop, *_: loop.heads_mm is None)
        self._play_machine = TypedCall(paired_ticks.play_machine, lambda *_: ())
        self._sides: _Sides | None = None
        self._at_ns = np.empty(MOST, np.int64)
        self._who = np.empty(MOST, np.uint8)

    def take_loop(self, activity: Activity, loop: ControlLoop, pace: DeadlineScheduler) -> None:
        """Take note of a controller that begins to tick."""
        self._loop, self._sides = (activity, loop, pace), None

    def take_twin(self, activity: Activity, playing: Playing) -> None:
        """Take note of the twin that begins to play."""
        self._twin, self._sides = (activity, playing), None

    def play(self, activity: Activity, ends_ns: int) -> bool:
        """Play a stretch that begins with a step of an activity now; false where there is none."""
        if self._twin is None:
            return False
        of_twin, playing = self._twin
        if self._loop is None or self._loop[0].process.status is not None:
            return activity is of_twin and self._play_alone(ends_ns)
        of_loop, loop, _ = self._loop
        if activity is not of_loop and activity is not of_twin:
            return False
        port, commands = loop.around.port, playing.listener.ring.reader
        if not isinstance(port, TwinMachine) or port.shown is None or commands is None:
            return False
        if not self._is_left_alone():
            return False
        pair = Pair(activity, of_twin if activity is of_loop else of_loop)
        taken = self._computer.take_second(pair)
        if taken is None:
            return False
        second_ns, others_ns = taken
        limit_ns = min(others_ns, ends_ns + 1)
        played = limit_ns - self._computer.now_ns > SHORTEST_NS and self._play_until(
            limit_ns, pair, second_ns, port, commands
        )
        if not played:
            self._computer.put_back()
        return played

    def _is_left_alone(self) -> bool:
        """True where both do nothing but tick, and whoever waits for a phase has seen it."""
        assert self._loop is not None
        assert self._twin is not None
        loop, twin = self._loop[1], self._twin[1].twin
        if not all(map(self._has_no_news, (self._loop[0].process, self._twin[0].process))):
            return False
        if self.seen_phase not in (None, loop.memory.outputs[_PHASE]):
            return False
        return loop.is_left_alone and twin.faults.is_sound

    def _has_no_news(self, process: SimulatedProcess) -> bool:
        """True of a process that runs and that nobody has told anything."""
        is_awake = process.frozen_until_ns <= self._computer.now_ns
        runs = process.status is None and not process.terminations and is_awake
        return runs and not any(inbox.waiting for inbox in process.inboxes)

    def _play_alone(self, ends_ns: int) -> bool:
        """Play the twin's ticks until anybody is due; false where there is more to do."""
        assert self._twin is not None
        of_twin, (twin, listener, pace) = self._twin
        computer, commands = self._computer, listener.ring.reader
        if not (twin.faults.is_sound and self._has_no_news(of_twin.process)):
            return False
        if commands is None and listener.heard.counts[MESSAGE]:
            return False
        limit_ns = min(computer.next_due_ns(), ends_ns + 1)
        if limit_ns - computer.now_ns <= SHORTEST_NS:
            return False
        clocks = np.zeros((2, CLOCK), np.int64)
        busy_ns = of_twin.process.busy_until_ns
        due_ns = max(computer.now_ns, busy_ns)
        clocks[MACHINE] = pace.deadline_ns, pace.skipped, due_ns, busy_ns
        periods_ns = np.array([pace.period_ns, pace.period_ns])
        before = int(twin.ring.header[slot.NEWEST])
        count = self._play_machine(
            _machine_row(twin, listener),
            _SILENT if commands is None else _read_end(commands),
            _ends(twin.ring, None),
            self._stretch(clocks, periods_ns, limit_ns, NEVER_NS),
        )
        if count == 0:
            return False
        twin.faults.tick += int(twin.ring.header[slot.NEWEST]) - before
        computer.pass_by(self._at_ns[:count], np.full(count, of_twin.process.pid))
        self._conclude(of_twin, pace, clocks[MACHINE].tolist())
        return True

    def _stretch(
        self,
        clocks: npt.NDArray[np.int64],
        periods_ns: npt.NDArray[np.int64],
        ends: int,
        looks: int,
    ) -> Stretch:
        computer = self._computer
        return Stretch(
            clocks,
            periods_ns,
            ends,
            _PHASE,
            looks,
            computer.step_s,
            computer.slow_until_ns,
            computer.slow,
            computer.draws(),
            self._at_ns,
            self._who,
        )

    def _conclude(self, activity: Activity, pace: DeadlineScheduler, clock: list[int]) -> None:
        """Leave an activity as its process would have."""
        pace.deadline_ns, pace.skipped = clock[DEADLINE], clock[SKIPPED]
        activity.process.busy_until_ns = clock[BUSY]
        activity.due_ns = pace.due_ns
        self._computer.queue_at(activity, clock[DUE])

    def _play_until(
        self, limit_ns: int, pair: Pair, second_ns: int, port: TwinMachine, commands: RingReader
    ) -> bool:
        """Play until an instant; false where the first step is more than a tick."""
        assert self._loop is not None
        assert self._twin is not None
        assert port.shown is not None
        of_loop, loop, loop_pace = self._loop
        of_twin, (twin, _, twin_pace) = self._twin
        computer, sides = self._computer, self._sides_of(port.shown, commands)
        clocks = np.zeros((2, CLOCK), np.int64)
        begins = {id(pair.first): computer.now_ns, id(pair.second): second_ns}
        both = ((LOOP, of_loop, loop_pace), (MACHINE, of_twin, twin_pace))
        for who, activity, pace in both:
            busy_ns = activity.process.busy_until_ns
            due_ns = max(begins[id(activity)], busy_ns)
            clocks[who] = pace.deadline_ns, pace.skipped, due_ns, busy_ns
        before = int(twin.ring.header[slot.NEWEST])
        count = self._play(
            *sides.taken, self._stretch(clocks, sides.periods_ns, limit_ns, port.looks_ns)
        )
        if count == 0:
            return False
        pids = np.where(self._who[:count] == LOOP, of_loop.process.pid, of_twin.process.pid)
        computer.pass_by(self._at_ns[:count], pids)
        twin.faults.tick += int(twin.ring.header[slot.NEWEST]) - before
        port.number = int(loop.memory.counts[NUMBER])
        for (_, activity, pace), clock in zip(both, clocks.tolist(), strict=True):
            self._conclude(activity, pace, clock)
        return True

    def _sides_of(self, shown: RingReader, commands: RingReader) -> _Sides:
        """Both sides; put together where one has got other settings or another ring."""
        assert self._loop is not None
        assert self._twin is not None
        (_, loop, loop_pace), (twin, listener, twin_pace) = self._loop, self._twin[1]
        known, settings, port = self._sides, loop.call.settings_row, loop.around.port
        is_same = known is not None and known.settings is settings
        if known is not None and is_same and known.shown is shown and known.commands is commands:
            return known
        assert isinstance(port, TwinMachine)
        machine = _machine_row(twin, listener)
        rings = _ends(port.commands, commands), _ends(twin.ring, shown)
        self._sides = _Sides(
            settings,
            shown,
            commands,
            (_side_of(loop), machine, *rings, _ends(loop.around.ring, None)),
            np.array([loop_pace.period_ns, twin_pace.period_ns]),
        )
        return self._sides


def _machine_row(twin: TwinPlayer, listener: Listener) -> MachineRow:
    call = twin.call
    return MachineRow(
        call.side_row,
        call.memory,
        call.shown_row,
        listener.heard,
        twin_process.LOOK_TICKS,
        twin_process.CAUGHT_UP,
    )


def _side_of(loop: ControlLoop) -> LoopSide:
    call, memory = loop.call, loop.memory
    return LoopSide(
        call.settings_row,
        call.heads_mm,
        call.state_row,
        memory.inputs[np.newaxis],
        memory.outputs[np.newaxis],
        real_time_call.NO_STATES,
        loop.row,
        memory,
        loop.pace,
        loop.readings,
        _READINGS,
        loop.look_ticks,
    )


def _ends(writer: RingWriter, reader: RingReader | None) -> RingEnds:
    read = writer if reader is None else reader
    return RingEnds(writer.header, writer.slots, read.header, read.slots)


def _read_end(reader: RingReader) -> RingEnds:
    """A ring that nobody writes to any more."""
    return RingEnds(reader.header, reader.slots, reader.header, reader.slots)


def _empty_ring() -> RingEnds:
    header = np.zeros(slot.NEWEST + 1, np.uint64)
    slots = np.zeros((1, len(MESSAGE_COLUMNS) + slot.AROUND), np.uint64)
    return RingEnds(header, slots, header, slots)


_SILENT = _empty_ring()
"""Ring of a controller that has not begun."""
