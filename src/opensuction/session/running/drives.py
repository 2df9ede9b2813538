"""Emulated drives from choices: their folder, made ready, and how a controller finds them.

The twin is identified as before a cycle, for the drives' servos are tuned by that; then it lies in
the folder at rest. The device file there names its bus so that a controller of another folder finds
it, too.
"""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import tomli_w

from opensuction.host.host import Host, finish
from opensuction.ipc.liveness import holder
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import device_file
from opensuction.machine.canopen.device import AxisMotor, Device
from opensuction.machine.canopen.frame_bus import UNIX
from opensuction.machine.canopen.process_image import NAMES
from opensuction.machine.drives import drives_process
from opensuction.machine.twin.twin_process import PLAYS
from opensuction.runtime import machine_folder
from opensuction.session.cycle.cycle_run import Prepared


class Drives(NamedTuple):
    """Drives that are ready to play."""

    folder: Path
    device: Device

    @property
    def device_file(self) -> Path:
        """The file that a controller is given."""
        return self.folder / device_file.NAME

    @property
    def told(self) -> tuple[str, ...]:
        """Lines for a person: where they are."""
        bus = self.device.bus
        nodes = zip(self.device.nodes, NAMES, strict=True)
        named = ", ".join(f"{number} ({name})" for number, name in nodes)
        return (
            f"Bus: interface {bus.interface}, channel {bus.channel}",
            f"Nodes: {named}; SYNC every {1000.0 * bus.period_s:g} ms",
            f"Device file for a controller: {self.device_file}",
        )


def find_free(name: str, device: Path | None) -> Path:
    """The folder of drives that nobody plays yet.

    Raises InputError where somebody does, or where no drives can be made by the device file.
    """
    drives_process.check(device or device_file.EMULATED)
    folder = machine_folder.make(name)
    if (process := holder(folder / PLAYS)) is not None:
        raise InputError(
            f"'{name}' is played already (process {process}): end that one, or give another --name"
        )
    return folder


def prepare(folder: Path, prepared: Prepared, device: Path | None) -> Drives:
    """Lay drives into a folder, at rest. device: device file; None: the emulated drives' own."""
    machine_folder.clear(folder)
    seed = prepared.resolved.equipment.seed
    chosen = device or device_file.EMULATED
    drives_process.prepare(folder, prepared.loop, prepared.start, seed, chosen)
    text = addressed(folder / device_file.NAME)
    if device is None:
        text = with_motors(text, drives_process.motors_of(prepared.loop))
    private_file.write(folder / device_file.NAME, text)
    return Drives(folder, device_file.find(folder))


def addressed(path: Path) -> str:
    """Text of a device file that names a bus of this computer by its whole path.

    Raises InputError for a file that describes no machine.
    """
    bus = device_file.load(path).bus
    text = path.read_text(encoding="utf-8-sig")
    if bus.interface != UNIX or Path(bus.channel).is_absolute():
        return text
    content = tomllib.loads(text)
    content["bus"]["channel"] = str(path.parent.absolute() / bus.channel)
    return tomli_w.dumps(content)


def with_motors(text: str, motors: tuple[AxisMotor, AxisMotor]) -> str:
    """Text of a device file with the motors of the machine that is played."""
    content = tomllib.loads(text)
    for name, motor in zip(("insertion", "valve"), motors, strict=True):
        content[name]["motor"] = motor._asdict()
    return tomli_w.dumps(content)


def play(drives: Drives, host: Host, begun: Callable[[], None]) -> None:
    """Play until told to end. begun: called once they are on the bus. Raises InputError."""
    steps = drives_process.steps(host, drives.folder, lambda _: begun())
    try:
        finish(steps, host.clock)
    finally:
        steps.close()


def end(drives: Drives) -> None:
    """Give back what lies in memory. Raises InputError."""
    machine_folder.clear(drives.folder)
