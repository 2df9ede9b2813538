"""Bus of CAN frames: between processes of one computer, or over any interface of python-can.

A participant sees every other one's frames. Nothing here waits: what has come is taken, and a frame
that finds no room is lost, as on a wire that is cut. What is lost is noticed by those who miss it.
"""

import contextlib
import os
import struct
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol

from opensuction.host.host import NS_PER_S, Host
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen.device import Bus

UNIX: Final = "unix"
"""Name of the interface of `DatagramBus`; python-can has all others."""
NEEDS: Final = "drives on a CANopen bus need packages: pip install 'opensuction[canopen]'"


class CanFrame(NamedTuple):
    """A data frame with an identifier of 11 bits."""

    can_id: int
    data: bytes
    """0 to 8 bytes."""


class FrameBus(Protocol):
    """A bus, as one participant has it."""

    def send(self, frames: Sequence[CanFrame]) -> None:
        """Send frames in their order. Never waits: one that finds no room is lost."""

    def receive(self) -> Iterable[CanFrame]:
        """All frames that have come since the last call, oldest first. Never waits."""

    def close(self) -> None:
        """Leave the bus."""


_HEAD: Final = struct.Struct("<HB")
"""Before each frame of a datagram: identifier and number of bytes."""
LARGEST: Final = 1 << 12
"""Bytes of a datagram: more frames than a cycle has."""
_MOST_FRAMES: Final = LARGEST // (_HEAD.size + 8)
SIGN: Final = ".on-bus"
"""End of the name of the file that a participant is known by."""
LOOK_NS: Final = NS_PER_S // 20
"""How often new participants are looked for where the folder seems unchanged: the time of its last
change is coarse."""


def pack(frames: Iterable[CanFrame]) -> bytes:
    """Frames as a datagram holds them."""
    return b"".join(_HEAD.pack(one.can_id, len(one.data)) + one.data for one in frames)


def unpack(datagram: bytes) -> list[CanFrame]:
    """Frames of a datagram; those that it does not hold whole are left out."""
    found, place = [], 0
    while place + _HEAD.size <= len(datagram):
        can_id, length = _HEAD.unpack_from(datagram, place)
        place += _HEAD.size
        if length > 8 or place + length > len(datagram):
            break
        found.append(CanFrame(can_id, datagram[place : place + length]))
        place += length
    return found


class DatagramBus:
    """Bus between processes of one computer and user: sockets in a folder, `BUS.NAME.can`.

    Frames that are sent in one call travel in one datagram, for a socket holds ten datagrams and
    not more. A participant that has died is sent to in vain until its name is used again.
    """

    def __init__(self, path: Path, name: str, host: Host) -> None:
        """path: folder, and the bus' own name in it. name: of this participant, with no dot.

        One that had the name before is replaced. Raises OSError where nobody can listen there.
        """
        private_file.make_folder(path.parent)
        self._folder, self._bus = path.parent, path.name
        self._name, self._clock = name, host.clock
        self._inbox = host.datagrams.listen(self._address(name))
        self._outbox = host.datagrams.sender(0.0)
        # The socket is no file where the computer is simulated.
        private_file.write(self._sign(name), "")
        self._others: list[Path] = []
        self._signs: list[str] = []
        """Names of the files by which the others are known."""
        self._changed_ns, self._looks_ns = -1, 0

    def _address(self, name: str) -> Path:
        return self._folder / f"{self._bus}.{name}.can"

    def _sign(self, name: str) -> Path:
        return self._folder / f"{self._bus}.{name}{SIGN}"

    def send(self, frames: Sequence[CanFrame]) -> None:
        """See `FrameBus.send`."""
        self._look()
        for first in range(0, len(frames), _MOST_FRAMES):
            datagram = pack(frames[first : first + _MOST_FRAMES])
            for other in self._others:
                with contextlib.suppress(OSError):
                    self._outbox.send(other, datagram)

    def receive(self) -> Iterable[CanFrame]:
        """See `FrameBus.receive`."""
        while (datagram := self._inbox.receive(LARGEST)) is not None:
            yield from unpack(datagram)

    def close(self) -> None:
        """See `FrameBus.close`."""
        self._inbox.close()
        self._outbox.close()
        self._sign(self._name).unlink(missing_ok=True)

    def _look(self) -> None:
        """Look for other participants where there may be new ones."""
        now_ns = self._clock.monotonic_ns()
        try:
            changed_ns = self._folder.stat().st_mtime_ns
        except OSError:
            changed_ns = -1  # it has been removed, and with it all others
        if changed_ns == self._changed_ns and now_ns < self._looks_ns:
            return
        self._changed_ns, self._looks_ns = changed_ns, now_ns + LOOK_NS
        # No path is made of what is found each time: its parts enter the interpreter's table of
        # names, and where that is made anew, every some minutes, a tick takes 8 to 28 ms.
        signs = sorted(one for one in self._names() if one.endswith(SIGN))
        if signs != self._signs:
            self._signs = signs
            self._others = [self._address(name) for name in map(self._name_of, signs) if name]

    def _name_of(self, sign: str) -> str:
        """Name of another participant of this bus, by its file; empty where it is none."""
        begins = f"{self._bus}."
        name = sign.removeprefix(begins).removesuffix(SIGN)
        is_other = sign.startswith(begins) and "." not in name and name != self._name
        return name if is_other else ""

    def _names(self) -> list[str]:
        """Names in the folder; none where it has been removed."""
        try:
            return os.listdir(self._folder)  # noqa: PTH208 - iterdir makes paths
        except OSError:
            return []


