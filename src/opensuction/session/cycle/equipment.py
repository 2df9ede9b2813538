"""The machine and the patient that a person chose: their kinds, found once.

The compensation that a person chose: a name, or a parameter file that holds name and model.

The models that drive, fitted to recordings of a machine.
"""

from typing import NamedTuple

import numpy as np

from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.controller.calibration import Calibration, Feedforward
from opensuction.controller.machine_profile import MachineProfile
from opensuction.identification.judgement import recommendation
from opensuction.identification.judgement.recommendation import DriveChoice
from opensuction.kernel.errors import InputError
from opensuction.session.choice import LISTED, RigChoice
from opensuction.settings import (
    calibration_section,
    conduit_file,
    equipment_file,
    identification_file,
)
from opensuction.settings.calibration_section import CalibratedMachine
from opensuction.settings.conduit_file import MACHINES
from opensuction.settings.identification_file import Identified
from opensuction.settings.validation import choose
from opensuction.simulation import machine_kind
from opensuction.simulation import rig as rigs
from opensuction.simulation.machine_kind import MachineKind
from opensuction.simulation.rig import IDENTIFICATION_RUN, Recording, Rig
from opensuction.twin import preset
from opensuction.twin.conduit import play_line
from opensuction.twin.machine.catheter import CATHETERS, ROUTES, lay
from opensuction.twin.patient import patient_kind
from opensuction.twin.patient.patient_kind import PatientKind
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

EVERY = 10
"""Ticks from one sample to the next that is fitted: 100 Hz show all that the models follow."""


def choose_model(parts: tuple[Recording, ...], only_lines: bool) -> DriveChoice:
    """The model to drive by, of the excitation and the strokes after it.

    only_lines: of those with lines over their plays alone. Raises InputError where none drives.
    """
    whole = rigs.join(parts)
    head, tip = (
        np.ascontiguousarray(column[::EVERY]) for column in (whole.head_mm, whole.laser_mm)
    )
    return recommendation.choose(head, tip, only_lines)


def with_lines(rig: Rig, calibration: Calibration) -> Calibration:
    """The calibration of a rig with the best of its models with lines, for `model-preview`.

    Excites the machine once more, with shorter strokes after the whole one. Raises InputError where
    no such model drives.
    """
    drive = choose_model(rigs.recordings(rig, IDENTIFICATION_RUN, inner=True), only_lines=True)
    assert drive.lines is not None
    return calibration._replace(lines=drive.lines)


BENCH = "bench"
MOST_SPREAD = 3.0
"""How many times as far as usual a machine is drawn at most: a third of them lies at the limit."""


class Equipment(NamedTuple):
    """Kinds of machine and patient with their names, and the seed that draws one of each."""

    machine_name: str
    machine: MachineKind
    patient_name: str | None
    patient: PatientKind | None
    """None: nobody, on the bench."""
    seed: int
    spread: float = 1.0
    """How many times as far from the nominal one as usual it is drawn."""

    @property
    def on_bench(self) -> bool:
        """True for the paper's bench, and for machines made from it."""
        return self.machine.preset == BENCH

    def draw(self) -> Rig:
        """The one machine, with its patient, that the seed draws."""
        return rigs.rig_of(self.machine, self.patient, self.seed, spread=self.spread)


def is_file(name: str) -> bool:
    """True for the path of a file, False for the name of a preset."""
    return name.endswith(".toml")


