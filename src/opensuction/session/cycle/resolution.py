"""Resolution of the choices for a cycle: protocol, machine, patient, compensation, faults.

Faults that a person chose: ``NAME[@S][=STRENGTH]``, and set-ups that are wrong on purpose.

Pre-oxygenation on the twin: 100 % oxygen from the ventilator, and the answer at the machine.

The oxygen stays on for the pass and for what is followed of the patient after it, as the function
of a ventilator does; a lung that collapses behind it (absorption) is not modelled.
"""

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import OXYGEN_SKIPPED, OXYGENATED, Requests
from opensuction.kernel.vocabulary import CYCLE, Phase, name_of
from opensuction.procedure.cycle import interlocks
from opensuction.procedure.cycle.schedule import PassRule, Preoxygenation
from opensuction.procedure.planning import guideline
from opensuction.procedure.planning.clinical import ADULT, TEMPLATES, Template
from opensuction.procedure.planning.protocol import PROTOCOLS, Protocol
from opensuction.result.cycle_result import OxygenRecord
from opensuction.session.choice import LISTED, CycleChoice
from opensuction.session.cycle import equipment
from opensuction.session.cycle.equipment import Equipment
from opensuction.settings.identification_file import Identified
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import choose, validate
from opensuction.settings.wording import one_line, show
from opensuction.simulation import closed_loop, trace
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.simulation.trace import Columns
from opensuction.twin import preset
from opensuction.twin.fault.fault import BY_NAME, Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.catheter import CATHETERS
from opensuction.twin.patient.patient_kind import PatientKind

GIVEN_S = 60.0
"""How long it is given before the start: 30 to 60 s are usual, and after 30 s saturation falls
further than after a minute or two [K]."""
FULL_RATIO = 1.0
ANSWERS: dict[str, Requests] = {"confirmed": OXYGENATED, "skipped": OXYGEN_SKIPPED}
"""What a person may answer, by the name that the command line takes."""
USUAL = "confirmed"
"""Where guidelines ask for it and nobody has said anything."""


def check(chosen: str | None, rule: PassRule) -> None:
    """Refuse an answer where nobody is asked; raises InputError."""
    if chosen is not None and not rule.asks_for_oxygen:
        raise InputError(
            f"--preoxygenation {chosen}: nobody asks for it on the bench or with a neonate, who "
            "gets no 100 % oxygen: leave it out"
        )


def lead_s(loop: Loop, chosen: str | None) -> float:
    """Time before its start at which a cycle's preparation begins, in s."""
    return GIVEN_S if _is_given(loop, chosen) else 0.0


def _is_given(loop: Loop, chosen: str | None) -> bool:
    return loop.controller.service.passes.asks_for_oxygen and (chosen or USUAL) == USUAL


def pass_idle_time(loop: Loop, state: LoopState, duration_s: float) -> LoopState:
    """Patient and controller's clocks after a time in which the machine is parked."""
    before = state.tick
    state = closed_loop.pass_time(loop, state, duration_s)
    core = state.controller.core
    kept = interlocks.pass_idle_time(core.upkeep, (state.tick - before) * DT_S)
    decided = state.controller._replace(core=core._replace(upkeep=kept))
    return state._replace(controller=decided)


def give(loop: Loop, state: LoopState, chosen: str | None) -> tuple[Loop, LoopState]:
    """The loop for the next cycle, and its state once the machine has its answer.

    chosen: a name of `ANSWERS`; None is the usual one. Nothing changes where nobody is asked.
    """
    if not loop.controller.service.passes.asks_for_oxygen:
        return loop, state
    if _is_given(loop, chosen):
        loop = loop._replace(machine=preset.ventilate(loop.machine, FULL_RATIO))
        state = pass_idle_time(loop, state, GIVEN_S)
    return loop, closed_loop.run(loop, state, ANSWERS[chosen or USUAL], trace.rows(DT_S))[0]


def on_record(columns: Columns) -> OxygenRecord:
    """Pre-oxygenation of the first cycle of a trace, as it is on record."""
    codes, testing = columns["counters.preoxygenation"], columns["phase"] == Phase.CHECKING
    code = codes[testing][0] if testing.any() else codes[-1]
    state = Preoxygenation(int(code))
    return OxygenRecord(required=state != Preoxygenation.NOT_REQUIRED, state=name_of(state))


