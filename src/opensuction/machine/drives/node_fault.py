"""Faults of emulated nodes and of their bus: asked for from outside, while the drives play.

What is wrong with motor, sensors or line is asked of the twin behind them (`twin_faults`).
"""

import json
from contextlib import closing
from enum import StrEnum
from pathlib import Path
from typing import Any, Final, NamedTuple

from opensuction.host.host import Host
from opensuction.kernel.errors import InputError
from opensuction.machine.drives.transceiver import SOUND, WireFaults

REQUESTS: Final = "drives.change"
"""Socket that the drives listen at."""
LARGEST: Final = 1 << 12
PATIENCE_S: Final = 1.0
ALL: Final = 0
"""Number that means every node."""


class NodeFault(StrEnum):
    """Fault of a node."""

    NODE_LOST = "node-lost"
    """Its power is gone: no frame, no torque, no output; it starts anew once it is mended."""
    BUS_OFF = "bus-off"
    """Cut from the bus; the drive lives on, and misses its host."""
    PDO_LOST = "pdo-lost"
    """A share of the frames of process data, in either direction."""
    REPEATED = "repeated"
    """A share of all frames comes twice."""
    SYNC_LATE = "sync-late"
    """SYNC comes so many milliseconds late."""
    ENCODER = "encoder"
    """Its encoder tells nothing any more."""
    EMERGENCY = "emergency"
    """It finds a fault in itself, and says so."""


_SHARES: Final = (NodeFault.PDO_LOST, NodeFault.REPEATED)
_MOST_LATE_MS: Final = 1000
_MOST_NODES: Final = 127


class Request(NamedTuple):
    """A fault of a node, or of all."""

    fault: NodeFault
    node: int = ALL
    strength: float = 1.0
    """Share of the frames, or ms."""

    def check(self) -> None:
        """Refuse what cannot be; raises InputError."""
        if not (0 <= self.node <= _MOST_NODES):
            raise InputError(f"there is no node {self.node}: give 1 to {_MOST_NODES}")
        if self.fault in _SHARES and not 0.0 <= self.strength <= 1.0:
            raise InputError(f"{self.fault} is {self.strength:g}: give a share of frames, 0 to 1")
        if self.fault == NodeFault.SYNC_LATE and not 0.0 <= self.strength <= _MOST_LATE_MS:
            raise InputError(f"{self.fault} is {self.strength:g} ms: give 0 to {_MOST_LATE_MS} ms")


def parse(text: str) -> Request:
    """A fault as the command line writes it: NAME[@NODE][=STRENGTH]. Raises InputError."""
    rest, _, strength = text.partition("=")
    name, _, node = rest.partition("@")
    if name not in tuple(NodeFault):
        raise InputError(f"unknown fault of a node '{name}'; known: {', '.join(NodeFault)}")
    try:
        request = Request(
            NodeFault(name), int(node) if node else ALL, float(strength) if strength else 1.0
        )
    except ValueError:
        raise InputError(f"fault of a node '{text}': give NAME[@NODE][=STRENGTH]") from None
    request.check()
    return request


def is_played(folder: Path) -> bool:
    """True where drives play in a folder, or have played until they died."""
    return (folder / REQUESTS).exists()


def wire_faults(before: WireFaults, request: Request) -> WireFaults:
    """Faults of a connection after a request; as before where it is about something else."""
    if request.fault == NodeFault.BUS_OFF:
        return before._replace(is_off=True)
    if request.fault == NodeFault.PDO_LOST:
        return before._replace(pdo_lost_share=request.strength)
    if request.fault == NodeFault.REPEATED:
        return before._replace(repeated_share=request.strength)
    if request.fault == NodeFault.SYNC_LATE:
        return before._replace(sync_late_ticks=round(request.strength))
    return before


MENDED: Final = SOUND


def inject(folder: Path, request: Request, host: Host) -> None:
    """Have the drives that play in a folder get a fault.

    Raises InputError where none play, or for what cannot be.
    """
    request.check()
    _send(folder, dict(request._asdict()), host)


def mend(folder: Path, host: Host) -> None:
    """Mend all nodes of the drives in a folder. Raises InputError where none play."""
    _send(folder, {}, host)


def _send(folder: Path, message: dict[str, Any], host: Host) -> None:
    with closing(host.datagrams.sender(PATIENCE_S)) as sender:
        try:
            sender.send(folder / REQUESTS, json.dumps(message).encode())
        except OSError as error:
            raise InputError(f"no drives play in {folder}: {error.strerror or error}") from None


def read(data: bytes) -> Request | None:
    """The request in a datagram; None to mend everything. Raises InputError for nonsense."""
    try:
        given = json.loads(data)
        if not given:
            return None
        request = Request(NodeFault(given["fault"]), int(given["node"]), float(given["strength"]))
    except (ValueError, TypeError, KeyError) as error:
        raise InputError(f"no fault of a node: {error!r}") from None
    request.check()
    return request
