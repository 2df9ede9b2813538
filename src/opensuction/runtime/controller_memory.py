"""Memory of a machine's controller for the one after it: limits that a new start does not reset.

How often the patient was suctioned since a person looked, how long it must rest, the lock-out and
the catheter's age lie in the rows of the control ring. Where a controller's machine is gone with
its folder's ring, they are handed on in a file of that folder.
"""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.controller.record import State
from opensuction.host.host import NS_PER_S, Clock
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import EventReader, RingReader
from opensuction.kernel import private_file
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.procedure.cycle.interlocks import Interlocks
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import BEFORE, EVENTS, RING

ENDED = "ended"
"""Kind of the last event of a controller that ended as it should."""
STATE_PLACES = [i for i, name in enumerate(ROW_COLUMNS) if name.startswith("state.")]


class Before(NamedTuple):
    """State left behind by the controller that ran here before."""

    kept: Interlocks
    off_s: float
    """How long none has run."""
    died: bool
    """It did not end as it should."""
    phase: int
    """What it was doing."""


def read_before(folder: Path, clock: Clock = THIS_COMPUTER.clock) -> Before | None:
    """State left by the last controller in this folder; None of none, or of another version.

    It lies in its ring, or, where its machine is gone with all else, in what was handed on.
    """
    return _read_ring(folder, clock) or _read_handed_on(folder, clock)


def _now_s(clock: Clock) -> float:
    """Monotonic time."""
    return clock.monotonic_ns() / NS_PER_S


def hand_on(folder: Path, before: Before, clock: Clock = THIS_COMPUTER.clock) -> None:
    """Write down for the next controller what it must not forget, where its ring goes."""
    told = {
        "kept": plain_row.pack(Interlocks, before.kept).tolist(),
        "ended_s": _now_s(clock) - before.off_s,
        "phase": int(before.phase),
        "died": before.died,
    }
    private_file.write(folder / BEFORE, json.dumps(told))


def _read_handed_on(folder: Path, clock: Clock) -> Before | None:
    try:
        told = json.loads((folder / BEFORE).read_text(encoding="ascii"))
        kept = plain_row.unpack(Interlocks, np.array(told["kept"], np.float64))
        off_s = max(_now_s(clock) - told["ended_s"], 0.0)
        return Before(kept, off_s, told.get("died", True), told["phase"])
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        return None


def _read_ring(folder: Path, clock: Clock) -> Before | None:
    try:
        reader = RingReader(folder / RING)
        off_s = max(clock.wall_ns() / NS_PER_S - (folder / RING).stat().st_mtime, 0.0)
    except (InputError, OSError):
        return None
    if reader.facts.columns != ROW_COLUMNS:
        return None
    left = reader.drain().rows
    if not len(left):
        return None
    state = plain_row.unpack(State, np.ascontiguousarray(left[-1, STATE_PLACES]))
    since_s = _now_s(clock) - float(left[-1, 0])
    return Before(
        kept=state.core.upkeep,
        off_s=since_s if since_s >= 0.0 else off_s,
        died=_has_died(folder),
        phase=state.core.procedure.phase,
    )


def _has_died(folder: Path) -> bool:
    """True where the last controller did not say that it ended."""
    try:
        told = EventReader(folder / EVENTS).read()[0]
    except InputError:
        return True
    return not told or told[-1].fields["kind"] != ENDED