FORM = "NAME[@S][=STRENGTH], S in seconds after the start or PHASE+S"
_PARTS = re.compile(r"(?P<name>[^@=]*)(?:@(?P<at>[^@=]*))?(?:=(?P<strength>[^@=]*))?")
PHASES = {phase.name.lower(): phase for phase in (*CYCLE, Phase.ABORTING, Phase.HALTED)}
"""Phases that a cycle can have once it has begun, by name."""
WIDEST = max(CATHETERS, key=lambda name: CATHETERS[name].outer_mm)


def _number(text: str, what: str, whole: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            one_line(f"--fault {show(whole)}: {what} {show(text)} is not a number; give {FORM}")
        )
    return value


def _instant(text: str, whole: str) -> FaultInstant:
    """The instant after the ``@``."""
    name, plus, after = text.partition("+")
    if not name or not name[0].isalpha():
        return FaultInstant(None, _number(text, "the instant", whole))
    spelled = name.replace("-", "_")
    phase = choose(spelled if spelled in PHASES else name, PHASES, "phase of a fault")
    return FaultInstant(phase, _number(after, "the time into the phase", whole) if plus else 0.0)


def parse(text: str) -> Injection:
    """The fault that a person wrote; raises InputError for what cannot be meant."""
    parts = _PARTS.fullmatch(text)
    if parts is None:
        raise InputError(one_line(f"--fault {show(text)}: should be {FORM}"))
    fault = choose(parts["name"], BY_NAME, "fault", LISTED)
    strength = ROWS[fault].default_strength
    if parts["strength"] is not None:
        strength = _number(parts["strength"], "the strength", text)
    at = AT_START if parts["at"] is None else _instant(parts["at"], text)
    return Injection(fault, at, strength)


def resolve_faults(texts: Sequence[str], approach: str) -> tuple[Injection, ...]:
    """Faults for a cycle or a day of them; raises InputError for what cannot happen in it.

    Whether an instant in seconds is within what is played is not looked at.
    """
    faults = tuple(parse(text) for text in texts)
    injection.check_faults(faults)
    for one in faults:
        if one.at.phase == Phase.BACKING_OFF and approach == "travel":
            raise InputError(
                f"fault '{one.fault.title}' at {one.at.title}: approach '{approach}' has no phase "
                "backing_off; use --approach contact or another phase"
            )
    return faults


def taught_error_mm(faults: Sequence[Injection]) -> float:
    """By how much the way to the carina is taught too long."""
    return sum(one.strength for one in faults if one.fault == Fault.TAUGHT_TOO_DEEP)


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
    faults = resolve_faults(choice.faults, choice.approach)
    resolved = _resolve(choice, faults)
    changed = _set_up(choice, faults)
    return resolved if changed == choice else _resolve(changed, faults)


def _set_up(choice: CycleChoice, faults: tuple[Injection, ...]) -> CycleChoice:
    """The choice with the faults of its set-up; what is refused is for planning to say."""
    for fault in (one.fault for one in faults):
        if fault == Fault.WRONG_PRESET:
            choice = choice._replace(rig=choice.rig._replace(patient="neonate"), protocol="adult")
        elif fault == Fault.CATHETER_TOO_WIDE:
            choice = choice._replace(rig=choice.rig._replace(catheter=WIDEST))
    return choice


def _resolve(choice: CycleChoice, faults: tuple[Injection, ...]) -> ResolvedCycle:
    named = None if choice.protocol is None else find_protocol(choice.protocol)
    by_contact = choose(choice.approach, APPROACHES, "approach")
    usual_machine = "bench" if _is_for_bench(named) else "clinical"
    found = equipment.resolve(choice.rig, usual_machine)
    name = choice.protocol or _usual_protocol(found.patient)
    kind, file = equipment.resolve_compensation(choice.compensation)
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
        guideline.check_plausible(person.age, carina_mm, "carina_mm")
    if taught_mm is not None and person is None:
        raise InputError(
            f"--taught {taught_mm:g} mm would do nothing: protocol '{name}' names its own "
            "travel_mm, and the bench has no patient whose depth it is held against"
        )
    if taught_mm is not None and person is not None:
        guideline.check_plausible(person.age, taught_mm, "--taught")
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
        choose(chosen, ANSWERS, "answer about pre-oxygenation")
    rule = guideline.BENCH if person is None else guideline.RULES[person.age]
    check(chosen, rule)
