"""What a person chose for a cycle, as names and files, and whether it can be meant."""

from typing import NamedTuple

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning import teaching_limit
from opensuction.procedure.planning.clinical import TEMPLATES, Template
from opensuction.procedure.planning.protocol import PROTOCOLS, Protocol
from opensuction.session.cycle import compensation_choice
from opensuction.settings import machine_file, patient_file
from opensuction.settings.choice import choose
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import validate
from opensuction.simulation import machine_kind
from opensuction.simulation import rig as rigs
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.simulation.machine_kind import MachineKind
from opensuction.twin import preset
from opensuction.twin.machine.catheter import CATHETERS, ROUTES, laid
from opensuction.twin.patient import patient_kind
from opensuction.twin.patient.patient_kind import PatientKind
from opensuction.twin.patient.patient_parameter import TABLES

APPROACHES = {"travel": False, "contact": True}
"""Ways to find the stopping point, and whether it is the contact switch that does."""


class Choice(NamedTuple):
    """What a person chose, as names."""

    machine: str | None
    """Name of a preset or path of a TOML file. None: the bench for a protocol that is for the bench
    only, else the clinical machine."""
    protocol: str | None
    """Name of a preset or path of a TOML file. None: by the patient's age, the paper's on the
    bench."""
    approach: str
    compensation: str
    """Name of a compensator, or path of a parameter file that names one and holds its model."""
    seed: int
    patient: str | None = None
    """Name of a preset or path of a TOML file; None: the default patient, nobody on the bench."""
    catheter: str | None = None
    """None: the one for the patient's age, or the machine file's."""
    conduit: str | None = None
    """None: the standard one, or the machine file's."""
    taught_mm: float | None = None
    """Travel length that a person measured, tube's lower end to carina; None: taught by hand."""
    faults: tuple[Injection, ...] = ()
    """What goes wrong; see `fault_choice`."""
    gap_scale: float = 1.0
    """Of every gap width, changed after the identification: the conduit was laid otherwise."""


GAP_SCALES = (0.5, 1.5)
"""Least and most of it: more than what self-calibration is trusted with, either way."""


def is_file(name: str) -> bool:
    """Whether a name is the path of a file and not a preset."""
    return name.endswith(".toml")


def find_protocol(name: str) -> Protocol | Template:
    """Protocol preset by name, or from a file if the name ends in ``.toml``.

    Raises InputError for an unknown name or a file that is not a protocol.
    """
    if is_file(name):
        return validate(Protocol, load_toml(name), name)
    known: dict[str, Protocol | Template] = {**TEMPLATES, **PROTOCOLS}
    return choose(name, known, "protocol")


def machine_of(choice: Choice) -> str:
    """The machine that was named; else the bench for a protocol that is for the bench only."""
    if choice.machine is not None:
        return choice.machine
    if choice.protocol is None:
        return "clinical"
    found = find_protocol(choice.protocol)
    return "bench" if isinstance(found, Protocol) and found.bench_only else "clinical"


def protocol_of(choice: Choice) -> str:
    """The protocol that was named; else the one for the patient's age, the paper's on the bench."""
    if choice.protocol is not None:
        return choice.protocol
    person = kinds(choice)[1]
    if person is None:
        return "paper"
    return next(name for name, one in TEMPLATES.items() if person.age in one.vacuum_mmhg)


def patient_of(choice: Choice, on_bench: bool) -> str | None:
    """The patient that was named, or the default; nobody on the bench."""
    if on_bench and choice.patient is not None:
        raise InputError("the bench has no patient: leave --patient out or use --machine clinical")
    return None if on_bench else choice.patient or rigs.DEFAULT_PATIENT


def kinds(choice: Choice) -> tuple[MachineKind, PatientKind | None]:
    """Kinds of machine and patient that were chosen; raises InputError for bad names and files."""
    name = machine_of(choice)
    if is_file(name):
        machine = machine_file.load(name)
        person = _patient_kind(patient_of(choice, machine.preset == "bench"))
        for option, given in (("--catheter", choice.catheter), ("--conduit", choice.conduit)):
            if given is not None:
                raise InputError(f"{option} is the machine file's to say: change it in {name}")
        return machine, person
    choose(name, preset.TABLES, "machine")
    person = _patient_kind(patient_of(choice, name == "bench"))
    machine = machine_kind.of_preset(name, None if person is None else person.age)
    catheter = machine.catheter
    if choice.catheter is not None:
        catheter = choose(choice.catheter, CATHETERS, "catheter")
    route = choice.conduit if choice.conduit is not None else "standard"
    choose(route, ROUTES, "conduit")
    return machine_kind.equipped(machine, catheter, laid(route, catheter)), person


def _patient_kind(name: str | None) -> PatientKind | None:
    if name is None:
        return None
    if is_file(name):
        return patient_file.load(name)
    choose(name, TABLES, "patient")
    return patient_kind.of_preset(name)


def check(choice: Choice) -> tuple[Protocol | Template, CompensationKind]:
    """Refuse unknown names and bad files before anything slow begins; raises InputError."""
    name = protocol_of(choice)
    found = find_protocol(name)
    choose(choice.approach, APPROACHES, "approach")
    on_bench = kinds(choice)[0].preset == "bench"
    kind = compensation_choice.chosen(choice.compensation)[0]
    bench_only = isinstance(found, Protocol) and found.bench_only
    if bench_only and not on_bench:
        raise InputError(
            f"protocol '{name}' is for the bench only: it breaks a guideline's limit; "
            "use --machine bench or another protocol"
        )
    if not bench_only and on_bench:
        raise InputError(
            f"protocol '{name}' is for a patient and the bench has none: use "
            "--machine clinical or --protocol paper"
        )
    person = kinds(choice)[1]
    if person is not None and isinstance(found, Template):
        # What a hand would teach of such a carina is not taken either.
        teaching_limit.check_plausible(person.age, person.table["carina_mm"].value, "carina_mm")
    if choice.taught_mm is not None:
        _check_taught(choice, choice.taught_mm, isinstance(found, Template))
    least, most = GAP_SCALES
    if not least <= choice.gap_scale <= most:
        raise InputError(f"--gap-scale {choice.gap_scale:g}: should be {least:g} to {most:g}")
    return found, kind


def _check_taught(choice: Choice, taught_mm: float, fitted: bool) -> None:
    """Refuse a length that nothing uses, or that no such patient has."""
    if not fitted:
        raise InputError(
            f"--taught {taught_mm:g} mm would do nothing: protocol '{choice.protocol}' names its "
            "own travel_mm"
        )
    person = kinds(choice)[1]
    if person is not None:
        teaching_limit.check_plausible(person.age, taught_mm, "--taught")


def heading(choice: Choice) -> str:
    """What is about to run, in one line."""
    on_bench = kinds(choice)[0].preset == "bench"
    person = patient_of(choice, on_bench)
    who = f", patient {person}" if person is not None else ""
    reason = ""
    if choice.protocol is None:
        reason = " (the bench's)" if person is None else " (by the patient's age)"
    changed = f", gaps x {choice.gap_scale:g}" if choice.gap_scale != 1.0 else ""
    return (
        f"One suction cycle on the digital twin: machine {machine_of(choice)}{who}, protocol "
        f"{protocol_of(choice)}{reason}, approach {choice.approach}, compensation "
        f"{choice.compensation}, seed {choice.seed}{changed}"
    )
