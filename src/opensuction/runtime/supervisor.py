"""Starts a machine's controller, recorder and console, misses them, replaces them.

There is one for each machine. A controller that is replaced never goes on where the other was: it
finds out where the catheter is, brings it out, says so, and waits for a person. The supervisor's
own death changes nothing but that people are told of it; the next one finds what runs.

``python -m opensuction.runtime.supervisor DIR OUT`` does so for a machine that is set up in DIR,
until it is told to end.
"""

import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, Self

from opensuction.ipc.event_ring import EventWriter
from opensuction.ipc.heartbeat import Heartbeat, Process
from opensuction.ipc.process_lock import ProcessLock
from opensuction.kernel.errors import InputError
from opensuction.runtime import launch
from opensuction.runtime.absence import MISSED_S
from opensuction.runtime.control_process import PERIOD_NS
from opensuction.runtime.paths import (
    CONSOLE,
    CONSOLE_ENDS_S,
    CONSOLES,
    CONTROLS,
    RECORDS,
    SUPERVISES,
    WATCH_EVENTS,
    WATCH_EVENTS_BEFORE,
)
from opensuction.runtime.supervised_process import SupervisedProcess

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

    def __init__(self, folder: Path, out: Path, period_ns: int = PERIOD_NS) -> None:
        """folder: the machine's; where it says what a console is set to, there is one, too.

        out: of its recordings. Raises InputError where another one supervises it.
        """
        self._lock = ProcessLock(folder / SUPERVISES, "a supervisor runs")
        self._events = EventWriter(folder / WATCH_EVENTS, folder / WATCH_EVENTS_BEFORE)
        self._heartbeat = Heartbeat(folder)
        self._number, self._silent_looks, self._keeps_nothing = 0, 0, False
        self._run = f"{time.strftime('%Y%m%dT%H%M%S', time.gmtime())}-{time.monotonic_ns():x}"
        self.recorder = SupervisedProcess(
            folder,
            launch.RECORDER,
            folder / RECORDS,
            Process.RECORDER,
            (str(out),),
            awaited=(Process.RECORDER, Process.KEEPING),
        )
        self.control = SupervisedProcess(
            folder,
            launch.CONTROL,
            folder / CONTROLS,
            Process.CONTROL,
            (str(period_ns),),
            CONTROL_HUNG_S,
        )
        self.console: SupervisedProcess | None = None
        if (folder / CONSOLE).exists():
            self.console = SupervisedProcess(
                folder, launch.CONSOLE, folder / CONSOLES, Process.CONSOLE, (), CONSOLE_HUNG_S
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
        """Start or find them; returns once they work. Raises InputError where they do not.

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
                    self.end()
                    raise InputError(f"the {process.title} does not run: {words}")
                if (done := process.look()) is not None:
                    tell(self._note(*done))
            time.sleep(LOOKS_S)

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
        """End them in order; whether they did. The catheter comes out first."""

        def wait() -> None:
            self._heartbeat.beat(Process.SUPERVISOR)
            meanwhile()

        ended = self.control.end(COMES_OUT_S, wait)
        if self.console is not None:
            ended &= self.console.end(CONSOLE_ENDS_S, wait)
        ended &= self.recorder.end(WRITES_S, wait)
        self._heartbeat.end(Process.SUPERVISOR)
        return ended

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._events.close()
        self._lock.close()


def serve(folder: Path, out: Path) -> None:
    """Supervise until the process is told to end. Raises InputError where it cannot begin."""
    ending: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
    with Supervisor(folder, out) as supervisor:
        supervisor.begin()
        while not ending:
            supervisor.look()
            time.sleep(LOOKS_S)
        supervisor.end()


if __name__ == "__main__":
    try:
        serve(Path(sys.argv[1]), Path(sys.argv[2]))
    except InputError as problem:
        sys.exit(f"opensuction: {problem}")
