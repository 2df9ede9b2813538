"""Process of the emulated drives: ``python -m opensuction.machine.drives.drives_process DIR``.

It plays the twin of a folder as `machine.twin.twin_process` does, with its ring for a judge and its
faults, but the twin's commands come from nodes on a CANopen bus. In the folder lie the twin as it
begins (`prepare`), the device file, and the servos of both drives.
"""

import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from opensuction.control.servo import Servo
from opensuction.host import this_computer
from opensuction.host.host import Host, Inbox, Steps
from opensuction.ipc.deadline_scheduler import DeadlineScheduler
from opensuction.kernel import private_file
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import device_file
from opensuction.machine.canopen.device import AxisMotor
from opensuction.machine.canopen.frame_bus import open_bus
from opensuction.machine.drives import node_fault
from opensuction.machine.drives.emulated_drive import DT_S, SPEED_TICKS
from opensuction.machine.drives.emulated_machine import (
    EmulatedMachine,
    Servos,
    check_stop,
    motors,
    without_patience,
)
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_process import CAUGHT_UP, PERIOD_NS, TwinPlayer, playing
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.simulation.machine_side import MachineSide
from opensuction.twin.plant import PlantState

SERVOS: Final = "servos.npz"
NAME: Final = "drives"
"""Among the participants of a bus of datagrams."""


class Playing(NamedTuple):
    """Drives that play."""

    drives: EmulatedMachine
    twin: TwinPlayer


def prepare(
    folder: Path, loop: Loop, state: LoopState, seed: int, device: Path = device_file.EMULATED
) -> None:
    """Write down in a folder what shall be played there: a loop's twin, at rest, and its servos.

    device: device file, of which the folder has a copy afterwards. Raises InputError as `check`.
    """
    check(device)
    side = without_patience(twin_machine.side_of(loop, seed))
    twin_machine.prepare(folder, side, PlantState(state.machine, state.bedside))
    private_file.write(folder / device_file.NAME, device.read_bytes())
    settings = loop.controller
    servos = {
        "insertion": plain_row.pack(Servo, settings.insertion_servo),
        "valve": plain_row.pack(Servo, settings.valve_servo),
    }
    with private_file.create(folder / SERVOS) as file:
        np.savez(file, insertion=servos["insertion"], valve=servos["valve"])


def check(file: Path) -> None:
    """Raises InputError for no device file, and where drives by it would hold the head inside."""
    check_stop(device_file.load(file), file)


def motors_of(loop: Loop) -> tuple[AxisMotor, AxisMotor]:
    """Motors of a loop's twin behind the emulated drives, as a device file has them."""
    found = motors(loop.machine, device_file.load(device_file.EMULATED))
    insertion, valve = (
        AxisMotor(one.rated_v, 1.0 / one.speed_per_v, SPEED_TICKS * DT_S) for one in found
    )
    return insertion, valve


def _servos(folder: Path) -> Servos:
    """Raises InputError where there are none."""
    try:
        with np.load(folder / SERVOS) as found:
            return Servos(*(plain_row.unpack(Servo, found[name]) for name in Servos._fields))
    except (OSError, EOFError, ValueError, KeyError) as error:
        raise InputError(f"no servos in {folder / SERVOS}: {error}") from None


def steps(
    host: Host, folder: Path, tell: Callable[[Playing], None] = lambda _: None
) -> Steps[None]:
    """Play until the process is told to end. Raises InputError where it cannot begin.

    tell: told of the drives as they begin.
    """
    device, servos = device_file.find(folder), _servos(folder)
    with (
        playing(folder, host) as twin,
        closing(open_bus(device.bus, host, NAME, folder)) as bus,
        closing(host.datagrams.listen(folder / node_fault.REQUESTS)) as requests,
        host.hardened(),
    ):
        built = plain_row.unpack(MachineSide, twin.call.side_row).machine
        drives = EmulatedMachine(device, built, servos, bus, host.clock)
        pace = DeadlineScheduler(PERIOD_NS, host.clock.monotonic_ns())
        tell(Playing(drives, twin))
        while not host.terminations():
            yield pace.due_ns
            missed = min(pace.begin(host.clock.monotonic_ns()), CAUGHT_UP)
            # What has come while it was kept from its work counts before anybody is missed.
            drives.exchange()
            for _ in range(missed + 1):
                drives.tick()
                twin.step(drives.row, drives.has_news)
                drives.measure(twin.call.shown_row)
            twin.faults.look()
            _take_request(drives, requests, host)


def _take_request(drives: EmulatedMachine, requests: Inbox, host: Host) -> None:
    """A fault that somebody asks for."""
    data = requests.receive(node_fault.LARGEST)
    if data is None:
        return
    try:
        drives.break_down(node_fault.read(data))
    except InputError as problem:
        host.say(str(problem))


if __name__ == "__main__":
    _folder = Path(sys.argv[1])
    this_computer.run(lambda host: steps(host, _folder))
