"""Resolution of the choices for a cycle: protocol, machine, patient, compensation, faults."""

from typing import NamedTuple

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning import pass_rule, teaching_limit
from opensuction.procedure.planning.clinical import ADULT, TEMPLATES, Template
from opensuction.procedure.planning.protocol import PROTOCOLS, Protocol
from opensuction.session.choice import CycleChoice
from opensuction.session.cycle import (
    compensation_choice,
    equipment,
    fault_choice,
    preoxygenation,
)
from opensuction.session.cycle.equipment import Equipment
from opensuction.settings.choice import choose
from opensuction.settings.identification_file import Identified
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import validate
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.twin.fault.fault import Fault
from opensuction.twin.patient.patient_kind import PatientKind

APPROACHES = {"travel": False, "contact": True}
"""Ways to find the stopping point, and whether it is the contact switch that does."""
GAP_SCALES = (0.5, 1.5)
"""Least and most: more than what self-calibration is trusted with, either way."""
MOST_SHIFT_MM = 10.0
"""Likewise of an offset."""


class ResolvedCycle(NamedTuple):
    """Resolved choice of a cycle: complete, and its parts fit together."""

    choice: CycleChoice
    """As it was made, with the faults of its set-up."""
    equipment: Equipment
    protocol_name: str
    protocol: Protocol | Template
    by_contact: bool
    compensation: CompensationKind
    parameter_file: Identified | None
    """The file that the compensation has its model from."""
    faults: tuple[Injection, ...]

    @property
    def chosen(self) -> str:
        """Whatever was chosen, in one line."""
        choice, used = self.choice, self.equipment
        who, reason = f", patient {used.patient_name}", " (by the patient's age)"
        if used.patient is None:
            who, reason = "", " (the bench's)"
        if choice.protocol is not None:
            reason = ""
        changed = f", spread x {used.spread:g}" if used.spread != 1.0 else ""
        changed += f", gaps x {choice.gap_scale:g}" if choice.gap_scale != 1.0 else ""
        if choice.tip_shift_mm != 0.0:
            changed += f", tip {choice.tip_shift_mm:+g} mm"
        return (
            f"machine {used.machine_name}{who}, protocol {self.protocol_name}{reason}, "
            f"approach {choice.approach}, compensation {choice.compensation}, "
            f"seed {used.seed}{changed}"
        )


def find_protocol(name: str) -> Protocol | Template:
    """Protocol preset by name, or from a file if the name ends in ``.toml``.

    Raises InputError for an unknown name or a file that is not a protocol.
    """
    if equipment.is_file(name):
        given = load_toml(name)
        # Files from before there was this key mean what is usual now: on, but on the bench.
        usual_s = 0.0 if given.get("bench_only") is True else ADULT.nothing_comes_s
        return validate(Protocol, {"nothing_comes_s": usual_s} | given, name)
    known: dict[str, Protocol | Template] = {**TEMPLATES, **PROTOCOLS}
    return choose(name, known, "protocol")


def _usual_protocol(patient: PatientKind | None) -> str:
    """The protocol for a patient's age, the paper's on the bench."""
    if patient is None:
        return "paper"
    return next(name for name, one in TEMPLATES.items() if patient.age in one.vacuum_mmhg)


def _is_for_bench(protocol: Protocol | Template | None) -> bool:
    return isinstance(protocol, Protocol) and protocol.bench_only


def resolve(choice: CycleChoice) -> ResolvedCycle:
    """Find what was chosen; raises InputError for bad names and files and for what does not fit."""
    faults = fault_choice.resolve(choice.faults, choice.approach)
    resolved = _resolve(choice, faults)
    changed = _set_up(choice, faults)
    return resolved if changed == choice else _resolve(changed, faults)


def _set_up(choice: CycleChoice, faults: tuple[Injection, ...]) -> CycleChoice:
    """The choice with the faults of its set-up; what is refused is for planning to say."""
    for fault in (one.fault for one in faults):
        if fault == Fault.WRONG_PRESET:
            choice = choice._replace(rig=choice.rig._replace(patient="neonate"), protocol="adult")
        elif fault == Fault.CATHETER_TOO_WIDE:
            choice = choice._replace(rig=choice.rig._replace(catheter=fault_choice.WIDEST))
    return choice


def _resolve(choice: CycleChoice, faults: tuple[Injection, ...]) -> ResolvedCycle:
    named = None if choice.protocol is None else find_protocol(choice.protocol)
    by_contact = choose(choice.approach, APPROACHES, "approach")
    usual_machine = "bench" if _is_for_bench(named) else "clinical"
    found = equipment.resolve(choice.rig, usual_machine)
    name = choice.protocol or _usual_protocol(found.patient)
    kind, file = compensation_choice.resolve(choice.compensation)
    resolved = ResolvedCycle(
        choice=choice,
        equipment=found,
        protocol_name=name,
        protocol=find_protocol(name) if named is None else named,
        by_contact=by_contact,
        compensation=kind,
        parameter_file=file,
        faults=faults,
    )
    _check(resolved)
    return resolved


def _check(resolved: ResolvedCycle) -> None:
    """Refuse what does not fit together; raises InputError."""
    name, protocol = resolved.protocol_name, resolved.protocol
    person, taught_mm = resolved.equipment.patient, resolved.choice.taught_mm
    if _is_for_bench(protocol) and not resolved.equipment.on_bench:
        raise InputError(
            f"protocol '{name}' is for the bench only: it breaks a guideline's limit; "
            "use --machine bench or another protocol"
        )
    if not _is_for_bench(protocol) and resolved.equipment.on_bench:
        raise InputError(
            f"protocol '{name}' is for a patient and the bench has none: use "
            "--machine clinical or --protocol paper"
        )
    if person is not None:
        # What a hand would teach of such a carina is not taken either.
        carina_mm = person.table["carina_mm"].value
        teaching_limit.check_plausible(person.age, carina_mm, "carina_mm")
    if taught_mm is not None and person is None:
        raise InputError(
            f"--taught {taught_mm:g} mm would do nothing: protocol '{name}' names its own "
            "travel_mm, and the bench has no patient whose depth it is held against"
        )
    if taught_mm is not None and person is not None:
        teaching_limit.check_plausible(person.age, taught_mm, "--taught")
    _check_oxygen(resolved)
    least, most = GAP_SCALES
    if not least <= resolved.choice.gap_scale <= most:
        scale = resolved.choice.gap_scale
        raise InputError(f"--gap-scale {scale:g}: should be {least:g} to {most:g}")
    shift_mm = resolved.choice.tip_shift_mm
    if not abs(shift_mm) <= MOST_SHIFT_MM:
        raise InputError(
            f"--tip-shift {shift_mm:g}: should be {-MOST_SHIFT_MM:g} to {MOST_SHIFT_MM:g} mm"
        )


def _check_oxygen(resolved: ResolvedCycle) -> None:
    """Refuse an answer that is none, or that nobody asks for; raises InputError."""
    chosen, person = resolved.choice.preoxygenation, resolved.equipment.patient
    if chosen is not None:
        choose(chosen, preoxygenation.ANSWERS, "answer about pre-oxygenation")
    rule = pass_rule.BENCH if person is None else pass_rule.RULES[person.age]
    preoxygenation.check(chosen, rule)
