"""A computer that a seed drives: its clocks, its scheduler, and the processes that run on it.

The processes are the real ones (`host.Steps`), all in one thread. Each step begins when it is due
and a drawn delay later, and takes a drawn time in which its process does nothing else. A process
that is killed does not do another step, and lets go of what the system holds for it; one that is
frozen comes to its steps late. The same seed gives the same order of steps.
"""

import gc
import heapq
import random
import signal
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from opensuction.evidence.lives.simulated_disk import SimulatedDisk, SimulatedFiles
from opensuction.evidence.lives.simulated_process import (
    KILLED,
    Activity,
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

Main = Callable[[Host, tuple[str, ...]], Steps[None]]
"""A process: takes its computer and its arguments."""
FIRST_PID = 1000
BEGAN_WALL_NS = 1_750_000_000 * NS_PER_S
"""UTC at the monotonic clock's zero: nothing is special about it."""
SLOW = 20
NEVER_NS = 1 << 62


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
        """Told of each step before it is done."""
        self.listen: Callable[[str], None] = lambda _: None
        """Told of each process that begins or ends."""
        self.disk = SimulatedDisk(self, seed)
        self.mail = MailShares()
        self.slow_until_ns = 0
        """Other work takes the processors until then: a step takes up to `SLOW` times as long."""
        self._mains, self._timing = mains, timing
        self._chance, self._tokens = random.Random(seed), random.Random(seed + 1)
        self._queue: list[tuple[int, int, Activity | Callable[[], object]]] = []
        self._number = 0

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
        start_s = self._chance.uniform(*self._timing.start_s)
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
                    self._queue_at(activity, max(activity.due_ns, self.now_ns))

    def freeze(self, pid: int, seconds: float) -> None:
        """Keep a process from its steps for a time."""
        process = self.processes[pid]
        ends_ns = self.now_ns + round(seconds * NS_PER_S)
        process.frozen_until_ns = max(process.frozen_until_ns, ends_ns)

    def deliver(self, inbox: SimulatedInbox, data: bytes) -> None:
        """Bring a datagram to where it is sent, or not, or later, or twice (`mail`)."""
        drawn, mail = self._chance.random(), self.mail
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
            late_s = self._chance.random() * mail.late_s
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
            free_ns = max(process.frozen_until_ns, process.busy_until_ns)
            if free_ns > due_ns:
                self._queue_at(activity, free_ns)
                continue
            self.now_ns = max(self.now_ns, due_ns)
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
        late_ns = round(self._chance.random() * self._timing.late_s * NS_PER_S)
        self._queue_at(activity, max(due_ns, self.now_ns) + late_ns)

    def _queue_at(self, activity: Activity, at_ns: int) -> None:
        self._number += 1
        activity.number = self._number
        heapq.heappush(self._queue, (at_ns, self._number, activity))

    def _begin(self, process: SimulatedProcess, work: Steps[None] | Work, due_ns: int) -> Activity:
        activity = Activity(process, work)
        process.activities.append(activity)
        self.schedule(activity, due_ns)
        return activity

    def _step(self, activity: Activity) -> None:
        process, activity.due_ns = activity.process, None
        self.watch(Step(self.now_ns, process.pid, process.module))
        if process.status is not None or process.frozen_until_ns > self.now_ns:
            self._queue_at(activity, process.frozen_until_ns)  # it has just been struck
            return
        most_s = self._timing.step_s * (SLOW if self.now_ns < self.slow_until_ns else 1)
        takes_ns = round(self._chance.random() * most_s * NS_PER_S)
        process.busy_until_ns = self.now_ns + takes_ns
        try:
            due_ns = next(activity.work)
        except StopIteration:
            activity.has_ended = True
            if activity is process.activities[0]:
                process.end(0)
        except InputError as problem:
            process.say(str(problem))
            process.end(1)
        except Exception as error:
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
