"""Faults of a twin that plays: whoever is outside asks for them, and is told what became of it.

The twin keeps the machine as it was built and all the faults that have come, and plays what is
broken by now; see `faulty_twin`. Faults of the controller are no faults of the machine: they are
done to its process.
"""

import json
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

from opensuction.host.host import Host, after
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import EventReader, ProcessEvent
from opensuction.kernel.errors import InputError
from opensuction.machine.port import HandTask
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.twin.fault.bus import Bus
from opensuction.twin.fault.fault import BY_NAME, Fault
from opensuction.twin.fault.fault_table import ROWS

CHANGE, EVENTS = "machine.change", "machine.events"
"""Socket that the twin listens at, and ring in which it says what it did."""
ANSWER, CAME, HEALED, BUS = "answer", "fault", "healed", "bus"
"""Kinds of its events."""
TAKEN = ""
"""Reason of an answer that takes what was asked."""
PHASES, PHASE = "control.ring", "outputs.phase"
"""Ring of the controller in the same folder, and its column: phases that a fault waits for."""
PATIENCE_S, LOOKS_S = 5.0, 0.002
"""Longest time that the twin may take to answer: it answers between two ticks, but whatever runs
it may be busy."""
OF_PROCESS = {
    Fault.CONTROLLER_STOPPED: "kill its process, and start it again when it is time",
    Fault.TICK_LATE: "stop its process for as long (kill -STOP, kill -CONT)",
}
"""What is done to the controller's process, and how."""


class Came(NamedTuple):
    """A fault that has come."""

    fault: Fault
    strength: float
    tick: int
    """The machine's first with it."""


def check(faults: Sequence[Injection]) -> None:
    """Refuse what cannot be put into a machine that runs; raises InputError."""
    injection.check(faults)
    for one in faults:
        if one.fault in OF_PROCESS:
            raise InputError(
                f"fault '{one.fault.title}' is one of the controller, not of the machine: "
                f"{OF_PROCESS[one.fault]}"
            )
        if ROWS[one.fault].is_setup:
            raise InputError(
                f"fault '{one.fault.title}' is one of the set-up: a machine that runs has been set "
                "up already"
            )


def inject(folder: Path, faults: Sequence[Injection], host: Host = THIS_COMPUTER) -> None:
    """Put faults into the twin that plays in a folder; returns once it has them.

    Their instants in seconds count from now, those of a phase from when the controller's next
    phase of that name begins. Those that came before stay. Raises InputError for what cannot be
    injected, or where the twin refuses it or does not answer.
    """
    check(faults)
    plain = [
        (
            one.fault.title,
            None if one.at.phase is None else int(one.at.phase),
            one.at.after_s,
            one.strength,
        )
        for one in faults
    ]
    _ask(folder, {"faults": plain}, host)


def heal(folder: Path, host: Host = THIS_COMPUTER) -> None:
    """Mend all that is broken, and forget what was to come; the bus stays. See `inject`."""
    _ask(folder, {"heal": True}, host)


def ride(folder: Path, carrier: Bus) -> None:
    """Put another bus between controller and machine, while no fault is there.

    Faults of the link come on top of it. Raises InputError for what no bus does, or where the twin
    refuses it or does not answer.
    """
    carrier.check()
    _ask(folder, {"bus": carrier})


def hold(folder: Path, task: HandTask, park_head_mm: float, quick_mm: float) -> None:
    """Have a person's hand at the catheter head do something (`twin_hand.held`).

    Raises InputError where the twin refuses it or does not answer.
    """
    _ask(folder, {"hand": [str(task), park_head_mm, quick_mm]})


def came(folder: Path) -> list[Came]:
    """Faults that have come since the twin plays, in their order, mended or not.

    Raises InputError where none plays.
    """
    told = [event.fields for event in _events(folder) if event.fields["kind"] == CAME]
    return [Came(BY_NAME[one["fault"]], float(one["strength"]), int(one["tick"])) for one in told]


def _events(folder: Path) -> list[ProcessEvent]:
    return EventReader(folder / EVENTS).read()[0]


def _ask(folder: Path, message: dict[str, Any], host: Host = THIS_COMPUTER) -> None:
    """Send it, and wait for the answer."""
    clock = host.clock
    key = str(clock.monotonic_ns())
    with closing(host.datagrams.sender(PATIENCE_S)) as sender:
        try:
            events = EventReader(folder / EVENTS)
            sender.send(folder / CHANGE, json.dumps({"key": key, **message}).encode())
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(f"no twin plays in {folder}: {reason}") from None
    ends_ns = after(clock, PATIENCE_S)
    while clock.monotonic_ns() < ends_ns:
        for event in events.read()[0]:
            if event.fields["kind"] == ANSWER and event.fields["key"] == key:
                if event.fields["reason"] != TAKEN:
                    raise InputError(event.fields["reason"])
                return
        clock.sleep_until(after(clock, LOOKS_S))
    raise InputError(f"the twin in {folder} does not answer")
