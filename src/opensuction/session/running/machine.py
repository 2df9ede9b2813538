"""A machine in real time, from named choices: the twin that plays it, its settings, whose it is.

A machine on a bus has no twin here. Its patient stays when its controller ends, and the next one
keeps what it must know.

The twin outlives whoever runs the machine, for a patient does. Where one of an earlier run still
plays it is taken up as it is; a machine that is set otherwise is not.

A machine that was lost: what is known of it, and what the next one under its name must keep.

The twin is its patient, too. Where it died nobody could bring the catheter out, and another one
that begins in its place has its rest, so that nobody suctions sooner by starting anew.
"""

import hashlib
import json
import math
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np
import platformdirs

from opensuction.controller import configuration
from opensuction.controller.configuration import Configuration
from opensuction.host.host import NS_PER_S, Child
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.liveness import Heartbeat, Process, end_holder, holder
from opensuction.ipc.ring import RingReader
from opensuction.kernel import private_file
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.compiled import as_python
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import RESTING, Phase, name_of
from opensuction.machine import port
from opensuction.machine.drives.emulated_machine import without_patience
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_process import PLAYS
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.interlocks import NEW_CATHETER_S
from opensuction.procedure.planning.protocol import Protocol
from opensuction.records.entry import Catheter, Machine, SettingsFile
from opensuction.records.records import Records
from opensuction.runtime import controller_memory, launch, machine_folder, nonvolatile_memory
from opensuction.runtime.controller_memory import Before
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import About
from opensuction.safety.limits import TipInterval, deepest_mm
from opensuction.session.cycle import resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.running import basis, bus_machine
from opensuction.session.running.bus_machine import BusMachine
from opensuction.simulation.machine_side import MachineSide
from opensuction.twin import preset

VALID = [
    place
    for place, name in enumerate(ROW_COLUMNS)
    if name.startswith("inputs.readings.") and name.endswith("_valid")
]
"""Columns of a row that say whether there was a reading."""
DEEPEST_MM = as_python(deepest_mm)
TIP = [ROW_COLUMNS.index(f"state.core.governor.watch.tip.{name}") for name in TipInterval._fields]
INSIDE = (
    "the machine did not answer any more, and the catheter's tip was last inside: look at the "
    "patient and draw the catheter out by the handle"
)
OUTSIDE = "the machine did not answer any more; the catheter's tip was last outside"


class Predecessor(NamedTuple):
    """A machine that does not answer any more."""

    before: Before
    """What its controller left."""
    was_inside: bool
    """The tip may have been in the airway when it was seen last."""

    @property
    def rest_left_s(self) -> float:
        """Time for which the patient still has to rest, in s."""
        return schedule.pass_idle_time_episode(
            self.before.kept.episode, self.before.off_s
        ).rest_left_s

    @property
    def ending(self) -> str:
        """Ending of the earlier run, for a person."""
        return INSIDE if self.was_inside else OUTSIDE

    @property
    def succession(self) -> str:
        """Notice of the twin that has replaced it, for a person."""
        place = "inside: look at the patient" if self.was_inside else "outside"
        return (
            "Another twin has begun, and another patient with it: that of the earlier run is gone, "
            f"the catheter's tip was last {place}; {math.ceil(self.rest_left_s)} s of rest are kept"
        )


def find(folder: Path) -> Predecessor | None:
    """The machine of a folder that was lost; None where one answers, or none was."""
    before = controller_memory.read_before(folder)
    if before is None:
        return None
    is_on_bus = port.kind_of(folder) == port.CANOPEN
    try:
        row = RingReader(folder / machine_folder.RING).drain().rows[-1]
    except (InputError, OSError):  # only what was handed on is left of it
        return None if is_on_bus else Predecessor(before, before.phase not in RESTING)
    if (is_on_bus or holder(folder / PLAYS) is not None) and row[VALID].any():
        return None
    return Predecessor(before, _was_inside(folder, row))


