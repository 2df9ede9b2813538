"""Transceiver of an emulated node: its frames pass here, and its faults on the bus are here.

All nodes of a process are on the bus by one `FrameBus`. What they send in a tick leaves together.
"""

from collections import deque
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import as_python
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import SYNC_ID

_FIRST_PDO, _LAST_PDO = 0x180, 0x57F
"""Identifiers of CiA 301's predefined connection set between which there are only PDOs."""


WIRE_PURPOSE: Final = 6_000_000
"""Streams from here on are the frames that a node's faults take, or double."""
_UNIFORM_PAIR = as_python(random_stream.uniform_pair)


class WireFaults(NamedTuple):
    """Faults of a node's connection to the bus."""

    is_off: bool = False
    """Nothing passes, in either direction."""
    pdo_lost_share: float = 0.0
    """Share of the frames of process data that get lost, in either direction."""
    repeated_share: float = 0.0
    """Share of all frames that come twice."""
    sync_late_ticks: int = 0
    """For how many ticks a SYNC is kept from it."""


SOUND: Final = WireFaults()


def is_pdo(can_id: int) -> bool:
    """True for an identifier of process data."""
    return _FIRST_PDO <= can_id <= _LAST_PDO


class Transceiver:
    """A node's access to the bus; a `FrameBus` on the node's side."""

    def __init__(self, seed: int) -> None:
        """seed: chance of frames that get lost or come twice."""
        self.faults = SOUND
        self.leaving: list[CanFrame] = []
        """Frames on the way out."""
        self._came: deque[CanFrame] = deque()
        self._late: deque[tuple[int, CanFrame]] = deque()
        self._tick = 0
        self._chance = random_stream.stream(seed, WIRE_PURPOSE)

    def bring(self, frames: Iterable[CanFrame]) -> None:
        """Frames from the bus, at the beginning of a tick."""
        self._tick += 1
        while self._late and self._late[0][0] <= self._tick:
            self._came.append(self._late.popleft()[1])
        for one in frames:
            for _ in range(self._copies(one)):
                if one.can_id == SYNC_ID and self.faults.sync_late_ticks:
                    self._late.append((self._tick + self.faults.sync_late_ticks, one))
                else:
                    self._came.append(one)

    @property
    def has_come(self) -> bool:
        """True while frames wait to be received."""
        return bool(self._came)

    def take_leaving(self) -> list[CanFrame]:
        """Frames that leave for the bus now."""
        leaving, self.leaving = self.leaving, []
        return leaving

    def send(self, frames: Sequence[CanFrame]) -> None:
        """See `FrameBus.send`."""
        for one in frames:
            self.leaving += [one] * self._copies(one)

    def receive(self) -> Iterable[CanFrame]:
        """See `FrameBus.receive`."""
        while self._came:
            yield self._came.popleft()

    def close(self) -> None:
        """See `FrameBus.close`."""

    def _copies(self, frame: CanFrame) -> int:
        """Times that a frame passes: once, or as the faults have it."""
        faults = self.faults
        if faults is SOUND:
            return 1
        if faults.is_off:
            return 0
        lost, repeated, self._chance = _UNIFORM_PAIR(self._chance)
        if is_pdo(frame.can_id) and lost < faults.pdo_lost_share:
            return 0
        return 2 if repeated < faults.repeated_share else 1
