"""The twin's process as a machine before the controller."""

import json
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from opensuction.devices.ports import Facts
from opensuction.devices.twin_process import BEGUN, CHANGE, COMMANDS, SHOWN
from opensuction.exchange.ring import RingReader, RingWriter
from opensuction.kernel.errors import InputError
from opensuction.kernel.generated import plain_row
from opensuction.kernel.record import Array
from opensuction.simulation import machine_side
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.machine_side import SENT_COLUMNS, SHOWN_COLUMNS, MachineSide
from opensuction.twin.machine.drive_watchdog import SILENCE_S
from opensuction.twin.plant import PlantState

BEGINS_S = 120.0
"""Longest time until the twin plays: it may have to be compiled first."""
COMMAND_SLOTS = 64
READINGS = [i for i, name in enumerate(SHOWN_COLUMNS) if name.startswith("readings.")]
_READINGS = slice(READINGS[0], READINGS[-1] + 1)
"""One after the other, as any record's columns."""


def launch(folder: Path, side: MachineSide, plant: PlantState) -> subprocess.Popen[bytes]:
    """Start the twin in a folder; returns once it plays.

    Raises InputError where it does not.
    """
    begun: dict[str, Any] = {**machine_side.begin(side, plant)}
    np.savez(folder / BEGUN, **begun)
    (folder / SHOWN).unlink(missing_ok=True)
    command = [sys.executable, "-m", "opensuction.devices.twin_process", str(folder)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE)
    ends = time.monotonic() + BEGINS_S
    while time.monotonic() < ends and process.poll() is None:
        if (folder / SHOWN).exists() and RingReader(folder / SHOWN).newest():
            return process
        time.sleep(0.005)
    process.kill()
    said = process.communicate()[1].decode(errors="replace").strip()
    raise InputError(f"the twin does not play in {folder}: {said or 'it took too long'}")


def change(folder: Path, side: MachineSide) -> None:
    """Have the twin in a folder play another machine: the same one with a fault, or mended."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(plain_row.pack(MachineSide, side).tobytes(), str(folder / CHANGE))


class TwinMachine:
    """A `ports.Port` to the twin that plays in a folder."""

    def __init__(self, folder: Path) -> None:
        """Raises InputError where no twin plays there, or another controller has it."""
        self._shown = RingReader(folder / SHOWN)
        if self._shown.facts.columns != SHOWN_COLUMNS:
            raise InputError(f"{folder / SHOWN} is of another version of the twin")
        self._commands = RingWriter(folder / COMMANDS, SENT_COLUMNS, COMMAND_SLOTS, {})
        self.facts = Facts(
            name="twin",
            version=self._shown.facts.told["version"],
            in_silico=True,
            period_s=DT_S,
            watchdog_s=SILENCE_S,
            most=json.loads(self._shown.facts.told["most"]),
        )

    def read(self, readings: Array) -> int:
        """The newest readings; see `ports.Port.read`."""
        newest = self._shown.snapshot()
        if newest is None:
            return 0
        number, row = newest
        readings[:] = row[_READINGS]
        return number

    def write(self, sent: Array) -> None:
        """New commands; see `ports.Port.write`."""
        self._commands.write(sent)

    def close(self) -> None:
        """No more commands: the drives' watchdog takes over."""
        self._commands.close()
