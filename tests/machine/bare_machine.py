"""A machine beside the twin, with nothing that a machine may go without; a backend of its own.

It stands at home for ever: no patient monitor, no light barrier, no hand, no truth, no faults.
"""

from pathlib import Path

import pytest

from opensuction.host.host import Host
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import NO_MONITOR, Readings
from opensuction.kernel.record import Array, make_zero
from opensuction.machine import port
from opensuction.machine.port import NOTHING, Capabilities, MachineFacts
from tests.controller.bedside import at_bed

NAME = "bare"
MACHINE_FACTS = MachineFacts(
    name=NAME,
    version="7",
    in_silico=False,
    period_s=0.001,
    watchdog_s=0.02,
    most={"commands.insertion_v": 24.0, "commands.valve_v": 24.0, "commands.vacuum_mmhg": 150.0},
    capabilities=NOTHING,
)
_VALID = {name: True for name in Readings._fields if name.endswith("_valid")}


class BareMachine:
    """A `Port` to it; it obeys nothing."""

    facts = MACHINE_FACTS

    def __init__(self, _: Path, host: Host) -> None:  # noqa: ARG002
        home_mm = at_bed("neonate")[0].controller.limits.park_head_mm
        places = {"head_mm": home_mm, "carriage_mm": home_mm}
        readings = make_zero(Readings, **places, **_VALID, monitor=NO_MONITOR)
        self._row = plain_row.pack(Readings, readings)
        self._number = 0

    def read(self, readings: Array) -> int:
        """See `Port.read`."""
        readings[:] = self._row
        self._number += 1
        return self._number

    def write(self, _: Array) -> None:
        """See `Port.write`."""

    def close(self) -> None:
        """See `Port.close`."""


def capabilities_of(_: Path) -> Capabilities:
    """See `Backend.capabilities_of`."""
    return MACHINE_FACTS.capabilities


def hand_of(_: Path) -> None:
    """See `Backend.hand_of`."""


def truth_of(_: Path) -> None:
    """See `Backend.truth_of`."""


attach = BareMachine


def prepare(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the machine of a folder be one of these, for a test."""
    monkeypatch.setitem(port.MODULES, NAME, __name__)
    port.name_backend(folder, NAME)
