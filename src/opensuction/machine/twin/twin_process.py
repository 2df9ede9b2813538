"""Process of the twin in real time: ``python -m opensuction.machine.twin.twin_process DIR``.

It plays a machine and its patient at 1 kHz and outlives the controller, whose death it is the judge
of. In its folder lie ``machine.npz`` (`machine_side.begin`), from which it begins, the ring
``machine.ring`` that it writes (`machine_side.Shown`, readings and truth), the ring
``commands.ring`` that a controller writes (`kernel.interface`), and what `faulty_twin` has to
break it. When it is itself kept from its work it makes up for it: nature does not wait. Only of a
second and more it plays a second.
"""

import json
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction import __version__
from opensuction.host import this_computer
from opensuction.host.host import NS_PER_S, Host, Steps
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.deadline_scheduler import DeadlineScheduler
from opensuction.ipc.liveness import ProcessLock
from opensuction.ipc.ring import FollowedRing, RingWriter
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.kernel.record import Array
from opensuction.machine.port import EVERYTHING, Capabilities
from opensuction.machine.twin.faulty_twin import FaultyTwin
from opensuction.simulation import machine_side
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.machine_side import (
    GREETED,
    MESSAGE,
    SHOWN_COLUMNS,
    SILENT_TICKS,
    Heard,
    MachineCall,
    MachineSide,
)

PLAYS = "machine.lock"
"""Held by the process that plays."""
BEGUN, SHOWN, COMMANDS = "machine.npz", "machine.ring", "commands.ring"
SLOTS = 20_000
"""Rows that are kept: 20 s."""
CAPABILITIES = "capabilities"
"""What the ring tells of them, as JSON."""
PERIOD_NS = round(DT_S * NS_PER_S)
CAUGHT_UP = 1000
"""Ticks that are made up for at most."""
LOOK_TICKS = 50
"""How often a controller that is silent is looked for anew: its ring may be another file by now."""


class Listener:
    """The commands of whichever controller there is.

    One that has not said that it has started anew is not heard: it takes the machine for another
    one, or for where another one was. A command that is no number is none.
    """

    def __init__(self, path: Path) -> None:
        self.ring = FollowedRing(path, lambda columns: columns == MESSAGE_COLUMNS)
        """Of its commands."""
        self.heard = Heard(
            np.zeros(len(MESSAGE_COLUMNS)), np.zeros(machine_side.HEARD_COUNTS, np.int64)
        )
        # Compiled or loaded before anybody waits for it.
        machine_side.hear(self.heard, 0, np.full(len(MESSAGE_COLUMNS), np.nan))
        self.heard.counts[SILENT_TICKS] = LOOK_TICKS - 1

    def hear(self) -> bool:
        """Look for a new message of the controller; true where one has come since the last call."""
        counts = self.heard.counts
        counts[SILENT_TICKS] += 1
        if counts[SILENT_TICKS] % LOOK_TICKS == 0 and self.ring.look():
            counts[MESSAGE], counts[GREETED] = 0, 0
        reader = self.ring.reader
        if reader is None or reader.newest() == counts[MESSAGE]:
            return False
        newest = reader.snapshot()
        return newest is not None and bool(machine_side.hear(self.heard, *newest))


class TwinPlayer(NamedTuple):
    """A machine and its patient, a tick at a time."""

    call: MachineCall
    ring: RingWriter
    faults: FaultyTwin

    def step(self, sent: Array, new: bool) -> None:
        """Play a tick. sent: a row by `MESSAGE_COLUMNS`. new: it has come since the last tick."""
        self.faults.step()
        self.call.step(sent, new=new)
        self.ring.write(self.call.shown_row)


@contextmanager
def playing(folder: Path, host: Host = THIS_COMPUTER) -> Iterator[TwinPlayer]:
    """The twin of a folder, which nobody else plays meanwhile.

    Raises InputError where there is none to play, or somebody else does.
    """
    try:
        with np.load(folder / BEGUN) as begun:
            call = MachineCall({name: begun[name] for name in begun.files})
    except (OSError, EOFError, ValueError, KeyError) as error:
        raise InputError(f"no machine to play in {folder / BEGUN}: {error}") from None
    told = {
        "version": __version__,
        "most": json.dumps(most_obeyed(call)),
        CAPABILITIES: json.dumps(capabilities(call)._asdict()),
    }
    with (
        ProcessLock(folder / PLAYS, "a twin plays", host),
        RingWriter(folder / SHOWN, SHOWN_COLUMNS, SLOTS, told, host=host) as ring,
        FaultyTwin(folder, call, host) as faults,
    ):
        yield TwinPlayer(call, ring, faults)


class Playing(NamedTuple):
    """A twin that plays."""

    twin: TwinPlayer
    listener: Listener
    pace: DeadlineScheduler


def steps(
    host: Host, folder: Path, tell: Callable[[Playing], None] = lambda _: None
) -> Steps[None]:
    """Play until the process is told to end. Raises InputError where it cannot begin.

    tell: told of the twin as it begins.
    """
    with playing(folder, host) as twin, host.hardened():
        listener = Listener(folder / COMMANDS)
        pace = DeadlineScheduler(PERIOD_NS, host.clock.monotonic_ns())
        tell(Playing(twin, listener, pace))
        while not host.terminations():
            yield pace.due_ns
            for _ in range(min(pace.begin(host.clock.monotonic_ns()), CAUGHT_UP)):
                twin.step(listener.heard.row, new=False)
            new = listener.hear()
            twin.step(listener.heard.row, new)
            twin.faults.look()


def capabilities(call: MachineCall) -> Capabilities:
    """See `port.MachineFacts.capabilities`: a bench has nobody, and no tube with a barrier."""
    played = plain_row.unpack(MachineSide, call.side_row).machine
    return EVERYTHING._replace(
        monitor=played.has_patient and played.patient.monitor.present,
        mouth_barrier=math.isfinite(played.mouth_mm),
    )


def most_obeyed(call: MachineCall) -> dict[str, float]:
    """See `ports.Facts.most`."""
    played = plain_row.unpack(MachineSide, call.side_row).machine
    return {
        "commands.insertion_v": played.insertion_axis.voltage_limit_v,
        "commands.valve_v": played.valve_axis.voltage_limit_v,
        "commands.vacuum_mmhg": played.line.relief_mmhg,
    }


if __name__ == "__main__":
    _folder = Path(sys.argv[1])
    this_computer.run(lambda host: steps(host, _folder))
