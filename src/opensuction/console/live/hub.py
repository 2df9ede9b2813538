"""The machine's newest row, as a state for all who look: worked out once, not once a page.

Nothing here waits: neither for the control loop, which does not know of it, nor for the records.
"""

import json
import logging
import threading
import time
from pathlib import Path
from typing import NamedTuple

from opensuction.console.live import state
from opensuction.console.live.state import Seen, State
from opensuction.controller import configuration
from opensuction.controller.configuration import Configuration
from opensuction.ipc.followed_ring import FollowedRing
from opensuction.ipc.heartbeat import FILE, Heartbeat
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.machine import port
from opensuction.machine.port import Description
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.paths import CONFIGURATION, RING

FRESH_S = 0.02
"""A state that is no older is given again."""
SILENT = Description(in_silico=True, capabilities=port.NOTHING)
"""Description of a machine that no controller has described yet."""
LOG = logging.getLogger("opensuction.console")


class SentState(NamedTuple):
    """A state, and the text that all pages are sent."""

    state: State
    text: str
    at_s: float


class Hub:
    """Of one machine's folder. May be asked by several threads."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.last_cycle: State | None = None
        """What is on record of the last cycle; whoever looks there says it here."""
        self._ring = FollowedRing(folder / RING, lambda columns: columns == ROW_COLUMNS)
        self._lock = threading.RLock()
        self._heartbeat: Heartbeat | None = None
        self._beats = self._written = (0, 0)
        self._configuration: Configuration | None = None
        self._told: SentState | None = None
        self._said = ""

    def newest(self) -> tuple[int, Array] | None:
        """The newest row with its number; None where no controller has written any."""
        with self._lock:
            self._ring.look()
            reader = self._ring.reader
            return None if reader is None else reader.snapshot()

    def machine(self) -> Description:
        """The machine as its controller describes it; without a controller nothing is claimed.

        Raises InputError for what is no description.
        """
        with self._lock:
            self._ring.look()
            reader = self._ring.reader
            return SILENT if reader is None else port.read_description(reader.facts.told)

    def configuration(self) -> Configuration:
        """Present configuration of the controller. Raises InputError where there is none."""
        path = self.folder / CONFIGURATION
        with self._lock:
            written = _stamp(path)
            if self._configuration is None or written != self._written:
                try:
                    text = path.read_text(encoding="utf-8")
                except (OSError, UnicodeDecodeError) as error:
                    raise InputError(f"no machine is set up in {self.folder}: {error}") from None
                self._configuration, self._written = configuration.from_json(text), written
            return self._configuration

    def now(self) -> SentState:
        """Present state of the machine."""
        with self._lock:
            told = self._told
            if told is None or time.monotonic() - told.at_s > FRESH_S:
                told = self._told = self._tell()
            return told

    def state(self) -> State:
        """The same, without its text."""
        return self.now().state

    def _tell(self) -> SentState:
        try:
            found = state.tell(self._see(), self._look_at_beats(), self.last_cycle)
            text = json.dumps(found, allow_nan=False, separators=(",", ":"))
            self._said = ""
        except (InputError, ValueError, KeyError) as error:
            # Of what cannot be understood nothing is shown: it would look as if it were known.
            if self._said != str(error):
                self._said = str(error)
                LOG.error("the machine's state cannot be told: %s", error)
            found = state.tell(None, None, self.last_cycle)
            text = json.dumps(found, allow_nan=False, separators=(",", ":"))
        return SentState(found, text, time.monotonic())

    def _see(self) -> Seen | None:
        newest = self.newest()
        reader = self._ring.reader
        if newest is None or reader is None:
            return None
        number, values = newest
        return Seen(
            number=number,
            values=values,
            began_utc_ns=int(reader.facts.told["began_utc_ns"]),
            settings=self.configuration().settings,
            age_s=time.monotonic() - float(values[0]),
        )

    def _look_at_beats(self) -> Heartbeat | None:
        """The signs of life; the file is another one where the folder was cleared meanwhile."""
        beats = _stamp(self.folder / FILE)[:1]
        if beats == (0,):
            return None
        if self._heartbeat is None or beats != self._beats[:1]:
            self._heartbeat, self._beats = Heartbeat(self.folder), (beats[0], 0)
        return self._heartbeat


def _stamp(path: Path) -> tuple[int, int]:
    """Inode and modification time of a file; zeros where there is none."""
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_ino, found.st_mtime_ns
