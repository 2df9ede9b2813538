"""A machine's processes: started in a folder that they share, and found there.

The folder holds rings that are written each millisecond, so it lies in memory (`/dev/shm`): a page
of a file that a disk is just writing out makes a tick wait.
"""

import subprocess
import sys
import time
from pathlib import Path

from opensuction.controller import configuration
from opensuction.controller.configuration import Configuration
from opensuction.devices import twin_machine
from opensuction.exchange.heartbeat import Heartbeat, Process
from opensuction.exchange.ring import RingReader
from opensuction.kernel.errors import InputError
from opensuction.runtime.control_process import CONFIGURATION, PERIOD_NS, RING
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.simulation.machine_side import MachineSide
from opensuction.simulation.wiring import Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.fault.bus import Bus
from opensuction.twin.machine import drive_watchdog
from opensuction.twin.plant import PlantState

BEGINS_S = 180.0
"""Longest time until a process does its work: it may have to compile first."""


def side_of(loop: Loop, seed: int) -> MachineSide:
    """The machine of a loop as a process plays it: its rack ends, its drives watch over messages.

    seed: chance of a link that loses messages.
    """
    home_mm = loop.controller.limits.park_head_mm
    machine = preset.limit_rack(loop.machine, home_mm)
    return MachineSide(machine, Wiring(link.healthy(seed), drive_watchdog.of(machine, home_mm)))


def start_twin(
    folder: Path, loop: Loop, state: LoopState, seed: int, carrier: Bus | None = None
) -> subprocess.Popen[bytes]:
    """The twin's process with a machine at rest. Raises InputError where it does not play.

    carrier: the bus between it and its controllers; None where messages are there at once.
    """
    plant = PlantState(state.machine, state.bedside)
    return twin_machine.launch(folder, side_of(loop, seed), plant, carrier)


def configure(folder: Path, loop: Loop) -> None:
    """What the controller of this folder is set to."""
    text = configuration.to_json(Configuration(loop.controller, loop.heads_mm))
    (folder / CONFIGURATION).write_text(text, encoding="utf-8")


def start_control(folder: Path, period_ns: int = PERIOD_NS) -> subprocess.Popen[bytes]:
    """The control process on the machine of a folder; returns once it ticks.

    Raises InputError where it does not.
    """
    ring = folder / RING
    before = _inode(ring)
    command = [sys.executable, "-m", "opensuction.runtime.control_process", str(folder)]
    process = subprocess.Popen([*command, str(period_ns)], stderr=subprocess.PIPE)
    ends = time.monotonic() + BEGINS_S
    while time.monotonic() < ends and process.poll() is None:
        if _inode(ring) not in (0, before) and RingReader(ring).newest():
            return process
        time.sleep(0.005)
    process.kill()
    said = process.communicate()[1].decode(errors="replace").strip()
    raise InputError(f"the controller does not run: {said or 'it took too long'}")


def start_recorder(folder: Path, out: Path) -> subprocess.Popen[bytes]:
    """The recorder of a folder's controller; returns once it has given a sign of life.

    Raises InputError where it does not.
    """
    command = [sys.executable, "-m", "opensuction.runtime.recorder_process", str(folder), str(out)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE)
    heartbeat, ends = Heartbeat(folder), time.monotonic() + BEGINS_S
    before = time.monotonic_ns()
    while time.monotonic() < ends and process.poll() is None:
        if heartbeat.age_s(Process.RECORDER) < (time.monotonic_ns() - before) * 1e-9:
            return process
        time.sleep(0.005)
    process.kill()
    said = process.communicate()[1].decode(errors="replace").strip()
    raise InputError(f"the recorder does not run: {said or 'it took too long'}")


def _inode(path: Path) -> int:
    """Which file it is; 0 of none. A controller's ring is a new one."""
    return path.stat().st_ino if path.exists() else 0
