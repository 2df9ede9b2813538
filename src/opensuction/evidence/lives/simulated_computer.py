"""A computer that a seed drives: its clocks, its scheduler, and the processes that run on it.

The processes are the real ones (`host.Steps`), all in one thread. Each step begins when it is due
and a drawn delay later, and takes a drawn time in which its process does nothing else. A process
that is killed does not do another step, and lets go of what the system holds for it; one that is
frozen comes to its steps late. The same seed gives the same order of steps.
"""

import gc
import hashlib
import heapq
import random
import signal
import struct
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.evidence.lives.paired_stretch import NEVER_NS, Pair, PairedStretches
from opensuction.evidence.lives.simulated_disk import SimulatedDisk, SimulatedFiles
from opensuction.evidence.lives.simulated_process import (
    KILLED,
    Activity,
    ProcessDiedError,
    SimulatedClock,
    SimulatedDatagrams,
    SimulatedInbox,
    SimulatedLock,
    SimulatedLocks,
    SimulatedProcess,
    SimulatedProcesses,
    SimulatedWorker,
)
from opensuction.host.host import (
    NS_PER_S,
    Allowed,
    Child,
    Host,
    Steps,
    Work,
    Worker,
)
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.simulation import paired_ticks

Main = Callable[[Host, tuple[str, ...]], Steps[None]]
"""A process: takes its computer and its arguments."""
FIRST_PID = 1000
BEGAN_WALL_NS = 1_750_000_000 * NS_PER_S
"""UTC at the monotonic clock's zero: nothing is special about it."""
SLOW = 20


_Entry = tuple[int, int, "Activity | Callable[[], object]"]
"""Of the queue: when it is due, its number, and what is then done."""


class MailShares(NamedTuple):
    """Shares of the datagrams that go astray."""

    lost: float = 0.0
    twice: float = 0.0
    late: float = 0.0
    """Up to `late_s`: a later one may overtake it."""
    late_s: float = 0.3
    until_ns: int = 0
    """From then on none does."""


class Timing(NamedTuple):
    """Delays of a computer; each is drawn evenly up to it."""

    late_s: float = 0.0002
    """From when a step is due until it begins."""
    step_s: float = 0.0001
    """Of a step."""
    start_s: tuple[float, float] = (0.3, 1.5)
    """From the start of a process until its first step: shortest and longest."""


USUAL = Timing()


BLOCK = 8192
"""Random numbers that are drawn at a time."""
STEP, STEPS = struct.Struct(">qh"), np.dtype([("at_ns", ">i8"), ("pid", ">i2")])
"""A step in what the hash of a trace is made from."""


class Step(NamedTuple):
    """A step that was done."""

    at_ns: int
    pid: int
    module: str


@contextmanager
def _not_hardened() -> Iterator[Allowed]:
    yield Allowed("fifo", memory_locked=True, refusals=())