_MOST_REFUSED: Final = 16
"""Errors after which one look ends: an interface that is down gives one at every call, and the
loop's tick would never end."""

_DEFAULTS: Final[dict[str, dict[str, Any]]] = {
    "udp_multicast": {"hop_limit": 0, "fd": False},  # it never leaves this computer
}


class PythonCanBus:
    """Bus over an interface of python-can: SocketCAN, multicast on this computer, and others.

    A participant of `udp_multicast` receives its own frames, too.
    """

    def __init__(self, bus: Bus) -> None:
        """Raises InputError where python-can cannot open it, or is not there."""
        try:
            import can
        except ImportError:
            raise InputError(NEEDS) from None
        self._can = can
        chosen: dict[str, Any] = dict(_DEFAULTS.get(bus.interface, {}))
        if bus.bitrate:
            chosen["bitrate"] = bus.bitrate
        try:
            self._bus = can.Bus(channel=bus.channel, interface=bus.interface, **chosen)
        except (can.CanError, OSError, ValueError, ImportError, NotImplementedError) as error:
            raise InputError(
                f"no bus on interface '{bus.interface}', channel '{bus.channel}': {error}"
            ) from None

    def send(self, frames: Sequence[CanFrame]) -> None:
        """See `FrameBus.send`."""
        for can_id, data in frames:
            message = self._can.Message(arbitration_id=can_id, data=data, is_extended_id=False)
            with contextlib.suppress(self._can.CanError):
                self._bus.send(message, timeout=0.0)

    def receive(self) -> Iterable[CanFrame]:
        """See `FrameBus.receive`."""
        refused = 0
        while refused < _MOST_REFUSED:
            try:
                message = self._bus.recv(timeout=0.0)
            except self._can.CanError:  # no frame, but another one may be behind it
                refused += 1
                continue
            if message is None:
                return
            other = message.is_error_frame or message.is_remote_frame or message.is_extended_id
            if not other:
                yield CanFrame(message.arbitration_id, bytes(message.data))

    def close(self) -> None:
        """See `FrameBus.close`."""
        self._bus.shutdown()


def open_bus(bus: Bus, host: Host, own_name: str, folder: Path = Path()) -> FrameBus:
    """Take part in a bus.

    own_name: among the participants of a bus of `UNIX`. folder: that its channel is relative to.
    Raises InputError where that cannot be.
    """
    if bus.interface != UNIX:
        return PythonCanBus(bus)
    try:
        return DatagramBus(folder / bus.channel, own_name, host)
    except OSError as error:
        raise InputError(f"no bus in {folder / bus.channel}: {error.strerror or error}") from None
