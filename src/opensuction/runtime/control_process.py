"""The control loop as a process: ``python -m opensuction.runtime.control_process DIR``.

In the folder lie ``configuration.json`` (what the controller is set to) and the machine's own
files; it writes ``control.ring`` (`loop.ROW_COLUMNS`), ``control.events`` and ``heartbeat``, and
listens at ``control.ask``. When it has crashed before, its last row tells what it must not forget:
how often the patient was suctioned and how old the catheter is. Where the catheter is the head's
sensors tell; if it is in, it comes out first, and the machine waits for a person.
"""

import json
import signal
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction import __version__
from opensuction.controller import configuration, controller
from opensuction.controller.configuration import Configuration
from opensuction.controller.real_time_call import RealTimeCall
from opensuction.controller.record import State
from opensuction.devices.ports import Port
from opensuction.devices.twin_machine import TwinMachine
from opensuction.exchange.event_ring import EventWriter
from opensuction.exchange.heartbeat import Heartbeat, Process
from opensuction.exchange.mailbox import Mailbox
from opensuction.exchange.pace import NS_PER_S, Pace, harden
from opensuction.exchange.ring import RingReader, RingWriter
from opensuction.kernel.errors import InputError
from opensuction.kernel.generated import plain_row, row
from opensuction.kernel.readings import Readings
from opensuction.kernel.record import Array
from opensuction.procedure.cycle.upkeep import NEW_CATHETER_S, Upkeep
from opensuction.runtime.loop import ROW_COLUMNS, SLOTS_S, Around, ControlLoop
from opensuction.safety.head import head_vote

CONFIGURATION, RING, EVENTS, ASK = (
    "configuration.json",
    "control.ring",
    "control.events",
    "control.ask",
)
PERIOD_NS = 1_000_000
STARTED_FROM = "state"
"""What the ring tells of the state before its first row: the bytes of its numbers."""
READINGS = row.columns(Readings)
AT_ONCE = 2
"""Told so often to end it ends, wherever the catheter is: the drives bring it out."""
ANSWERS_S = 2.0
"""How long the machine may take to give its first readings."""
STATE_PLACES = [i for i, name in enumerate(ROW_COLUMNS) if name.startswith("state.")]


class Before(NamedTuple):
    """What a controller left that ran here before."""

    kept: Upkeep
    off_s: float
    """How long none has run."""


def read_before(folder: Path) -> Before | None:
    """What is left of the last controller in this folder; None of none, or of another version."""
    try:
        reader = RingReader(folder / RING)
        off_s = max(time.time() - (folder / RING).stat().st_mtime, 0.0)
    except (InputError, OSError):
        return None
    if reader.facts.columns != ROW_COLUMNS:
        return None
    left = reader.drain().rows
    if not len(left):
        return None
    state = plain_row.unpack(State, np.ascontiguousarray(left[-1, STATE_PLACES]))
    since_s = time.monotonic() - float(left[-1, 0])
    return Before(state.core.upkeep, since_s if since_s >= 0.0 else off_s)


def _first_readings(port: Port) -> Readings:
    """What the machine reads now. Raises InputError where it says nothing."""
    found: Array = np.zeros(len(READINGS))
    ends = time.monotonic() + ANSWERS_S
    while not port.read(found):
        if time.monotonic() > ends:
            raise InputError(f"the machine '{port.facts.name}' gives no readings")
        time.sleep(0.001)
    return plain_row.unpack(Readings, found)


def begin(chosen: Configuration, port: Port, before: Before | None) -> State:
    """State of a controller that starts now."""
    head_mm = head_vote.first_mm(_first_readings(port))
    if before is None:
        return controller.start(chosen.settings, head_mm, NEW_CATHETER_S)
    return controller.restart(chosen.settings, head_mm, before.kept, before.off_s)


def serve(folder: Path, period_ns: int = PERIOD_NS) -> None:
    """Control the machine of a folder until the process is told to end.

    A cycle is broken off then, and the process ends once the catheter is out.

    Raises InputError where it cannot begin.
    """
    try:
        text = (folder / CONFIGURATION).read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"no configuration to run: {error}") from None
    chosen = configuration.from_json(text)
    before = read_before(folder)
    port = TwinMachine(folder)
    call = RealTimeCall(chosen.settings, chosen.heads_mm, begin(chosen, port, before))
    told = {
        "version": __version__,
        "settings": configuration.hash_of(chosen),
        "machine": json.dumps(port.facts._asdict()),
        "period_ns": str(period_ns),
        STARTED_FROM: call.state_row.tobytes().hex(),
    }
    ending: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
    slots = round(SLOTS_S * NS_PER_S / period_ns)
    mailbox, heartbeat = Mailbox(folder / ASK), Heartbeat(folder)
    with (
        EventWriter(folder / EVENTS) as events,
        RingWriter(folder / RING, ROW_COLUMNS, slots, told) as ring,
    ):
        around = Around(port, mailbox, ring, events, heartbeat)
        loop = ControlLoop(call, around, period_ns / NS_PER_S)
        allowed = harden()
        events.write(
            "began",
            0,
            scheduler=allowed.scheduler,
            memory_locked=str(allowed.memory_locked).lower(),
            refusals="; ".join(allowed.refusals),
            recovered="no" if before is None else "yes",
        )
        pace = Pace(period_ns)
        while not (ending and loop.is_resting) and len(ending) < AT_ONCE:
            loop.stopping = bool(ending) and not loop.is_resting
            skipped = pace.wait()
            loop.step(pace.deadline_ns, skipped)
        events.write("ended", loop.tick)
    heartbeat.end(Process.CONTROL)
    mailbox.close()
    port.close()


if __name__ == "__main__":
    try:
        serve(Path(sys.argv[1]), *(int(value) for value in sys.argv[2:]))
    except InputError as problem:
        sys.exit(f"opensuction: {problem}")
