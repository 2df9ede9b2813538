"""The recorder as a process: ``python -m opensuction.runtime.recorder_process DIR OUT``.

It reads what the control loop publishes in DIR and writes recordings to OUT. Where a controller
died it takes what that left in its ring, and goes on with the next one. Its sign of life is missing
while rows are not kept, so that the controller raises the alarm.
"""

import signal
import sys
import time
from pathlib import Path

import numpy as np

from opensuction.controller import configuration
from opensuction.exchange.event_ring import Event, EventReader
from opensuction.exchange.heartbeat import Heartbeat, Process
from opensuction.exchange.ring import Read, RingReader
from opensuction.kernel import arithmetic_fingerprint
from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file.heading import NOTICE, Heading
from opensuction.runtime.control_process import CONFIGURATION, EVENTS, RING, STARTED_FROM
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.recorder import Recorder

EVERY_S = 0.02
"""How often it looks: well before the ring of 10 s comes round."""
QUIET_S = 0.5
"""Without rows for longer than this the controller may be another one by now."""


class Source:
    """The ring and the events of the controller that runs, or ran last."""

    def __init__(self, folder: Path) -> None:
        """Raises InputError where there is none yet, or one of another version."""
        self._folder = folder
        self._inode = (folder / RING).stat().st_ino
        self._rows, self._events = RingReader(folder / RING), EventReader(folder / EVENTS)
        if self._rows.facts.columns != ROW_COLUMNS:
            raise InputError(f"{folder / RING} is of another version of the controller")
        told = self._rows.facts.told
        self.version = told["version"]
        self.started_from = np.frombuffer(bytes.fromhex(told[STARTED_FROM]))

    def read(self) -> tuple[Read, list[Event]]:
        """What has come since the last call."""
        return self._rows.read(), self._events.read()[0]

    def drain(self) -> tuple[Read, list[Event]]:
        """All that a controller left that writes no more."""
        return self._rows.drain(), self._events.read()[0]

    def is_replaced(self) -> bool:
        """Whether another controller writes by now."""
        try:
            return (self._folder / RING).stat().st_ino != self._inode
        except OSError:
            return False


def _heading(folder: Path, version: str) -> Heading:
    """What recordings of this controller say of themselves."""
    text = (folder / CONFIGURATION).read_text(encoding="utf-8")
    chosen = configuration.from_json(text)
    return Heading(
        software_version=version,
        settings=configuration.to_json(chosen),
        settings_hash=configuration.hash_of(chosen),
        fingerprint=arithmetic_fingerprint.fingerprint(),
        began_ns=time.time_ns() - time.monotonic_ns(),
        about={"notice": NOTICE},
    )


def _wait_for(folder: Path, ending: list[int]) -> Source | None:
    """The controller, once there is one; None where the process is told to end before."""
    while not ending:
        try:
            return Source(folder)
        except (InputError, OSError):
            time.sleep(EVERY_S)
    return None


def serve(folder: Path, out: Path) -> None:
    """Record until the process is told to end. Raises InputError where it cannot begin."""
    ending: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"no recordings can be kept in {out}: {error}") from None
    heartbeat = Heartbeat(folder)
    while (source := _wait_for(folder, ending)) is not None:
        recorder = Recorder(out, _heading(folder, source.version), source.started_from)
        _follow(source, recorder, heartbeat, ending)
        found, happened = source.drain()
        recorder.take(found.rows, found.missed, happened)
        recorder.close()
        if ending:
            break
    heartbeat.end(Process.RECORDER)


def _follow(source: Source, recorder: Recorder, heartbeat: Heartbeat, ending: list[int]) -> None:
    """Record what one controller publishes, until it is replaced or the process shall end."""
    came_s = time.monotonic()
    while not ending:
        found, happened = source.read()
        recorder.take(found.rows, found.missed, happened)
        if not recorder.lost:
            heartbeat.beat(Process.RECORDER)
        now_s = time.monotonic()
        if len(found.rows):
            came_s = now_s
        elif now_s - came_s > QUIET_S and source.is_replaced():
            return
        time.sleep(EVERY_S)


if __name__ == "__main__":
    try:
        serve(Path(sys.argv[1]), Path(sys.argv[2]))
    except InputError as problem:
        sys.exit(f"opensuction: {problem}")