class SimulatedComputer:
    """Runs processes under a clock of its own."""

    def __init__(self, seed: int, mains: Mapping[str, Main], timing: Timing = USUAL) -> None:
        """mains: the processes that can be started, by the name of their module."""
        self.now_ns = NS_PER_S
        self.wall_offset_ns = BEGAN_WALL_NS
        self.locks: dict[Path, SimulatedLock] = {}
        self.inboxes: dict[Path, SimulatedInbox] = {}
        self.processes: dict[int, SimulatedProcess] = {}
        self.crashes: list[str] = []
        """Errors that no process should have, with where they come from."""
        self.watch: Callable[[Step], None] = lambda _: None
        """Told of a step before it is done, but not of those of a stretch."""
        self.watch_passed: Callable[[Step], None] = lambda _: None
        """Told of the first and the last step of each process in a stretch, after it."""
        self.running: Activity | None = None
        """Whose step is being done."""
        self.stretches: PairedStretches | None = PairedStretches(self)
        """None: each step is done by itself."""
        self.trace, self.steps = hashlib.sha256(), 0
        """Of all steps: when each began, and of which process; and their number."""
        self.listen: Callable[[str], None] = lambda _: None
        """Told of each process that begins or ends."""
        self.disk = SimulatedDisk(self, seed)
        self.mail = MailShares()
        self.slow_until_ns = 0
        """Other work takes the processors until then: a step takes up to `SLOW` times as long."""
        self.slow = float(SLOW)
        self.step_s = np.array([timing.step_s, timing.late_s])
        self._mains, self._timing = mains, timing
        self._chance, self._tokens = random.Random(seed), random.Random(seed + 1)
        self._drawn, self._used = self._draw_block(), 0
        self._queue: list[_Entry] = []
        self._number = 0
        self._taken: _Entry | None = None

    def draw(self) -> float:
        """A random number from 0 to 1."""
        if self._used == BLOCK:
            self._drawn, self._used = self._draw_block(), 0
        number = float(self._drawn[self._used])
        self._used += 1
        return number

    def draws(self) -> Array:
        """Random numbers that come next."""
        if self._used == BLOCK:
            self._drawn, self._used = self._draw_block(), 0
        return self._drawn[self._used :]

    def _draw_block(self) -> Array:
        return np.array([self._chance.random() for _ in range(BLOCK)])

    def holder(self, path: Path) -> int | None:
        """Number of the process that has a lock; None where nobody has it."""
        lock = self.locks.get(path)
        return None if lock is None else lock.process.pid

    def tell(self, what: str) -> None:
        """Tell whoever listens that a process began or ended."""
        self.listen(what)

    def spawn(self, module: str, arguments: Sequence[str], log: Path) -> Child:
        """See `host.Processes.spawn`."""
        pid = FIRST_PID + len(self.processes)
        process = self.processes[pid] = SimulatedProcess(self, pid, module, log)
        log.touch()
        steps = self._mains[module](self._host_of(process), tuple(arguments))
        self.tell(f"{module.rpartition('.')[2]} is started")
        shortest_s, longest_s = self._timing.start_s
        start_s = shortest_s + (longest_s - shortest_s) * self.draw()
        self._begin(process, steps, self.now_ns + round(start_s * NS_PER_S))
        return process

    def signal(self, pid: int, number: int) -> None:
        """See `host.Processes.signal`; SIGKILL, SIGTERM, SIGSTOP and SIGCONT have an effect."""
        process = self.processes[pid]
        if process.status is not None:
            return
        if number == signal.SIGKILL:
            process.end(KILLED)
        elif number == signal.SIGTERM:
            process.terminations += 1
        elif number == signal.SIGSTOP:
            process.frozen_until_ns = NEVER_NS
        elif number == signal.SIGCONT:
            process.frozen_until_ns = self.now_ns
            for activity in process.activities:
                if activity.due_ns is not None:
                    self.queue_at(activity, max(activity.due_ns, self.now_ns))

    def freeze(self, pid: int, seconds: float) -> None:
        """Keep a process from its steps for a time."""
        process = self.processes[pid]
        ends_ns = self.now_ns + round(seconds * NS_PER_S)
        process.frozen_until_ns = max(process.frozen_until_ns, ends_ns)

    def deliver(self, inbox: SimulatedInbox, data: bytes) -> None:
        """Bring a datagram to where it is sent, or not, or later, or twice (`mail`)."""
        drawn, mail = self.draw(), self.mail
        if self.now_ns >= mail.until_ns:
            inbox.waiting.append(data)
            return
        if drawn < mail.lost:
            return
        inbox.waiting.append(data)
        if drawn < mail.lost + mail.twice:
            inbox.waiting.append(data)
        elif drawn < mail.lost + mail.twice + mail.late:
            inbox.waiting.pop()
            late_s = self.draw() * mail.late_s
            self.at(self.now_ns + round(late_s * NS_PER_S), lambda: inbox.waiting.append(data))

    def at(self, due_ns: int, what: Callable[[], object]) -> None:
        """Have something done at an instant, between two steps."""
        self._number += 1
        heapq.heappush(self._queue, (due_ns, self._number, what))

    def run_until(self, ends_ns: int) -> None:
        """Do all steps that are due until an instant, in their order."""
        while self._queue and self._queue[0][0] <= ends_ns:
            due_ns, number, activity = heapq.heappop(self._queue)
            if not isinstance(activity, Activity):
                self.now_ns = max(self.now_ns, due_ns)
                activity()
                continue
            process = activity.process
            if process.status is not None or number != activity.number:
                continue
            free_ns = max(process.frozen_until_ns, process.busy_until_ns, activity.busy_until_ns)
            if free_ns > due_ns:
                self.queue_at(activity, free_ns)
                continue
            self.now_ns = max(self.now_ns, due_ns)
            if self.stretches is None or not self.stretches.play(activity, ends_ns):
                self._step(activity)
        self.now_ns = max(self.now_ns, ends_ns)

    def close(self) -> None:
        """Let go of all that its processes have open, as a system does when they end."""
        for process in self.processes.values():
            for activity in process.activities:
                activity.work.close()
            process.close_files()
        self.processes.clear()
        self._queue.clear()
        # Nobody has closed the file of a process that was killed.
        with warnings.catch_warnings(action="ignore"):
            gc.collect()

    def schedule(self, activity: Activity, due_ns: int) -> None:
        """Have an activity go on at an instant, where it was not to do so before."""
        if activity.has_ended or (activity.due_ns is not None and activity.due_ns <= due_ns):
            return
        activity.due_ns = due_ns
        late_ns = round(self.draw() * self._timing.late_s * NS_PER_S)
        self.queue_at(activity, max(due_ns, self.now_ns) + late_ns)

    def queue_at(self, activity: Activity, at_ns: int) -> None:
        """Have an activity go on at an instant, whatever else it was to do."""
        self._number += 1
        activity.number = self._number
        heapq.heappush(self._queue, (at_ns, self._number, activity))

    def _note(self, steps: bytes) -> None:
        self.trace.update(steps)
        self.steps += len(steps) // STEP.size

    def pass_by(self, at_ns: npt.NDArray[np.int64], pids: npt.NDArray[np.int64]) -> None:
        """Note steps that were done elsewhere; each has taken its random numbers."""
        noted = np.empty(len(at_ns), STEPS)
        noted["at_ns"], noted["pid"] = at_ns, pids
        self._note(noted.tobytes())
        self._used += paired_ticks.DRAWS * len(at_ns)
        begun_ns, whose = at_ns.tolist(), pids.tolist()
        self.now_ns = begun_ns[-1]
        for pid in set(whose):
            module = self.processes[pid].module
            self.watch_passed(Step(begun_ns[whose.index(pid)], pid, module))
            self.watch_passed(Step(begun_ns[-1 - whose[::-1].index(pid)], pid, module))

    def take_second(self, pair: Pair) -> tuple[int, int] | None:
        """Instants at which the second of a pair begins its next step, and anybody else is due.

        It is taken out of the queue; None, and it is not, where somebody else is due before.
        """
        second_ns = None
        while self._queue:
            at_ns, number, activity = entry = self._queue[0]
            if isinstance(activity, Activity):
                is_over = activity.process.status is not None or number != activity.number
                if is_over or activity is pair.second:
                    heapq.heappop(self._queue)
                    if not is_over:
                        second_ns, self._taken = at_ns, entry
                    continue
            return None if second_ns is None else (second_ns, at_ns)
        return None if second_ns is None else (second_ns, NEVER_NS)

    def next_due_ns(self) -> int:
        """Instant at which anybody is due."""
        while self._queue:
            at_ns, number, activity = self._queue[0]
            if not isinstance(activity, Activity):
                return at_ns
            if activity.process.status is None and number == activity.number:
                return at_ns
            heapq.heappop(self._queue)
        return NEVER_NS

    def put_back(self) -> None:
        """Put what was taken last into the queue again, in its old place."""
        assert self._taken is not None
        heapq.heappush(self._queue, self._taken)

    def _begin(self, process: SimulatedProcess, work: Steps[None] | Work, due_ns: int) -> Activity:
        activity = Activity(process, work)
        process.activities.append(activity)
        self.schedule(activity, due_ns)
        return activity

    def _step(self, activity: Activity) -> None:
        process, activity.due_ns = activity.process, None
        self.watch(Step(self.now_ns, process.pid, process.module))
        self._note(STEP.pack(self.now_ns, process.pid))
        if process.status is not None or process.frozen_until_ns > self.now_ns:
            self.queue_at(activity, process.frozen_until_ns)  # it has just been struck
            return
        most_s = self._timing.step_s * (SLOW if self.now_ns < self.slow_until_ns else 1)
        takes_ns = round(self.draw() * most_s * NS_PER_S)
        process.busy_until_ns = self.now_ns + takes_ns
        self.running = activity
        try:
            due_ns = next(activity.work)
        except StopIteration:
            activity.has_ended = True
            if activity is process.activities[0]:
                process.end(0)
        except ProcessDiedError:
            activity.has_ended = True
        except InputError as problem:
            process.error = problem
            process.say(str(problem))
            process.end(1)
        except Exception as error:
            process.error = error
            place = traceback.extract_tb(error.__traceback__)[-1]
            self.crashes.append(
                f"{process.module}: {type(error).__name__}: {error} ({place.name}:{place.lineno})"
            )
            process.say(f"{type(error).__name__}: {error}")
            process.end(1)
        else:
            if due_ns is not None:
                self.schedule(activity, due_ns)

    def _host_of(self, process: SimulatedProcess) -> Host:
        def begin_worker(work: Work) -> Worker:
            return SimulatedWorker(self, self._begin(process, work, self.now_ns))

        return Host(
            clock=SimulatedClock(self),
            locks=SimulatedLocks(process),
            processes=SimulatedProcesses(self),
            datagrams=SimulatedDatagrams(process),
            files=SimulatedFiles(self.disk, process),
            token=self._tokens.randbytes,
            begin_worker=begin_worker,
            hardened=_not_hardened,
            say=process.say,
            terminations=lambda: process.terminations,
        )
