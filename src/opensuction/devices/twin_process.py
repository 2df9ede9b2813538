"""The twin in real time, a process of its own: ``python -m opensuction.devices.twin_process DIR``.

It plays a machine and its patient at 1 kHz and outlives the controller, whose death it is the judge
of. In its folder lie ``machine.npz`` (`machine_side.begin`), from which it begins, the ring
``machine.ring`` that it writes (`machine_side.Shown`, readings and truth), the ring
``commands.ring`` that a controller writes (`machine_side.Sent`), and ``machine.change``, a socket
that takes another machine to play from now on: the same one with a fault. When it is itself kept
from its work it makes up for it: nature does not wait. Only of a second and more it plays a second.
"""

import json
import signal
import socket
import sys
from pathlib import Path

import numpy as np

from opensuction import __version__
from opensuction.exchange.pace import NS_PER_S, Pace, harden
from opensuction.exchange.ring import RingReader, RingWriter
from opensuction.exchange.sole import Sole
from opensuction.kernel.errors import InputError
from opensuction.kernel.generated import plain_row
from opensuction.kernel.record import Array
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.machine_side import (
    SENT_COLUMNS,
    SHOWN_COLUMNS,
    MachineCall,
    MachineSide,
)

PLAYS = "machine.lock"
"""Held by the process that plays."""
BEGUN, SHOWN, COMMANDS, CHANGE = "machine.npz", "machine.ring", "commands.ring", "machine.change"
SLOTS = 20_000
"""Rows that are kept: 20 s."""
PERIOD_NS = round(DT_S * NS_PER_S)
CAUGHT_UP = 1000
"""Ticks that are made up for at most."""
LOOK_TICKS = 50
"""How often a controller that is silent is looked for anew: its ring may be another file by now."""


class Listener:
    """The commands of whichever controller there is."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._reader: RingReader | None = None
        self._inode = 0
        self._number = 0
        self._silent = LOOK_TICKS
        self.row: Array = np.zeros(len(SENT_COLUMNS))
        """The last that came."""

    def hear(self) -> bool:
        """Whether something new has come since the last call."""
        self._silent += 1
        if self._silent % LOOK_TICKS == 0:
            self._look()
        if self._reader is None or self._reader.newest() == self._number:
            return False
        newest = self._reader.snapshot()
        if newest is None:
            return False
        self._number, self.row = newest
        self._silent = 0
        return True

    def _look(self) -> None:
        """Open the ring, where there is another one than before."""
        try:
            inode = self._path.stat().st_ino
            if inode != self._inode:
                reader = RingReader(self._path)
                if reader.facts.columns == SENT_COLUMNS:
                    self._reader, self._inode, self._number = reader, inode, 0
        except (OSError, InputError):
            return


def serve(folder: Path) -> None:
    """Play until the process is told to end. Raises InputError where it cannot begin."""
    try:
        with np.load(folder / BEGUN) as begun:
            call = MachineCall({name: begun[name] for name in begun.files})
    except (OSError, EOFError, ValueError, KeyError) as error:
        raise InputError(f"no machine to play in {folder / BEGUN}: {error}") from None
    changes = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    changes.setblocking(False)
    (folder / CHANGE).unlink(missing_ok=True)
    changes.bind(str(folder / CHANGE))
    ending: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
    told = {"version": __version__, "most": json.dumps(_most(call))}
    with (
        Sole(folder / PLAYS, "a twin plays"),
        changes,
        RingWriter(folder / SHOWN, SHOWN_COLUMNS, SLOTS, told) as ring,
    ):
        harden()
        listener, pace = Listener(folder / COMMANDS), Pace(PERIOD_NS)
        while not ending:
            for _ in range(min(pace.wait(), CAUGHT_UP)):
                call.step(listener.row, new=False)
                ring.write(call.shown_row)
            new = listener.hear()
            call.step(listener.row, new=new)
            ring.write(call.shown_row)
            _change(call, changes)


def _most(call: MachineCall) -> dict[str, float]:
    """See `ports.Facts.most`."""
    played = plain_row.unpack(MachineSide, call.side_row).machine
    return {
        "commands.insertion_v": played.insertion_axis.voltage_limit_v,
        "commands.valve_v": played.valve_axis.voltage_limit_v,
    }


def _change(call: MachineCall, changes: socket.socket) -> None:
    """Play another machine, where one was sent. One of another shape is none."""
    try:
        data = changes.recv(1 << 16)
    except BlockingIOError:
        return
    if len(data) == call.side_row.nbytes:
        call.side_row[:] = np.frombuffer(data)


if __name__ == "__main__":
    try:
        serve(Path(sys.argv[1]))
    except InputError as problem:
        sys.exit(f"opensuction: {problem}")