def _was_inside(folder: Path, row: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> bool:
    """True if the tip may have been in the airway, or its place is not known."""
    try:
        text = (folder / machine_folder.CONFIGURATION).read_text(encoding="utf-8")
        limits = configuration.from_json(text).settings.limits
    except (InputError, OSError, UnicodeDecodeError):
        return True
    tip = TipInterval(*(float(row[place]) for place in TIP))
    return not DEEPEST_MM(limits.tip, tip) <= limits.outside_mm


def replaced(lost: Predecessor) -> Before:
    """State that the next controller keeps of a lost machine and its patient.

    Where the tip was inside it halts, says so, and waits for a person. The catheter is another one.
    """
    kept = lost.before.kept._replace(catheter_age_s=NEW_CATHETER_S)
    phase = Phase.ABORTING if lost.was_inside else Phase.PARKED
    return lost.before._replace(kept=kept, phase=phase)


ENDS_S = 5.0
"""How long the twin's end may take."""
COMES_OUT_S = 120.0
"""How long a controller's end may take: the catheter comes out first."""
FRENCH_PER_MM = 3.0


class Running(NamedTuple):
    """A machine that is played."""

    name: str
    folder: Path
    prepared: Prepared
    about: About
    twin: Child | None
    """Process that plays it; None where an earlier run left it."""
    lost: Predecessor | None = None
    """The machine in whose place it has begun."""
    bus: BusMachine | None = None
    """The machine on a bus that it is; None: the twin."""
    recalled: Before | None = None
    """What it knows of its patient from before the computer was off."""

    @property
    def in_silico(self) -> bool:
        """Nothing moves but numbers."""
        return self.about.machine.is_twin

    @property
    def side(self) -> MachineSide:
        """Simulated side of the machine."""
        return twin_machine.side_of(self.prepared.loop, self.prepared.resolved.equipment.seed)

    def end(self) -> None:
        """The catheter comes out, and then the patient is gone. Raises InputError: it is not."""
        if self.bus is not None:
            end(self.folder)
            _clear_on_bus(self.folder)
            return
        lost = find(self.folder)
        end(self.folder)
        if self.twin is not None:
            self.twin.wait()
        _clear(self.folder, lost)

    def ventilate(self, full: bool) -> None:
        """Set the ventilator to 100 % oxygen as a person does, or back to what it was before.

        Nothing is set where no twin is known behind the nodes of a bus.
        """
        folder, side = self.folder, self.side
        if self.bus is not None:
            if self.bus.twin is None:
                return
            folder, side = self.bus.twin, without_patience(side)
        if full:
            machine = preset.ventilate(side.machine, resolution.FULL_RATIO)
            side = side._replace(machine=machine)
        twin_machine.change(folder, side)


def check_records(database: str | None) -> str:
    """Address of records that can be written; raises InputError in one line where they cannot."""
    with Records.open_for_machine(database) as records:
        return records.database.address.shown


def check_free(name: str) -> Path:
    """The folder of a machine that nobody looks after; raises InputError where somebody does."""
    folder = machine_folder.make(name)
    if (pid := holder(folder / machine_folder.SUPERVISES)) is not None:
        raise InputError(f"the machine '{name}' is run by another opensuction (process {pid})")
    return folder


def begin(
    name: str,
    prepared: Prepared,
    database: str | None,
    anew: bool,
    bus: BusMachine | None = None,
) -> Running:
    """Have the twin play in the machine's folder, or lay a machine on a bus into it.

    anew: end what an earlier run has left, its twin included. Raises InputError where that is in
    the way, or where the twin does not play.
    """
    folder = check_free(name)
    _drop_console(folder)
    if anew:
        end(folder)
    chosen = Configuration(prepared.loop.controller, prepared.loop.heads_mm)
    begun_with = _begun_with(chosen, bus)
    plays = holder(folder / PLAYS) is not None
    controls = holder(folder / machine_folder.CONTROLS) is not None
    if plays or (controls and port.kind_of(folder) == port.CANOPEN):
        _check_same(name, folder, begun_with)
        return Running(name, folder, prepared, machine_folder.read(folder), None, bus=bus)
    if controls:
        raise InputError(f"a controller without a machine runs in {folder}: begin --anew")
    lost = recalled = None
    if bus is not None:
        recalled = _clear_on_bus(folder, _make_memory(name), forgets=anew)
    else:
        had_twin = port.kind_of(folder) == port.TWIN
        lost = find(folder) if had_twin and not anew else None
        _clear(folder, lost)
    launch.configure(folder, chosen)
    told = _about(name, prepared, database, bus)
    machine_folder.write(folder, told)
    basis.write(folder, basis.of(prepared))
    private_file.write(folder / machine_folder.BEGUN_WITH, begun_with)
    if bus is not None:
        bus_machine.lay(folder, bus)
        return Running(name, folder, prepared, told, None, bus=bus, recalled=recalled)
    seed = prepared.resolved.equipment.seed
    twin = twin_machine.start(folder, prepared.loop, prepared.start, seed)
    return Running(name, folder, prepared, told, twin, lost)


def _clear(folder: Path, lost: Predecessor | None) -> None:
    """Empty the folder but for what the next machine must keep of one that was lost."""
    machine_folder.clear(folder)
    if lost is not None:
        controller_memory.hand_on(folder, replaced(lost))


def memory_of(name: str) -> Path:
    """File of what the machine on a bus of this name must not forget while its computer is off."""
    return platformdirs.user_data_path("opensuction") / "machines" / f"{name}.json"


def _make_memory(name: str) -> Path:
    """The same, in a folder that is there. Raises InputError where it cannot be made."""
    memory = memory_of(name)
    try:
        private_file.make_folder(memory.parent)
    except OSError as error:
        raise InputError(f"{memory.parent} cannot be made: {error.strerror}") from None
    return memory


def _clear_on_bus(folder: Path, memory: Path | None = None, forgets: bool = False) -> Before | None:
    """Empty the folder but for what the next controller must know of the patient on the bus.

    memory: where it is looked for in case the folder knows nothing. forgets: it shall know nothing.
    What a twin has left there is of another patient. What was read from the memory.
    """
    before = recalled = None
    if not forgets and port.kind_of(folder) == port.CANOPEN:
        before = controller_memory.read_before(folder)
    if memory is not None and forgets:
        nonvolatile_memory.forget(memory)
    elif memory is not None and before is None:
        clock = THIS_COMPUTER.clock
        on_s = clock.monotonic_ns() / NS_PER_S  # it counts from when the computer was switched on
        before = recalled = nonvolatile_memory.recall(memory, clock.wall_ns(), on_s)
    machine_folder.clear(folder)
    port.name_backend(folder, port.CANOPEN)
    if before is not None:
        controller_memory.hand_on(folder, before)
    return recalled


def _begun_with(chosen: Configuration, bus: BusMachine | None) -> str:
    """Hash of settings and device file."""
    settings = configuration.hash_of(chosen)
    if bus is None:
        return settings
    return hashlib.sha256(f"{settings}\n{bus.text}".encode()).hexdigest()


def _drop_console(folder: Path) -> None:
    """One that an earlier run has left ends, and nobody misses it: whoever wants one sets it up."""
    end_holder(folder / machine_folder.CONSOLES, machine_folder.CONSOLE_ENDS_S, kills=True)
    (folder / machine_folder.CONSOLE).unlink(missing_ok=True)
    Heartbeat(folder).end(Process.CONSOLE)


def _check_same(name: str, folder: Path, wanted: str) -> None:
    """Check that a machine left by an earlier run is the wanted one; raises InputError.

    What people have set on it since stays as they set it.
    """
    try:
        begun_with = (folder / machine_folder.BEGUN_WITH).read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError):
        begun_with = ""
    if begun_with != wanted:
        raise InputError(
            f"the machine '{name}' of an earlier run still plays, with other settings: give the "
            "options of that run to take it up, another --name, or --anew to end it"
        )


