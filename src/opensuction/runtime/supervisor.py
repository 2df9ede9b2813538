"""Starts a machine's controller, recorder and console, misses them, replaces them.

There is one for each machine. A controller that is replaced never goes on where the other was: it
finds out where the catheter is, brings it out, says so, and waits for a person. The supervisor's
own death changes nothing but that people are told of it; the next one finds what runs.

``python -m opensuction.runtime.supervisor DIR OUT`` does so for a machine that is set up in DIR,
until it is told to end.

One process that is looked after: started, found again, missed, replaced.
"""

import math
import signal
import sys
from collections import deque
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple, Self

from opensuction.host import this_computer
from opensuction.host.host import NS_PER_S, Child, Host, Steps, after, finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.liveness import Heartbeat, Process, ProcessLock
from opensuction.ipc.ring import EventWriter
from opensuction.kernel.errors import InputError
from opensuction.runtime import launch
from opensuction.runtime.control_process import MACHINES_OWN
from opensuction.runtime.loop import MISSED_S
from opensuction.runtime.machine_folder import (
    CONSOLE,
    CONSOLE_ENDS_S,
    CONSOLES,
    CONTROLS,
    RECORDS,
    SUPERVISES,
    WATCH_EVENTS,
    WATCH_EVENTS_BEFORE,
)

HUNG_S = 3.0
"""Without a sign of life for longer than this it does nothing any more, and is ended. The rings
keep what comes meanwhile, for longer than that and another start take; a machine that is busy may
keep a process of the ordinary class waiting for a second."""
TRIES = 5
"""So often it is replaced within `TRIES_S`; after that somebody has to look."""
TRIES_S = 60.0


class SupervisedProcess:
    """A process of a machine's room."""

    def __init__(
        self,
        folder: Path,
        module: str,
        lock: Path,
        life: Process,
        arguments: tuple[str, ...],
        hung_s: float = HUNG_S,
        awaited: tuple[Process, ...] = (),
        host: Host = THIS_COMPUTER,
    ) -> None:
        """module: its name. lock: what it holds. life: which sign it gives.

        awaited: signs that the controller waits for from its start on, and for how long
        (`absence.STARTS_S`).
        """
        self.module, self._hung_s, self._awaited = module, hung_s, awaited
        self.folder, self._lock, self._life, self._arguments = folder, lock, life, arguments
        self._host, self._heartbeat = host, Heartbeat(folder, host)
        self._process: Child | None = None
        self._pid: int | None = None
        self._begun_s = 0.0
        self._looked_s, self._awake_s = -math.inf, 0.0
        """When it was looked for last, and since when it has been without a pause."""
        self._has_worked = False
        self.was_found = False
        """An earlier supervisor has started it: its death is no reason to end."""
        self._tried: deque[float] = deque(maxlen=TRIES)
        self.given_up = False
        """It has died too often."""

    @property
    def title(self) -> str:
        """As people call it."""
        return self.module.rpartition(".")[2].removesuffix("_process")

    @property
    def pid(self) -> int | None:
        """Number of the process; None where there is none."""
        return self._pid

    def last_words(self) -> str:
        """Reason why it died, as far as it could say so."""
        return launch.last_words(self.folder, self.module) or "it was killed or crashed"

    def begin(self) -> str:
        """Find the one that runs, or start one; what was done."""
        self._pid = self._host.locks.holder(self._lock)
        if self._pid is not None:
            self._begun_s, self.was_found = self._now_s(), True
            self._has_worked = self._heartbeat.is_expected(self._life)
            return f"{self.title}-found"
        self._start()
        return f"{self.title}-started"

    def _now_s(self) -> float:
        return self._host.clock.monotonic_ns() / NS_PER_S

    def _start(self) -> None:
        for process in self._awaited:
            self._heartbeat.start(process)
        self._has_worked = self.was_found = False
        self._process = launch.spawn(self.folder, self.module, *self._arguments, host=self._host)
        self._pid, self._begun_s = self._process.pid, self._now_s()
        self._tried.append(self._begun_s)

    def is_alive(self) -> bool:
        """True while there is such a process."""
        if self._process is not None:
            return self._process.poll() is None
        return self._pid is not None and self._host.locks.holder(self._lock) == self._pid

    def works(self) -> bool:
        """True once it has given a sign of life since it was begun."""
        since_s = self._now_s() - self._begun_s
        return self.is_alive() and self._heartbeat.age_s(self._life) < since_s

    def look(self) -> tuple[str, str] | None:
        """Replace it where that is needed; what was done, and why."""
        if self.given_up:
            return None
        if self.is_alive():
            self._end_when_hung()
            return None
        words = self.last_words()
        self._process = self._pid = None
        now_s = self._now_s()
        if len(self._tried) == TRIES and now_s - self._tried[0] < TRIES_S:
            self.given_up = True
            return f"{self.title}-given-up", f"{TRIES} died within {TRIES_S:g} s: {words}"
        self._start()
        return f"{self.title}-restarted", words

    def _end_when_hung(self) -> None:
        self._has_worked = self._has_worked or self.works()
        if self._has_worked and not self._heartbeat.is_expected(self._life):
            return  # it has been told to end, and does
        now_s = self._now_s()
        if now_s - self._looked_s > MISSED_S:
            self._awake_s = now_s  # the whole computer may have stood still: nobody was to answer
        self._looked_s = now_s
        watched_s = now_s - max(self._begun_s, self._awake_s)
        allowed_s = self._hung_s if self._has_worked else launch.BEGINS_S
        if watched_s > allowed_s and self._heartbeat.age_s(self._life) > allowed_s:
            self._signal(signal.SIGKILL)

    def end(self, seconds: float, meanwhile: Callable[[], None]) -> Steps[bool]:
        """Have it end as it should; true where it did within that time. Then it is left alone."""
        self._signal(signal.SIGTERM)
        clock, ends_ns = self._host.clock, after(self._host.clock, seconds)
        while self.is_alive():
            if clock.monotonic_ns() > ends_ns:
                return False
            meanwhile()
            yield after(clock, launch.LOOKS_S)
        return True

    def _signal(self, number: signal.Signals) -> None:
        if self._pid is not None and self.is_alive():
            self._host.processes.signal(self._pid, number)


