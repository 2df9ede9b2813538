"""``drives``: emulated drives on a CANopen bus, in the foreground."""

from pathlib import Path
from typing import NamedTuple

from opensuction.cli import entry
from opensuction.cli.entry import Command
from opensuction.cli.interruption import Stopped, describe
from opensuction.kernel.vocabulary import NOT_A_DEVICE
from opensuction.session.choice import CycleChoice, RigChoice

NOTICE = f"In-silico: behind the nodes there is a digital twin, no motor. {NOT_A_DEVICE}"


class DrivesOptions(NamedTuple):
    """Options of ``drives``."""

    rig: RigChoice = RigChoice()
    device: Path | None = None
    drives_name: str = "drives"


def drives(options: DrivesOptions) -> int:
    """Carry out ``drives``; returns the exit status. Raises InputError for bad input."""
    from opensuction.cli.progress import ProgressTeller
    from opensuction.host.this_computer import THIS_COMPUTER
    from opensuction.session.cycle import cycle_run, resolution
    from opensuction.session.running import drives as running

    progress = ProgressTeller()
    resolved = resolution.resolve(CycleChoice(rig=options.rig))
    folder = running.find_free(options.drives_name, options.device)
    prepared = progress.wait(
        lambda: cycle_run.prepare(resolved, progress.tell, "Emulated drives"), "Preparing"
    )
    made = running.prepare(folder, prepared, options.device)

    def greet() -> None:
        for line in (*made.told, NOTICE, "Ctrl-C takes them off the bus"):
            progress.tell(line)

    progress.tell("Starting the drives")
    try:
        running.play(made, THIS_COMPUTER, greet)
    except Stopped as stopped:
        progress.tell(f"{describe(stopped)}: the drives are off the bus")
    finally:
        running.end(made)
    return entry.DONE


COMMAND = Command(
    name="drives",
    options=DrivesOptions,
    run=drives,
    sentence="Emulated drives on a CANopen bus: the twin behind CiA 402 and CiA 401 nodes.",
    details="Two drives and a module of inputs and outputs come on the bus that the device file "
    "names, with the twin at rest behind them, and stay until Ctrl-C: for a controller, or for "
    "any other CANopen master. They follow targets by SYNC, stop at contact by themselves, and "
    "when the host falls silent they do what it has set them to. Interface unix is for processes "
    "of this computer; all others are python-can's: udp_multicast (on this computer only), "
    "socketcan, ... They need pip install 'opensuction[canopen]'. The object dictionaries are "
    "axis.eds and module.eds in opensuction/machine/drives. The device file: "
    "docs/how-to/write-a-device-file.md. Linux only.",
    examples="""\b
Examples:
  opensuction drives                        an adult's machine, bus 'unix'
  opensuction drives --machine bench --seed 3
  opensuction drives --device can0.toml     another bus, other nodes

\b
Files:
  /dev/shm/opensuction-UID/NAME/device.toml   to be given to a controller""",
    ends="0 ended by Ctrl-C",
)
