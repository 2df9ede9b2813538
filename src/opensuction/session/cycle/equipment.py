"""The machine and the patient that a person chose: their kinds, found once."""

from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.session.choice import LISTED, RigChoice
from opensuction.settings import machine_file, patient_file, transmission_choice
from opensuction.settings.choice import choose
from opensuction.settings.transmission_choice import MACHINES
from opensuction.simulation import machine_kind
from opensuction.simulation import rig as rigs
from opensuction.simulation.machine_kind import MachineKind
from opensuction.simulation.rig import Rig
from opensuction.twin import preset
from opensuction.twin.conduit import transmission_class
from opensuction.twin.machine.catheter import CATHETERS, ROUTES, lay
from opensuction.twin.patient import patient_kind
from opensuction.twin.patient.patient_kind import PatientKind
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

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
        machine = machine_file.load(name)
        for option, given in (("--catheter", choice.catheter), ("--conduit", choice.conduit)):
            if given is not None:
                raise InputError(f"{option} is the machine file's to say: change it in {name}")
        person_name = _patient_name(choice, machine.preset)
        person = _patient(person_name)
        return Equipment(name, machine, person_name, person, choice.seed, choice.spread)
    known = dict.fromkeys(preset.MACHINE_TABLES, transmission_class.PLAYS.name) | MACHINES
    chosen = choose(name, known, "machine", LISTED)
    base = BENCH if name in MACHINES else name
    person_name = _patient_name(choice, base)
    person = _patient(person_name)
    machine = machine_kind.of_preset(base, None if person is None else person.age)
    if name in MACHINES:
        machine = machine_kind.transmitting(machine, transmission_choice.find(chosen))
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
        return patient_file.load(name)
    choose(name, PATIENT_TABLES, "patient")
    return patient_kind.of_preset(name)
