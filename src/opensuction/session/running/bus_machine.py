"""A machine on a bus, by its device file, before it is run: which choices fit it.

Choices are made for a twin, which is identified and taught before use. Of nodes that are real none
of that is known: their model comes from a parameter file, their depth from a person. Behind
emulated drives of this computer a twin plays in a folder that the bus names.
"""

from pathlib import Path
from typing import NamedTuple

from opensuction.control.compensation import CompensationKind
from opensuction.kernel import private_file
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.machine import port
from opensuction.machine.canopen import device_file
from opensuction.machine.canopen.device import Device
from opensuction.machine.canopen.frame_bus import UNIX
from opensuction.machine.drives.emulated_machine import without_patience
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_process import BEGUN
from opensuction.safety.limits import Limits, head_cap_mm
from opensuction.session.cycle import resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.cycle.resolution import ResolvedCycle
from opensuction.session.running import drives
from opensuction.simulation.machine_side import MachineSide


class BusMachine(NamedTuple):
    """A machine on a bus."""

    device: Device
    text: str
    """Of its device file; a bus of this computer by its whole path."""

    @property
    def twin(self) -> Path | None:
        """Folder of the twin behind its nodes; None where none is known."""
        bus = self.device.bus
        folder = Path(bus.channel).parent
        is_here = self.device.in_silico and bus.interface == UNIX
        return folder if is_here and (folder / BEGUN).exists() else None


def load(path: Path) -> BusMachine:
    """The machine of a device file. Raises InputError for what is none."""
    text = drives.addressed(path)
    device = device_file.load(path)
    if device.bus.interface == UNIX:
        channel = str(path.parent.absolute() / device.bus.channel)
        device = device._replace(bus=device.bus._replace(channel=channel))
    return BusMachine(device, text)


def check_choice(machine: BusMachine, resolved: ResolvedCycle, starts_itself: bool) -> None:
    """Refuse before anything begins what only a twin can be asked for. Raises InputError.

    starts_itself: cycles are started without a person.
    """
    name = f"'{machine.device.name}'"
    if machine.device.in_silico:
        return
    if starts_itself:
        raise InputError(
            f"{name} is real (in_silico = false), and run starts cycles without a person beside "
            "it: use opensuction serve, where a person starts each"
        )
    if resolved.parameter_file is None and resolved.compensation != CompensationKind.NONE:
        raise InputError(
            f"{name} is real, and the compensation would be identified on the twin: give "
            "--compensation a parameter file of this machine, or none"
        )
    if not resolved.equipment.on_bench and resolved.choice.taught_mm is None:
        raise InputError(
            f"{name} is real, and the way to the carina would be taught on the twin: give it with "
            "--taught"
        )


def check_prepared(machine: BusMachine, prepared: Prepared, starts_itself: bool) -> None:
    """Check that its drives reach where the settings lead, and that its twin is the chosen one.

    Raises InputError where not, and where nobody could give oxygen. starts_itself: as above.
    """
    device = machine.device
    _check_range(device, prepared.loop.controller.limits)
    if not device.in_silico:
        return
    if machine.twin is not None:
        seed = prepared.resolved.equipment.seed
        chosen = without_patience(twin_machine.side_of(prepared.loop, seed))
        if not _is_same(chosen, twin_machine.read_side(machine.twin)):
            raise InputError(
                f"the drives in {machine.twin} play another machine or patient: give the options "
                "that they were started with"
            )
    elif starts_itself and resolution.lead_s(
        prepared.loop, prepared.resolved.choice.preoxygenation
    ):
        raise InputError(
            f"no ventilator is known behind the nodes of '{device.name}', so nobody gives 100 % "
            "oxygen before a cycle: give --preoxygenation skipped"
        )


def _check_range(device: Device, limits: Limits) -> None:
    """Raises InputError where the head has to go beyond the range of its drive."""
    lowest, highest = device.insertion.lowest, device.insertion.highest
    deepest_mm = float(head_cap_mm(limits.tip, limits.cap_mm))
    for key, wanted_mm, is_within in (
        ("lowest", limits.park_head_mm, lowest <= limits.park_head_mm <= highest),
        ("highest", deepest_mm, deepest_mm <= highest),
    ):
        if not is_within:
            raise InputError(
                f"the head goes to {wanted_mm:.1f} mm, and insertion.{key} of '{device.name}' is "
                f"{getattr(device.insertion, key):g}: correct the device file, or the machine's"
            )


def _is_same(one: MachineSide, other: MachineSide) -> bool:
    return bytes(plain_row.pack(MachineSide, one)) == bytes(plain_row.pack(MachineSide, other))


def lay(folder: Path, machine: BusMachine) -> None:
    """Have the controller of a folder drive the machine."""
    private_file.write(folder / device_file.NAME, machine.text)
    port.name_backend(folder, port.CANOPEN)
