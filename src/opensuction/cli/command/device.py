"""``device check`` and ``device home``: a machine on a CANopen bus, held against its file."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import entry
from opensuction.cli.delivery import show
from opensuction.cli.entry import Command
from opensuction.kernel.errors import InputError
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.machine.canopen.device import Device
    from opensuction.result.device_check_result import DeviceCheckResult, InputsFound

CHECK, HOME = "check", "home"
NAME = "check"
"""Of this command on a bus of one computer."""
MOVES = (
    "The head will move inwards by 6 mm and back, the valve will open a little, the pump will run. "
)
SAFE = "Is the catheter out of everybody, and a hand at the emergency stop? [yes/no] "
CONSENT = "yes"


class DeviceOptions(NamedTuple):
    """Options of ``device``."""

    device_act: str
    device_path: Path
    moves: bool = False
    as_json: bool = False


def run(options: DeviceOptions) -> int:
    """Carry out ``device``; returns the exit status.

    Raises InputError for bad input, a node that does not answer, and one that is not as the file
    says.
    """
    from contextlib import ExitStack, closing

    from opensuction.cli.progress import ProgressTeller
    from opensuction.host.host import finish
    from opensuction.host.this_computer import THIS_COMPUTER
    from opensuction.machine.canopen import device_check, device_file, homing
    from opensuction.machine.canopen.canopen_machine import hold
    from opensuction.machine.canopen.frame_bus import open_bus
    from opensuction.settings import wording

    act = options.device_act
    if act not in (CHECK, HOME):
        raise InputError(wording.unknown(f"act {wording.show(act)}", act, (CHECK, HOME)))
    device = device_file.load(options.device_path)
    homes = act == HOME
    if homes:
        homing.require(device)
    if (options.moves or homes) and not device.in_silico:
        _ask_person((homing.announce(device) if homes else "") + (MOVES if options.moves else ""))
    progress = ProgressTeller()
    folder = options.device_path.parent
    with ExitStack() as stack:
        if options.device_path.name == device_file.NAME:  # in a machine's folder
            stack.enter_context(closing(hold(folder, THIS_COMPUTER)))
        bus = stack.enter_context(closing(open_bus(device.bus, THIS_COMPUTER, NAME, folder)))
        found = finish(
            device_check.check(
                device,
                bus,
                THIS_COMPUTER,
                homes=homes,
                moves=options.moves,
                tell=progress.tell,
            ),
            THIS_COMPUTER.clock,
        )
    show(options.as_json, to_json(found), lambda console: _summarise(console, device, found))
    return entry.DONE if found.ok else entry.FAILED


def _ask_person(announced: str) -> None:
    """Ask whoever watches the machine. Raises InputError for anything but their consent."""
    if not sys.stdin.isatty():
        raise InputError("home and --move ask a person at the machine: call them in a terminal")
    sys.stderr.write(announced + SAFE)
    sys.stderr.flush()
    if sys.stdin.readline().strip().lower() != CONSENT:
        raise InputError("nothing was moved: the answer was not 'yes'")


def _summarise(console: "Console", device: "Device", found: "DeviceCheckResult") -> None:
    kind = "emulated, in-silico" if found.in_silico else "hardware"
    console.print(f"{found.device} ({kind}) on {found.interface} '{found.channel}'")
    for node in found.nodes:
        console.print(
            f"  node {node.node:3}  {node.name:15}  vendor {node.vendor:#x}, product "
            f"{node.product:#x}, revision {node.revision:#x}"
        )
    for line in _list_inputs(device, found.inputs):
        console.print(f"  {line}")
    for one in found.homed:
        second = _tell_second(one.by_second_sensor, "it is")
        console.print(
            f"  {one.axis} homed by method {one.method}: at {one.by_drive:.2f} {one.unit}, took "
            f"itself to be at {one.before:.2f}; {second}"
        )
    for move in found.moves:
        second = _tell_second(move.by_second_sensor, "it did")
        console.print(
            f"  {move.axis} moved by {move.by_drive:.2f} {move.unit} of {move.asked:g}, {second}"
        )
    if found.vacuum is not None:
        vacuum = found.vacuum
        console.print(
            f"  vacuum {vacuum.reached_mmhg:.0f} mmHg of {vacuum.asked_mmhg:g}, "
            f"{vacuum.left_mmhg:.0f} after venting"
        )
    for problem in found.problems:
        console.print(f"✗ {problem}")
    if found.ok:
        rest = "" if found.moves else "; nothing was moved, so no scale is known to be right"
        console.print(f"✓ As its device file says{rest}")


def _tell_second(position: float | None, look_for: str) -> str:
    if position is None:
        return f"no second sensor: look whether {look_for}"
    return f"{position:.2f} by the second sensor"


def _list_inputs(device: "Device", inputs: "InputsFound") -> list[str]:
    """Inputs in words, those that the machine does not have left out."""

    def quantity(found: float | None, unit: str) -> str:
        return "tells nothing" if found is None else f"{found:.2f} {unit}"

    switch = {None: "line open", True: "closed", False: "open"}[inputs.contact_closed]
    lines = [
        f"head {quantity(inputs.head_mm, 'mm')}, "
        f"second sensor {quantity(inputs.carriage_mm, 'mm')}",
        f"cam {quantity(inputs.cam_rad, 'rad')}",
        f"vacuum {quantity(inputs.line_vacuum_mmhg, 'mmHg')}",
        f"contact switch {switch}",
    ]
    if device.module.mouth_bit >= 0:
        lines.append(f"light barrier {'clear' if inputs.mouth_clear else 'dark'}")
    if device.module.monitor_bit >= 0:
        values = (
            quantity(inputs.spo2_percent, "%"),
            quantity(inputs.heart_rate_per_min, "1/min"),
            quantity(inputs.airway_pressure_cmh2o, "cmH2O"),
        )
        told = ", ".join(values) if inputs.monitor_connected else "not connected"
        lines.append(f"patient monitor {told}")
    return lines


COMMAND = Command(
    name="device",
    options=DeviceOptions,
    run=run,
    sentence="Check or home a machine on a CANopen bus: its nodes, inputs, small moves and vacuum.",
    details="check asks each node of a device file for its identity, sets it up and reads it "
    "again, and shows the inputs; a node that is not as the file says is refused with all "
    "differences. home does the same, and has each drive whose homing.method is not 0 find its "
    "position, as one with an incremental encoder must whenever it was switched on; then the "
    "head's second sensor has to agree. With --move the head is moved by 6 mm at half of its "
    "torque and held against its second sensor, which shows a wrong gear ratio, scale or sign; "
    "then the valve a little, and a vacuum is drawn. A person at the machine is asked before "
    "anything moves, unless the file says that it is emulated. No controller may have the machine "
    "meanwhile. Research software: never with a patient. The device file: "
    "docs/how-to/write-a-device-file.md.",
    examples="""\b
Examples:
  opensuction device check can0.toml
  opensuction device home can0.toml             supervised; catheter out
  opensuction device check can0.toml --move     supervised; catheter out
  opensuction device check can0.toml --json""",
    ends="0 as the file says, 1 a problem was found",
)
