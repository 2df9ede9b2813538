"""One process that is looked after: started, found again, missed, replaced."""

import os
import signal
import subprocess
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

from opensuction.ipc.heartbeat import Heartbeat, Process
from opensuction.ipc.process_lock import holder
from opensuction.runtime import launch

HUNG_S = 3.0
"""Without a sign of life for longer than this it does nothing any more, and is ended. The rings
keep what comes meanwhile, for longer than that and another start take; a machine that is busy may
keep a process of the ordinary class waiting for a second."""
TRIES = 5
"""So often it is replaced within `TRIES_S`; after that somebody has to look."""
TRIES_S = 60.0
NS_PER_S = 1e9


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
    ) -> None:
        """module: its name. lock: what it holds. life: which sign it gives.

        awaited: signs that the controller waits for from its start on, and for how long
        (`absence.STARTS_S`).
        """
        self.module, self._hung_s, self._awaited = module, hung_s, awaited
        self.folder, self._lock, self._life, self._arguments = folder, lock, life, arguments
        self._heartbeat = Heartbeat(folder)
        self._process: subprocess.Popen[bytes] | None = None
        self._pid: int | None = None
        self._begun_s = 0.0
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
        self._pid = holder(self._lock)
        if self._pid is not None:
            self._begun_s, self.was_found = time.monotonic(), True
            self._has_worked = self._heartbeat.is_expected(self._life)
            return f"{self.title}-found"
        self._start()
        return f"{self.title}-started"

    def _start(self) -> None:
        for process in self._awaited:
            self._heartbeat.start(process)
        self._has_worked = self.was_found = False
        self._process = launch.spawn(self.folder, self.module, *self._arguments)
        self._pid, self._begun_s = self._process.pid, time.monotonic()
        self._tried.append(self._begun_s)

    def is_alive(self) -> bool:
        """True while there is such a process."""
        if self._process is not None:
            return self._process.poll() is None
        return self._pid is not None and holder(self._lock) == self._pid

    def works(self) -> bool:
        """True once it has given a sign of life since it was begun."""
        since_s = time.monotonic() - self._begun_s
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
        now_s = time.monotonic()
        if len(self._tried) == TRIES and now_s - self._tried[0] < TRIES_S:
            self.given_up = True
            return f"{self.title}-given-up", f"{TRIES} died within {TRIES_S:g} s: {words}"
        self._start()
        return f"{self.title}-restarted", words

    def _end_when_hung(self) -> None:
        self._has_worked = self._has_worked or self.works()
        if self._has_worked and not self._heartbeat.is_expected(self._life):
            return  # it has been told to end, and does
        running_s = time.monotonic() - self._begun_s
        allowed_s = self._hung_s if self._has_worked else launch.BEGINS_S
        if running_s > allowed_s and self._heartbeat.age_s(self._life) > allowed_s:
            self._signal(signal.SIGKILL)

    def end(self, seconds: float, meanwhile: Callable[[], None]) -> bool:
        """Have it end as it should; whether it did within that time. Then it is left alone."""
        self._signal(signal.SIGTERM)
        ends_s = time.monotonic() + seconds
        while self.is_alive():
            if time.monotonic() > ends_s:
                return False
            meanwhile()
            time.sleep(launch.LOOKS_S)
        return True

    def _signal(self, number: signal.Signals) -> None:
        if self._pid is not None and self.is_alive():
            os.kill(self._pid, number)
