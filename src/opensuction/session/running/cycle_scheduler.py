"""Automatic starts of cycles on a running machine, by the clock, with the actions of its attendant.

On the twin the attendant is simulated: looks at the patient when that is due, gives oxygen, presses
start. A cycle that did not end as planned needs a real person: no other is started.
"""

import time
from collections.abc import Callable
from datetime import datetime
from enum import Enum, auto
from typing import NamedTuple
from uuid import uuid4

from opensuction.ipc.mailbox import Sender
from opensuction.ipc.ring import FollowedRing
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.procedure.cycle import lock_out
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.records.database import utc_time
from opensuction.report import wording
from opensuction.runtime import machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.session.cycle import resolution
from opensuction.session.running.machine import Running

WHO = "opensuction run"
"""Who asks, on record."""
BUTTON_S = 0.05
"""Between two buttons."""
ANSWERS_S = 1.0
"""Within this time after its button a cycle has begun, or was refused."""


class Doing(Enum):
    """State of the scheduler."""

    WAITING = auto()
    """For the next start."""
    OXYGENATING = auto()
    STARTING = auto()
    """The button is down."""
    RUNNING = auto()
    DONE = auto()


class Now(NamedTuple):
    """State of the machine by its newest row."""

    phase: Phase
    tick: int
    refusal: int
    passes: int
    rest_left_s: float
    """Until the patient has rested enough after the last pass."""


_COLUMNS = [
    ROW_COLUMNS.index(name)
    for name in (
        "outputs.phase",
        "inputs.tick",
        "outputs.counters.refusal",
        "outputs.counters.passes",
        "outputs.counters.rest_left_s",
    )
]


def _read(ring: FollowedRing) -> Now | None:
    """State of the machine by its newest row; None where no controller writes one."""
    ring.look()
    newest = None if ring.reader is None else ring.reader.snapshot()
    if newest is None:
        return None
    *numbers, rest_left_s = (float(newest[1][column]) for column in _COLUMNS)
    phase, tick, refused, passes = map(int, numbers)
    return Now(Phase(phase), tick, refused, passes, rest_left_s)


class CycleScheduler:
    """Cycles one after the other."""

    def __init__(
        self, running: Running, cycles: int, every_s: float, tell: Callable[[str], None]
    ) -> None:
        """every_s: from start to start. tell: takes a line of what goes on."""
        self._running, self._left, self._every_s, self._tell = running, cycles, every_s, tell
        self._ring = FollowedRing(
            running.folder / machine_folder.RING, lambda names: names == ROW_COLUMNS
        )
        self._sender = Sender(running.folder / machine_folder.ASK, WHO)
        self._rule = running.prepared.loop.controller.service.passes
        self.doing = Doing.WAITING
        self.reason = ""
        """Why no other cycle is started, though one was wanted; empty where all is well."""
        self._next_s = time.monotonic() + (self._oxygen_s if cycles else 0.0)
        self._since_s = 0.0
        self._phase: Phase | None = None

    @property
    def _oxygen_s(self) -> float:
        chosen = self._running.prepared.resolved.choice.preoxygenation
        return resolution.lead_s(self._running.prepared.loop, chosen)

    def close(self) -> None:
        """Ask no more."""
        self._sender.close()

    def stop(self, reason: str) -> None:
        """Start no other cycle."""
        self.doing, self.reason = Doing.DONE, self.reason or reason

    def look(self) -> None:
        """See how far things are, and do what is due; to be called every 50 ms or so."""
        now = _read(self._ring)
        if now is None:
            return
        if now.phase != self._phase:
            self._phase = now.phase
            words = wording.phase_words(now.phase.name.lower()).label
            self._tell(f"{datetime.now().astimezone():%H:%M:%S}  {words}")
        step = {
            Doing.WAITING: self._wait,
            Doing.OXYGENATING: self._oxygenate,
            Doing.STARTING: self._start,
            Doing.RUNNING: self._run,
        }.get(self.doing)
        if step is not None:
            step(now, time.monotonic())

    def _wait(self, now: Now, now_s: float) -> None:
        if now.phase == Phase.HALTED:
            self.stop("the machine has halted: a person has to look at patient and machine")
        elif self._left == 0:
            self.doing = Doing.DONE
        elif now_s >= self._next_s - self._oxygen_s and self._is_ready(now):
            if now.passes >= self._rule.most_passes:
                self._press("assessed")
            self.doing, self._since_s = Doing.OXYGENATING, now_s
            if self._oxygen_s:
                self._running.ventilate(full=True)
                self._tell(f"100 % oxygen for {self._oxygen_s:g} s")

    def _is_ready(self, now: Now) -> bool:
        return now.phase == Phase.PARKED and now.rest_left_s <= self._oxygen_s

    def _oxygenate(self, _: Now, now_s: float) -> None:
        if now_s - self._since_s < self._oxygen_s:
            return
        if self._rule.asks_for_oxygen:
            self._press("oxygenated" if self._oxygen_s else "oxygen_skipped")
        self._press("start")
        self._left -= 1
        self._next_s = max(self._next_s, now_s) + self._every_s
        self.doing, self._since_s = Doing.STARTING, now_s

    def _start(self, now: Now, now_s: float) -> None:
        if now.phase not in RESTING:
            self.doing = Doing.RUNNING
        elif now_s - self._since_s > ANSWERS_S:
            refused = Refusal(now.refusal)
            reason = lock_out.say(refused, now.rest_left_s) if refused else "nobody took it"
            self.stop(f"the start was refused: {reason}")

    def _run(self, now: Now, _: float) -> None:
        if now.phase in RESTING:
            if self._oxygen_s:
                self._running.ventilate(full=False)
            self.doing = Doing.WAITING

    def _press(self, button: str) -> None:
        self._sender.ask(button, uuid4().hex, utc_time.now().isoformat())
        time.sleep(BUTTON_S)
