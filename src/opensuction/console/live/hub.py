"""The machine's newest row, as a state for all who look: worked out once, not once a page."""

import threading
import time
from pathlib import Path
from typing import Any

from opensuction.exchange.followed_ring import FollowedRing
from opensuction.kernel.record import Array
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.room import RING


class Hub:
    """Of one machine's folder. May be asked by several threads."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._ring = FollowedRing(folder / RING, lambda columns: columns == ROW_COLUMNS)
        self._lock = threading.Lock()

    def newest(self) -> tuple[int, Array] | None:
        """The newest row with its number; None where no controller has written any."""
        with self._lock:
            self._ring.look()
            reader = self._ring.reader
            return None if reader is None else reader.snapshot()

    def age_s(self) -> float | None:
        """Since the newest row's tick was due."""
        newest = self.newest()
        return None if newest is None else time.monotonic() - float(newest[1][0])

    def state(self) -> dict[str, Any]:
        """What the machine is now."""
        newest = self.newest()
        return {"number": 0 if newest is None else newest[0]}
