"""A machine file: the preset it starts from, its catheter and conduit, and what it changes.

preset = "clinical"
catheter = "12fr"        # or a section [catheter] with outer_mm and bore_mm
conduit = "standard"     # or a section [conduit] with bore_mm, length_mm and bend_rad
transmission = "plays"   # may be left out; or another class, with parameters of its own
[twin]                   # what the machine does: any parameter of the preset
[controller]             # what its controller goes by

A patient file: the preset it starts from, which also gives the age, and what it changes.

preset = "adult-icu"
weight_kg = 82.0                                # not drawn
carina_mm = { value = 60.0, spread = 4.0 }      # drawn by the seed
"""

from collections.abc import Mapping
from os import PathLike
from typing import Any, TypeVar

from opensuction.controller.machine_profile import SOURCES, MachineProfile
from opensuction.kernel.errors import InputError
from opensuction.settings import conduit_file
from opensuction.settings.toml_file import LISTED, Table, change, load_toml
from opensuction.settings.validation import choose, validate
from opensuction.settings.wording import join_key, name_source, refuse, show, unknown
from opensuction.simulation import machine_kind
from opensuction.simulation.machine_kind import MachineKind
from opensuction.twin import preset, transmission_parameter
from opensuction.twin.behaviour.behaviour_parameter import ROWS, SWITCH
from opensuction.twin.machine import catheter as catheter_model
from opensuction.twin.machine.catheter import CATHETERS, ROUTES, Catheter, Conduit
from opensuction.twin.parameter_row import Parameter
from opensuction.twin.patient import patient_airway, patient_kind
from opensuction.twin.patient.patient_kind import PatientKind
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES


def _refuse_idle(table: Mapping[str, Parameter], given: Mapping[str, object]) -> None:
    """Refuse what a quiet patient would never do; raises InputError."""
    if given.get(SWITCH, table[SWITCH].value) != 0.0:
        return
    for name in given:
        if name in ROWS and name != SWITCH:
            raise InputError(
                f"{name} is given, but {SWITCH} is 0, so that the patient does nothing of it; "
                f"give {SWITCH} = 1 too"
            )


def load_patient(path: str | PathLike[str]) -> PatientKind:
    """The kind of patient that a file describes.

    Raises InputError of one line for a file that cannot be read, an unknown or missing key, a value
    out of its range, and values that do not fit together, with the arithmetic.
    """
    given = load_toml(path)
    if "preset" not in given:
        raise refuse(path, f"preset is missing; give one of {', '.join(PATIENT_TABLES)}")
    name = given.pop("preset")
    with name_source(path):
        choose(name, PATIENT_TABLES, "preset")
        start = patient_kind.of_preset(name)
        _refuse_idle(start.table, given)
        kind = start._replace(table=change(start.table, given, "", path))
        patient_kind.check(kind)
    return kind


CHOICES = {
    "preset": tuple(preset.MACHINE_TABLES),
    "catheter": (*CATHETERS, "a section [catheter]"),
    "conduit": (*ROUTES, "a section [conduit]"),
}
"""Keys that a machine file must have, and what they take."""
SECTIONS = ("twin", "controller")
TRANSMISSION = "transmission"
"""Key of the transmission's class; without it the clearances are it."""
OF_CONDUIT = ("bend_rad", "clearance_mm")
"""Parameters of the twin that follow from catheter and conduit."""

Record = TypeVar("Record", bound=tuple[Any, ...])


def load_machine(path: str | PathLike[str]) -> MachineKind:
    """The kind of machine that a file describes.

    Raises InputError of one line for a file that cannot be read, an unknown or missing key, a value
    out of its range, and a twin and a controller that do not agree, with the arithmetic.
    """
    given = load_toml(path)
    known = (*CHOICES, TRANSMISSION, *SECTIONS)
    for key in given:
        if key not in known:
            raise refuse(path, unknown(f"key {join_key('', key)}", key, known))
    for key, names in CHOICES.items():
        if key not in given:
            raise refuse(path, f"{key} is missing; give one of {', '.join(names)}")
    with name_source(path):
        choose(given["preset"], preset.MACHINE_TABLES, "preset")
        return _read_kind(given["preset"], given, path)


def _read_kind(name: str, given: Mapping[str, Any], path: object) -> MachineKind:
    start = machine_kind.of_preset(name, None)
    if TRANSMISSION in given:
        chosen = conduit_file.find(given[TRANSMISSION])
        start = start._replace(
            table=start.table | transmission_parameter.rows(chosen), transmission=chosen
        )
    catheter = _choose_or_read(Catheter, given["catheter"], "catheter", CATHETERS, path)
    conduit = _choose_or_read(
        Conduit,
        given["conduit"],
        "conduit",
        {route: catheter_model.lay(route, catheter) for route in ROUTES},
        path,
    )
    kind = start._replace(
        table=_read_twin(start, given.get("twin", {}), path),
        profile=_read_controller(start.profile, given.get("controller", {}), path),
    )
    kind = machine_kind.equipped(kind, catheter, conduit)
    machine_kind.check(kind)
    return kind


def _choose_or_read(
    record_type: type[Record], given: object, what: str, known: Mapping[str, Record], path: object
) -> Record:
    """One of the known ones by name, or its own section with every key."""
    if isinstance(given, Mapping):
        return validate(record_type, given, f"{path}: section {what}")
    return choose(given, known, what)


def _read_twin(start: MachineKind, given: object, path: object) -> Table:
    names = given if isinstance(given, Mapping) else ()
    for name in names:
        if name in OF_CONDUIT:
            raise refuse(path, f"twin.{name} follows from the conduit: give it in [conduit]")
        if start.preset != "bench" and name in patient_airway.REPLACED:
            raise refuse(path, f"twin.{name} is the patient's: give it in a patient file")
    return change(start.table, given, "twin", path)


def _read_controller(profile: MachineProfile, given: object, path: object) -> MachineProfile:
    if not isinstance(given, Mapping):
        raise refuse(path, f"controller is {show(given)}, not a section")
    for name in given:
        if name not in SOURCES:
            raise refuse(path, unknown(f"key controller.{name}", name, SOURCES, LISTED))
    return validate(MachineProfile, {**profile._asdict(), **given}, "controller")