def resolve(choice: RigChoice, default_machine: str = "clinical") -> Equipment:
    """Equipment of a choice; raises InputError for unknown names, bad files and conflicts."""
    if not 0.0 <= choice.spread <= MOST_SPREAD:
        raise InputError(f"--spread is {choice.spread:g}, and 0 to {MOST_SPREAD:g} are possible")
    name = default_machine if choice.machine is None else choice.machine
    if is_file(name):
        machine = equipment_file.load_machine(name)
        for option, given in (("--catheter", choice.catheter), ("--conduit", choice.conduit)):
            if given is not None:
                raise InputError(f"{option} is the machine file's to say: change it in {name}")
        person_name = _patient_name(choice, machine.preset)
        person = _patient(person_name)
        return Equipment(name, machine, person_name, person, choice.seed, choice.spread)
    known = dict.fromkeys(preset.MACHINE_TABLES, play_line.SUM_OF_PLAYS.name) | MACHINES
    chosen = choose(name, known, "machine", LISTED)
    base = BENCH if name in MACHINES else name
    person_name = _patient_name(choice, base)
    person = _patient(person_name)
    machine = machine_kind.of_preset(base, None if person is None else person.age)
    if name in MACHINES:
        machine = machine_kind.transmitting(machine, conduit_file.find(chosen))
    catheter = machine.catheter
    if choice.catheter is not None:
        catheter = choose(choice.catheter, CATHETERS, "catheter")
    route = "standard" if choice.conduit is None else choice.conduit
    choose(route, ROUTES, "conduit")
    machine = machine_kind.equipped(machine, catheter, lay(route, catheter))
    return Equipment(name, machine, person_name, person, choice.seed, choice.spread)


def _patient_name(choice: RigChoice, machine_preset: str) -> str | None:
    """The patient that was named, or the default; nobody on the bench."""
    if machine_preset != BENCH:
        return rigs.DEFAULT_PATIENT if choice.patient is None else choice.patient
    if choice.patient is not None:
        raise InputError("the bench has no patient: leave --patient out or use --machine clinical")
    return None


def _patient(name: str | None) -> PatientKind | None:
    if name is None:
        return None
    if is_file(name):
        return equipment_file.load_patient(name)
    choose(name, PATIENT_TABLES, "patient")
    return patient_kind.of_preset(name)


SAME_CATHETER_MM = 0.01
"""Outer diameters nearer than this are the same catheter: sizes are a third of a mm apart."""


def resolve_compensation(name: str) -> tuple[CompensationKind, Identified | None]:
    """The compensator that was named, and the parameter file where one was given.

    Raises InputError for an unknown name and for a file whose model no compensator can use.
    """
    if not is_file(name):
        return choose(name, KIND_OF_NAME, "compensation", LISTED), None
    identified = identification_file.load(name)
    identification_file.to_calibration(identified, name)
    return KIND_OF_NAME[identified.about.compensator], identified


def calibration(identified: Identified, name: str, kind: MachineKind) -> Calibration:
    """Calibration of a parameter file, held against the machine that it is to drive.

    name: path of the file, for messages. kind: what the machine was built as.
    Raises InputError for a model that cannot be this machine's, and for a machine that was
    calibrated as another kind or with another catheter.
    """
    found = identification_file.to_calibration(identified, name)
    if identified.servo is None:
        found = found._replace(feedforward=nominal_feedforward(kind.profile))
    if identified.measured is not None:
        _check_origin(identified.measured.machine, name, kind)
    calibration_section.check(found, kind.profile.transmission, name)
    return found


def nominal_feedforward(profile: MachineProfile) -> Feedforward:
    """Feedforward by the motor's nominal speed; only a calibration measures friction."""
    return Feedforward(
        velocity_v_s_per_mm=profile.supply_v / profile.no_load_mm_per_s, friction_v=0.0
    )


def _check_origin(origin: CalibratedMachine, name: str, kind: MachineKind) -> None:
    if origin.preset != kind.preset:
        raise InputError(
            f"{name}: was calibrated on a {origin.preset} machine, and this one is {kind.preset}; "
            "calibrate the machine itself"
        )
    if abs(origin.catheter_mm - kind.catheter.outer_mm) > SAME_CATHETER_MM:
        raise InputError(
            f"{name}: was calibrated with a catheter of {origin.catheter_mm:.2f} mm, and this "
            f"machine has one of {kind.catheter.outer_mm:.2f} mm; calibrate it with that catheter"
        )