LOOKS_S = 0.05
"""How often it looks: a tenth of the time after which it is missed itself."""
COMES_OUT_S = 120.0
"""How long the end of a controller may take: the catheter comes out first."""
WRITES_S = 20.0
"""How long the end of a recorder may take."""
CONTROL_HUNG_S, CONSOLE_HUNG_S = 1.0, 5.0
"""A console does many things that nobody waits for, and moves nothing."""


class SupervisorNotice(NamedTuple):
    """Something that it did."""

    what: str
    detail: str


class Supervisor:
    """Of one machine."""

    def __init__(
        self,
        folder: Path,
        out: Path,
        period_ns: int = MACHINES_OWN,
        host: Host = THIS_COMPUTER,
    ) -> None:
        """folder: the machine's; where it says what a console is set to, there is one, too.

        out: of its recordings. Raises InputError where another one supervises it.
        """
        self._clock = host.clock
        self._lock = ProcessLock(folder / SUPERVISES, "a supervisor runs", host)
        self._events = EventWriter(folder / WATCH_EVENTS, folder / WATCH_EVENTS_BEFORE, host)
        self._heartbeat = Heartbeat(folder, host)
        self._number, self._silent_looks, self._keeps_nothing = 0, 0, False
        began = datetime.fromtimestamp(host.clock.wall_ns() / NS_PER_S, tz=UTC)
        self._run = f"{began:%Y%m%dT%H%M%S}-{host.clock.monotonic_ns():x}"
        self.recorder = SupervisedProcess(
            folder,
            launch.RECORDER,
            folder / RECORDS,
            Process.RECORDER,
            (str(out),),
            awaited=(Process.RECORDER, Process.KEEPING),
            host=host,
        )
        self.control = SupervisedProcess(
            folder,
            launch.CONTROL,
            folder / CONTROLS,
            Process.CONTROL,
            (str(period_ns),),
            CONTROL_HUNG_S,
            host=host,
        )
        self.console: SupervisedProcess | None = None
        if (folder / CONSOLE).exists():
            self.console = SupervisedProcess(
                folder,
                launch.CONSOLE,
                folder / CONSOLES,
                Process.CONSOLE,
                (),
                CONSOLE_HUNG_S,
                host=host,
            )

    @property
    def _supervised(self) -> tuple[SupervisedProcess, ...]:
        """The most urgent first."""
        both = (self.control, self.recorder)
        return both if self.console is None else (*both, self.console)

    def begin(
        self,
        tell: Callable[[SupervisorNotice], None] = lambda _: None,
        meanwhile: Callable[[tuple[str, ...]], None] = lambda _: None,
    ) -> None:
        """Do `beginning` to its end, and sleep in between."""
        finish(self.beginning(tell, meanwhile), self._clock)

    def beginning(
        self,
        tell: Callable[[SupervisorNotice], None] = lambda _: None,
        meanwhile: Callable[[tuple[str, ...]], None] = lambda _: None,
    ) -> Steps[None]:
        """Start or find them, until they work. Raises InputError where they do not.

        One that is found and hung, or dies, is replaced as `look` does it.

        meanwhile: called at each look until then, with the titles of those that do not work yet.
        """
        self._heartbeat.begin(Process.SUPERVISOR)
        # At once: where one has died in a cycle, the catheter is looked for now.
        for process in self._supervised:
            tell(self._note(process.begin(), ""))
        while starting := tuple(
            process.title for process in self._supervised if not process.works()
        ):
            self._heartbeat.beat(Process.SUPERVISOR)
            meanwhile(starting)
            for process in self._supervised:
                if not (process.is_alive() or process.was_found):
                    words = process.last_words()
                    yield from self.ending()
                    raise InputError(f"the {process.title} does not run: {words}")
                if (done := process.look()) is not None:
                    tell(self._note(*done))
            yield after(self._clock, LOOKS_S)

    def look(self) -> list[SupervisorNotice]:
        """Give a sign of life and see to the others; to be called every `LOOKS_S`."""
        self._heartbeat.beat(Process.SUPERVISOR)
        done = [process.look() for process in self._supervised]
        told = [self._note(*one) for one in done if one is not None]
        return [*told, *self._look_at_keeping()]

    def _look_at_keeping(self) -> list[SupervisorNotice]:
        """Notice where the recorder can keep nothing: a disk may be full, a database gone."""
        since_s = self._heartbeat.age_s(Process.KEEPING)
        lives = self._heartbeat.age_s(Process.RECORDER) < MISSED_S
        silent = lives and since_s > MISSED_S and self._heartbeat.is_expected(Process.KEEPING)
        # One that has just begun comes to it in a moment.
        self._silent_looks = (self._silent_looks + 1) * silent
        if not self._keeps_nothing and self._silent_looks * LOOKS_S > MISSED_S:
            self._keeps_nothing = True
            words = self.recorder.last_words()
            return [self._note("recorder-keeps-nothing", words)]
        if self._keeps_nothing and since_s < MISSED_S:
            self._keeps_nothing = False
            return [self._note("recorder-keeps", "")]
        return []

    def _note(self, what: str, detail: str) -> SupervisorNotice:
        self._number += 1
        self._events.write("watch", 0, what=what, detail=detail, key=f"{self._run}-{self._number}")
        return SupervisorNotice(what, detail)

    def end(self, meanwhile: Callable[[], None] = lambda: None) -> bool:
        """Do `ending` to its end, and sleep in between."""
        return finish(self.ending(meanwhile), self._clock)

    def ending(self, meanwhile: Callable[[], None] = lambda: None) -> Steps[bool]:
        """End them in order; true where they did. The catheter comes out first."""

        def wait() -> None:
            self._heartbeat.beat(Process.SUPERVISOR)
            meanwhile()

        ended = yield from self.control.end(COMES_OUT_S, wait)
        if self.console is not None:
            ended &= yield from self.console.end(CONSOLE_ENDS_S, wait)
        ended &= yield from self.recorder.end(WRITES_S, wait)
        self._heartbeat.end(Process.SUPERVISOR)
        return ended

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._events.close()
        self._lock.close()


def steps(host: Host, folder: Path, out: Path) -> Steps[None]:
    """Supervise until the process is told to end. Raises InputError where it cannot begin."""
    with Supervisor(folder, out, host=host) as supervisor:
        yield from supervisor.beginning()
        while not host.terminations():
            supervisor.look()
            yield after(host.clock, LOOKS_S)
        yield from supervisor.ending()


if __name__ == "__main__":
    _folder, _out = map(Path, sys.argv[1:])
    this_computer.run(lambda host: steps(host, _folder, _out))
