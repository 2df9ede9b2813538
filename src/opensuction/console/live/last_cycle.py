"""Outcome of the last cycle on record, looked up when the machine has come to rest."""

import threading
from collections.abc import Callable
from typing import Any

from opensuction.console.live import abort_reason
from opensuction.console.live.hub import Hub
from opensuction.kernel.errors import InputError
from opensuction.kernel.name import name_of
from opensuction.kernel.phase import RESTING
from opensuction.records.records import Records
from opensuction.runtime.machine_identity import About

LOOKS_S = 0.5
AGAIN = 20
"""In so many looks the records are asked anyway: they are written a little after the row."""
SOON = 4
"""Looks after a cycle in which its end may not be on record yet."""
REST = frozenset(name_of(phase) for phase in RESTING)


class LastCycle:
    """Looks in a thread of its own, for a database may be slow."""

    def __init__(self, hub: Hub, records: Records, about: Callable[[], About]) -> None:
        self._hub, self._records, self._about = hub, records, about
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True, name="last cycle")
        self._count = 0

    def begin(self) -> None:
        """Look from now on."""
        self._thread.start()

    def end(self) -> None:
        """Look no more."""
        self._is_over.set()
        self._thread.join()

    def _run(self) -> None:
        while True:
            self.look()
            if self._is_over.wait(LOOKS_S):
                return

    def look(self) -> None:
        """Once, if it is time."""
        if self._hub.state()["phase"] not in REST:
            self._count = 0
            return
        if self._count < SOON or self._count % AGAIN == 0:
            try:
                self._hub.last_cycle = self._find()
            except InputError:
                self._hub.last_cycle = None  # not known is better than that of before
        self._count += 1

    def _find(self) -> dict[str, Any] | None:
        past = self._records.history.list_cycles(self._about().machine.serial, 1)
        if not past:
            return None
        one = past[0]
        return {
            "id": one.id,
            "number": one.number,
            "outcome": None if one.outcome is None else str(one.outcome),
            "detail": one.detail,
            "why": abort_reason.say(one.detail),
            "inside_at_end": one.inside_at_end,
            "requested_by": one.requested_by,
            "started_at": one.started_at.isoformat(),
            "ended_at": None if one.ended_at is None else one.ended_at.isoformat(),
        }
