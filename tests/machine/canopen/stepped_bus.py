"""A bus in memory and a clock that a test steps, for whoever is on a CANopen bus in one process."""

from collections import deque
from collections.abc import Iterable, Sequence
from contextlib import nullcontext

from opensuction.host.host import NS_PER_S, Allowed, Host
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.machine.canopen.frame_bus import CanFrame


class SteppedClock:
    """A clock that stands still between steps."""

    def __init__(self) -> None:
        self.now_ns = NS_PER_S

    def monotonic_ns(self) -> int:
        return self.now_ns

    def wall_ns(self) -> int:
        return self.now_ns

    def sleep_until(self, due_ns: int) -> None:
        self.now_ns = max(self.now_ns, due_ns)


def stepped_host(clock: SteppedClock) -> Host:
    """This computer with a clock of its own.

    The tests' own process is not hardened: its memory would stay locked, and a later test that
    gives up its rights could map no file any more.
    """
    return THIS_COMPUTER._replace(
        clock=clock, hardened=lambda: nullcontext(Allowed("stepped", False, ()))
    )


class MemoryBus:
    """A participant of a wire in memory, who sees every other one's frames."""

    def __init__(self, wire: "Wire") -> None:
        self._wire = wire
        self.waiting: deque[CanFrame] = deque()

    def send(self, frames: Sequence[CanFrame]) -> None:
        self._wire.carry(self, frames)

    def receive(self) -> Iterable[CanFrame]:
        while self.waiting:
            yield self.waiting.popleft()

    def close(self) -> None:
        self._wire.participants.remove(self)


class Wire:
    """What participants are joined by; keeps all that was sent."""

    def __init__(self) -> None:
        self.participants: list[MemoryBus] = []
        self.sent: list[CanFrame] = []

    def join(self) -> MemoryBus:
        participant = MemoryBus(self)
        self.participants.append(participant)
        return participant

    def carry(self, sender: MemoryBus, frames: Sequence[CanFrame]) -> None:
        self.sent += frames
        for one in self.participants:
            if one is not sender:
                one.waiting.extend(frames)