def _about(name: str, prepared: Prepared, database: str | None, bus: BusMachine | None) -> About:
    resolved, site = prepared.resolved, prepared.rig.site
    used, choice = resolved.equipment, resolved.choice
    label = f"{name}-{datetime.now(tz=UTC):%Y%m%dT%H%M%S}"
    protocol = json.dumps(plain_row.write(Protocol, prepared.protocol), indent=1, sort_keys=True)
    parameters = None
    if resolved.parameter_file is not None:
        path = Path(choice.compensation)
        parameters = SettingsFile(path.name, path.read_text(encoding="utf-8"))
    is_twin = bus is None or bus.device.in_silico
    has_twin_patient = is_twin and used.patient_name is not None
    device = {} if bus is None else {"device": bus.device.name}
    return About(
        machine=Machine(name, used.machine_name, is_twin),
        catheter=Catheter(
            label,
            size_fr=round(FRENCH_PER_MM * site.catheter_mm),
            life_s=round(prepared.loop.controller.service.life_s),
        ),
        protocol=SettingsFile(Path(resolved.protocol_name).name, protocol),
        approach=choice.approach,
        patient=f"twin-{used.patient_name}-{used.seed}" if has_twin_patient else None,
        parameter_file=parameters,
        database=_absolute(database),
        memory=None if bus is None else str(memory_of(name)),
        heading={
            "machine": str(used.machine_name),
            "patient": str(used.patient_name or "none"),
            "age": name_of(site.age),
            "carina_mm": f"{site.carina_mm:g}",
            "protocol": str(resolved.protocol_name),
            "approach": choice.approach,
            "compensation": str(choice.compensation),
            "seed": str(used.seed),
            **device,
        },
    )


def _absolute(database: str | None) -> str | None:
    """For processes that may be started anew from anywhere."""
    if database is None or "://" in database:
        return database
    return str(Path(database).absolute())


def end(folder: Path) -> None:
    """End what plays and runs in a folder: the catheter comes out before the patient goes.

    Raises InputError where it does not end.
    """
    for lock, seconds in (
        (machine_folder.CONTROLS, COMES_OUT_S),
        (machine_folder.CONSOLES, machine_folder.CONSOLE_ENDS_S),
        (machine_folder.RECORDS, ENDS_S),
        (PLAYS, ENDS_S),
    ):
        end_holder(folder / lock, seconds, kills=lock == machine_folder.CONSOLES)
