"""Faults that a person chose: ``NAME[@S][=STRENGTH]``, and set-ups that are wrong on purpose."""

import math
import re
from collections.abc import Sequence

from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import CYCLE, Phase
from opensuction.session.choice import LISTED
from opensuction.settings.choice import choose
from opensuction.settings.wording import one_line, show
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.twin.fault.fault import BY_NAME, Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.catheter import CATHETERS

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


def resolve(texts: Sequence[str], approach: str) -> tuple[Injection, ...]:
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
