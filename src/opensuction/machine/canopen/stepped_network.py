"""canopen's network without threads and without a clock of its own: it is stepped.

All that canopen has for SDO, NMT, emergencies and heartbeats is used as it is; frames go by a
`FrameBus`, and time is the host's. A request by SDO, which waits for its answer, steps the network
meanwhile.
"""

import queue
import struct
from collections.abc import Callable
from typing import Final

from opensuction.host.host import NS_PER_S, Clock, after
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen.frame_bus import NEEDS, CanFrame, FrameBus

try:
    import canopen
    from canopen import ObjectDictionary, RemoteNode
    from canopen.sdo.exceptions import SdoError
except ImportError:
    raise InputError(NEEDS) from None

LOOKS_S: Final = 0.0002
"""How often an answer that is waited for is looked for."""
_NONSENSE: Final = (struct.error, LookupError, ValueError, TypeError, SdoError)
"""Raised by what canopen does with a frame that holds what it should not."""


class PeriodicFrame:
    """A frame that is sent every so often; canopen's `PeriodicMessageTask` without its thread."""

    def __init__(self, frame: CanFrame, period_ns: int, due_ns: int) -> None:
        self.frame, self.period_ns, self.due_ns = frame, period_ns, due_ns
        self.is_stopped = False

    def update(self, data: bytes) -> None:
        """Send other data from now on."""
        self.frame = self.frame._replace(data=bytes(data))

    def stop(self) -> None:
        """Send it no more."""
        self.is_stopped = True


class SteppedNetwork(canopen.Network):
    """A network whose frames move when it is stepped."""

    def __init__(
        self, frames: FrameBus, clock: Clock, wait: Callable[[], None] | None = None
    ) -> None:
        """wait: called while an answer is waited for, to let others do something; else it sleeps.

        Frames that canopen could make nothing of are counted in `nonsense`.
        """
        super().__init__()
        self.frames, self.clock = frames, clock
        self.nonsense = 0
        self._wait = self._sleep if wait is None else wait
        self._periodic: list[PeriodicFrame] = []

    def step(self) -> int:
        """Take what has come, and send what is due; how many frames have come."""
        now_ns = self.clock.monotonic_ns()
        count = 0
        for can_id, data in self.frames.receive():
            count += 1
            try:
                self.notify(can_id, bytearray(data), now_ns / NS_PER_S)
            except _NONSENSE:
                self.nonsense += 1
        self._periodic = [one for one in self._periodic if not one.is_stopped]
        for one in self._periodic:
            if now_ns >= one.due_ns:
                # One that is late is sent once, not once for each time that was missed.
                missed = (now_ns - one.due_ns) // one.period_ns
                one.due_ns += (missed + 1) * one.period_ns
                self.frames.send([one.frame])
        return count

    def wait(self) -> None:
        """Let others do something, then take what has come."""
        self._wait()
        self.step()

    def _sleep(self) -> None:
        self.clock.sleep_until(after(self.clock, LOOKS_S))

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """See `canopen.Network.send_message`; there are no remote frames."""
        if not remote:
            self.frames.send([CanFrame(can_id, bytes(data))])

    def send_periodic(  # type: ignore[override]
        self, can_id: int, data: bytes, period: float, remote: bool = False
    ) -> PeriodicFrame:
        """See `canopen.Network.send_periodic`; the first is sent in the next step."""
        period_ns = max(round(period * NS_PER_S), 1)
        task = PeriodicFrame(CanFrame(can_id, bytes(data)), period_ns, self.clock.monotonic_ns())
        if not remote:
            self._periodic.append(task)
        return task

    def add_remote(self, node: int | RemoteNode, timeout_s: float = 0.3) -> RemoteNode:
        """A node of others, whose objects are read and written by SDO.

        node: a number where objects are named by index alone. timeout_s: longest wait for an
        answer; then canopen's `SdoCommunicationError` is raised.
        """
        remote = RemoteNode(node, _nothing()) if isinstance(node, int) else node
        remote.sdo.responses = _Answers(self)
        remote.sdo.RESPONSE_TIMEOUT = timeout_s
        self.add_node(remote)
        return remote

    def disconnect(self) -> None:
        """Leave the bus."""
        self._periodic.clear()
        self.frames.close()


def _nothing() -> ObjectDictionary:
    return ObjectDictionary()  # type: ignore[no-untyped-call]


class _Answers(queue.Queue[bytes]):
    """Answers by SDO; to wait for one steps the network."""

    def __init__(self, network: SteppedNetwork) -> None:
        super().__init__()
        self._network = network

    def empty(self) -> bool:
        """Forget what came too late for the request before, else the next one would take it."""
        while self.qsize():
            super().get(block=False)
        return True

    def get(self, block: bool = True, timeout: float | None = None) -> bytes:
        """See `queue.Queue.get`."""
        clock = self._network.clock
        ends_ns = after(clock, timeout or 0.0)
        while block and not self.qsize() and clock.monotonic_ns() < ends_ns:
            self._network.wait()
        return super().get(block=False)
