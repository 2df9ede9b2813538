"""Basis of a machine's settings, stored in its folder, so that other settings can be made of it.

The controller never reads it. Whoever sets a protocol writes a new basis, which takes the place of
the old one in the tick in which the controller adopts the new settings.
"""

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from opensuction.control.backlash_inverse import Curves
from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.controller.calibration import Calibration, Feedforward
from opensuction.controller.machine_profile import MachineProfile
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import name_of
from opensuction.procedure.planning.clinical import TEMPLATES
from opensuction.procedure.planning.protocol import Protocol, Site
from opensuction.runtime.machine_folder import BASIS
from opensuction.session.choice import RigChoice
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.settings import calibration_section
from opensuction.settings.calibration_section import Branches, Lines, Plays
from opensuction.settings.validation import choose, to_mapping, validate


class Person(NamedTuple):
    """Patient at the bed, as far as known."""

    weight_kg: float
    tube_length_mm: float


class Basis(NamedTuple):
    """Basis that settings are made from."""

    version: int
    """Goes up by one with each change: whoever changes an older one is told so."""
    profile: MachineProfile
    site: Site
    """The patient's geometry, the carina where it was taught."""
    compensation: CompensationKind
    calibration: Calibration
    calibrated_by: str
    """Where that comes from, in words."""
    by_contact: bool
    template: str | None
    """Name of the clinical protocol that is fitted; None: a protocol of its own numbers."""
    protocol_name: str
    protocol: Protocol
    """In force, as it was fitted."""
    is_teaching: bool
    """In force are the limits under which a person teaches instead; no cycle starts."""
    taught_by: str
    """Who or what said where the carina is, in words."""
    rig: RigChoice
    """What the twin was drawn from; its seed."""
    person: Person | None
    """None on a bench."""


def of(prepared: Prepared) -> Basis:
    """Of a machine that is about to run."""
    resolved, rig = prepared.resolved, prepared.rig
    person = rig.machine.patient if rig.machine.has_patient else None
    calibrated_by = "nominal values: no identification was made"
    if resolved.parameter_file is not None:
        calibrated_by = f"parameter file {Path(resolved.choice.compensation).name}"
    elif prepared.identification is not None:
        calibrated_by = "identified before use, on the twin"
    taught_by = "the protocol's own travel"
    if prepared.taught_mm is not None:
        given = resolved.choice.taught_mm is not None
        taught_by = "given when the machine was started" if given else "taught on the twin by hand"
    return Basis(
        version=1,
        profile=rig.profile,
        site=rig.site,
        compensation=resolved.compensation,
        calibration=prepared.calibration,
        calibrated_by=calibrated_by,
        by_contact=resolved.by_contact,
        template=resolved.protocol_name if resolved.protocol_name in TEMPLATES else None,
        protocol_name=Path(resolved.protocol_name).name,
        protocol=prepared.protocol,
        is_teaching=False,
        taught_by=taught_by,
        rig=resolved.choice.rig._replace(
            machine=resolved.equipment.machine_name, patient=resolved.equipment.patient_name
        ),
        person=None if person is None else Person(person.weight_kg, person.tube_length_mm),
    )


def write(folder: Path, basis: Basis, name: str = BASIS) -> None:
    """Into the machine's folder, whole or not at all. name: of the file."""
    private_file.write(folder / name, to_json(basis))


def read(folder: Path) -> Basis:
    """From the machine's folder. Raises InputError where it is not there or not whole."""
    try:
        return from_json((folder / BASIS).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{folder} does not say what its settings are made from: {error}"
        ) from None


def to_json(basis: Basis) -> str:
    """As text."""
    told: dict[str, Any] = basis._asdict()
    model, feedforward, plays, width, table, lines = basis.calibration
    told["calibration"] = {
        "model": model._asdict(),
        "feedforward": feedforward._asdict(),
        "plays": calibration_section.write_section(Plays, plays)._asdict(),
        "width": calibration_section.write_section(Branches, width)._asdict(),
        "table": calibration_section.write_section(Branches, table)._asdict(),
        "lines": calibration_section.write(lines)._asdict(),
    }
    told["compensation"] = name_of(basis.compensation)
    told["site"] = to_mapping(basis.site) | {"age": name_of(basis.site.age)}
    for name in ("profile", "protocol", "rig", "person"):
        told[name] = to_mapping(told[name])
    return json.dumps(told, allow_nan=False)


def from_json(text: str) -> Basis:
    """The basis that was written. Raises InputError for what is none."""
    where = "what the settings are made from"
    try:
        told: dict[str, Any] = json.loads(text)
        found = told["calibration"]
        person = told["person"]
        told |= {
            "profile": validate(MachineProfile, told["profile"], where),
            "site": validate(Site, told["site"], where),
            "compensation": choose(told["compensation"], KIND_OF_NAME, "compensation"),
            "calibration": Calibration(
                validate(ModifiedDahl, found["model"], where),
                validate(Feedforward, found["feedforward"], where),
                PrandtlIshlinskii(*_arrays(validate(Plays, found["plays"], where))),
                Curves(*_arrays(validate(Branches, found["width"], where))),
                Curves(*_arrays(validate(Branches, found["table"], where))),
                calibration_section.read(validate(Lines, found["lines"], where), "lines"),
            ),
            "protocol": validate(Protocol, told["protocol"], where),
            "rig": RigChoice(**told["rig"]),
            "person": None if person is None else validate(Person, person, where),
        }
        return Basis(**told)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise InputError(f"{where} cannot be read: {error}") from None


def _arrays(section: tuple[Any, ...]) -> list[Any]:
    return [np.array(one) if isinstance(one, list) else one for one in section]
