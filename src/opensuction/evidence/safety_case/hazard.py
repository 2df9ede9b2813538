"""The hazard table: what can go wrong, which fault shows it, and what must then happen in time.

The project's own table is `hazard.toml` beside this file; a user's has the same form. A row is
checked whole before anything runs: faults and strengths against the twin's, alarms and priorities
against the alarm table, phases against what a cycle has.
"""

import tomllib
from collections import Counter
from collections.abc import Mapping
from enum import Enum
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from annotated_types import Ge, Le

from opensuction.evidence.healthy_cycle import AIRWAY, Shows
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import CYCLE
from opensuction.oracle.harm import NAMES
from opensuction.safety.condition import Condition
from opensuction.safety.priority import Priority
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.settings.choice import choose
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import validate
from opensuction.settings.wording import name_source, one_line, show
from opensuction.twin.fault.fault import BY_NAME, Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

FILE = "hazard.toml"
REQUIREMENTS = "requirement.toml"

SET_UP = "set-up"
"""Phase of faults that are there before the start."""
ALL = "all"
CONTACT = tuple(phase.name.lower() for phase in CYCLE)
PHASES = {"travel": tuple(name for name in CONTACT if name != "backing_off"), "contact": CONTACT}
"""Phases of a cycle in order, by approach: where a fault can come."""
SPANS = (AIRWAY, ALL, SET_UP)
"""What phases can name besides."""
PATIENTS = tuple(PATIENT_TABLES)
MOST_MS = 60_000.0
"""A later alarm or safe state is none: a run is watched for so long after it has come to rest, and
no patient of the table has longer (adult: 30 s, [calc-apnoea])."""


UNHEARD = frozenset(
    {
        Condition.PATIENT_SETTINGS_UNCONFIRMED,
        Condition.TIP_DETACHED,
        Condition.CALIBRATION_OUT_OF_RANGE,
        Condition.RECORDER_LOST,
        Condition.CONSOLE_LOST,
    }
)
"""Conditions that nothing in a cycle on the twin raises: an alarm that nobody can hear is none."""


class SafeState(NamedTuple):
    """A safe state in words, and what must hold together, to the end of the run."""

    words: str
    predicates: tuple[str, ...]
    """Names of `safe_state` predicates; all hold."""


SAFE_STATES = {
    "out-without-suction": SafeState(
        "the tip is outside the patient and no vacuum reaches it", ("tip-outside", "no-suction")
    ),
    "out-without-vacuum": SafeState(
        "the tip is outside the patient and the line is vented",
        ("tip-outside", "no-suction", "vented"),
    ),
    "not-inserted": SafeState("the tip never comes into the patient", ("not-inserted",)),
}
"""By name. A catheter that stays inside is none of them, with or without torque."""


class HarmSeverity(Enum):
    """How bad the harm is, in the words of [ISO-14971]."""

    NEGLIGIBLE = "negligible"
    MINOR = "minor"
    SERIOUS = "serious"
    CRITICAL = "critical"


class Response(Enum):
    """What the machine owes a fault."""

    ALARM = "alarm"
    """Alarm and safe state within their bounds."""
    ALARM_OR_LIMITS = "alarm-or-limits"
    """The same, or a whole cycle within every limit as if nothing were wrong."""
    NOT_MEASURED = "not-measured"
    """It would be an alarm, but nothing in the twin could raise it: an open gap, and it fails."""
    REFUSAL = "refusal"
    """It is refused before anything moves; a message on the spot, no alarm."""


class Raiser(Enum):
    """Who tells people."""

    CONTROLLER = "controller"
    DRIVES = "drives"
    """The drives, their watchdog or the power supply, on the annunciator: the controller is what
    failed."""


BoundMs = Annotated[float, Ge(0), Le(MOST_MS)]


class HazardClaim(NamedTuple):
    """A fault and what must follow it: the part of a row that runs."""

    name: str
    """Of the fault."""
    strengths: list[float]
    """None given: the fault's usual one."""
    phases: list[str]
    after_s: list[float]
    """How long into the phase; none given: all over it, each seed at another share of it."""
    shows: Shows
    approach: str
    """Or all."""
    patient: str | list[str]
    """Or all."""
    only_because: str
    """Why it does not apply to the others."""
    response: Response
    alarm: list[str]
    """Conditions of which any tells a person what is wrong, the most likely first."""
    priority: Priority
    raised_by: Raiser
    safe_state: str
    detected_ms: BoundMs
    safe_ms: BoundMs
    by_age: bool
    """Whether a smaller patient has less time; what waits for a sensor's own delay does not."""
    allowed: list[str]
    """Bounds of the patient to which is added what the fault makes unavoidable."""
    because: str

    @property
    def fault(self) -> Fault:
        """The fault of this name."""
        return BY_NAME[self.name]

    @property
    def approaches(self) -> tuple[str, ...]:
        """Approaches that it is run with."""
        return tuple(APPROACHES) if self.approach == ALL else (self.approach,)

    @property
    def patients(self) -> tuple[str, ...]:
        """Patients that it is run on."""
        named = [self.patient] if isinstance(self.patient, str) else self.patient
        return PATIENTS if ALL in named else tuple(named)


class HazardRow(NamedTuple):
    """A row of the table in words."""

    id: str
    hazard: str
    cause: str
    effect: str
    severity: HarmSeverity
    detection: str
    control: str
    requirements: list[str]


class Hazard(NamedTuple):
    """A hazard and the faults that show it."""

    row: HazardRow
    claims: tuple[HazardClaim, ...]


USUAL: dict[str, Any] = {
    "strengths": [],
    "phases": [AIRWAY],
    "after_s": [],
    "shows": "always",
    "approach": ALL,
    "patient": ALL,
    "only_because": "",
    "response": "alarm",
    "raised_by": "controller",
    "by_age": True,
    "allowed": [],
}
"""Keys that may be left out: of what runs, never of what is demanded."""
KEYS = set(HazardRow._fields) | set(HazardClaim._fields) - {"name"} | {"fault"}
"""Keys of a row in the file."""


def _bundled(name: str) -> dict[str, Any]:
    file = resources.files("opensuction.evidence.safety_case") / name
    return tomllib.loads(file.read_text(encoding="utf-8"))


def load(path: Path | None = None) -> tuple[Hazard, ...]:
    """The hazards of a file, or of the project's own table.

    Raises InputError of one line that names row and field for anything that cannot be meant.
    """
    where = FILE if path is None else str(path)
    data = _bundled(FILE) if path is None else load_toml(path)
    extra = [key for key in data if key != "hazard"]
    rows = data.get("hazard")
    if extra or not isinstance(rows, list) or not rows:
        what = f"unknown key {show(extra[0])}" if extra else "no hazard in it"
        raise InputError(one_line(f"{where}: {what}; rows begin with [[hazard]]"))
    hazards = tuple(_hazard(row, f"{where}: hazard {i}", where) for i, row in enumerate(rows, 1))
    for name, count in Counter(hazard.row.id for hazard in hazards).items():
        if count > 1:
            raise InputError(
                one_line(f"{where}: {name}: id is there {count} times; give each its own")
            )
    return hazards


def _hazard(row: Any, numbered: str, where: str) -> Hazard:
    if not isinstance(row, Mapping):
        raise InputError(one_line(f"{numbered} is {show(row)}; rows begin with [[hazard]]"))
    words = validate(
        HazardRow, {key: row[key] for key in HazardRow._fields if key in row}, numbered
    )
    here = f"{where}: {words.id}"
    for key in row:
        choose(key, dict.fromkeys(sorted(KEYS)), f"key of a hazard in {here}")
    known = _bundled(REQUIREMENTS)
    for name in words.requirements:
        if name not in known:
            raise InputError(one_line(f"{here}: requirements: {show(name)} is not known"))
    faults = row.get("fault")
    if not isinstance(faults, list) or not faults:
        raise InputError(one_line(f"{here}: fault: none given; add [[hazard.fault]] with a name"))
    common = USUAL | {key: row[key] for key in HazardClaim._fields if key in row}
    return Hazard(words, tuple(_claim(common, fault, here, i) for i, fault in enumerate(faults, 1)))


def _claim(common: dict[str, Any], given: Any, here: str, number: int) -> HazardClaim:
    """One fault of a row; raises InputError for the first thing that is wrong with it."""
    place = f"{here}, fault {number}"
    if not isinstance(given, Mapping):
        raise InputError(one_line(f"{place} is {show(given)}, not a section"))
    claim = validate(HazardClaim, common | dict(given), place)
    with name_source(place):
        _check_fault(claim)
        _check_answer(claim)
    return claim


def _check_fault(claim: HazardClaim) -> None:
    choose(claim.name, BY_NAME, "fault in name", "docs/reference/faults.md")
    for strength in claim.strengths:
        ROWS[claim.fault].check_strength(strength)
    choose(claim.approach, dict.fromkeys((*APPROACHES, ALL)), "approach")
    named = [claim.patient] if isinstance(claim.patient, str) else claim.patient
    for patient in named or [""]:
        choose(patient, dict.fromkeys((*PATIENTS, ALL)), "patient")
    if not claim.phases:
        raise InputError("phases: none given; name some, or all")
    at_start = ROWS[claim.fault].is_setup
    for phase in claim.phases:
        if at_start != (phase == SET_UP):
            way = "not be set up: name phases of a cycle"
            if at_start:
                way = f"only be there before the start: phases = ['{SET_UP}']"
            raise InputError(f"phases: '{phase}' is impossible, '{claim.name}' can {way}")
        phases = (*(PHASES["travel"] if claim.approach == "travel" else CONTACT), *SPANS)
        choose(phase, dict.fromkeys(phases), f"phase by {claim.approach} in phases")
    if claim.after_s and {AIRWAY, ALL} & {*claim.phases}:
        raise InputError("after_s: how long into which phase? name phases of a cycle")
    for after in claim.after_s:
        if not 0.0 <= after < 180.0:
            raise InputError(f"after_s: {after:g} s is impossible; 0 to less than 180 s")


def _check_answer(claim: HazardClaim) -> None:
    for name in claim.allowed:
        choose(name, dict.fromkeys(NAMES), "bound in allowed")
    choose(claim.safe_state, SAFE_STATES, "safe state in safe_state")
    if claim.response == Response.REFUSAL:
        if claim.alarm or claim.priority != Priority.NONE:
            raise InputError("alarm: a refusal before the start is no alarm; alarm = []")
        return
    if claim.response == Response.NOT_MEASURED:
        if claim.alarm or claim.priority != Priority.NONE:
            raise InputError("alarm: what nothing raises is not measured; alarm = []")
        return
    if not claim.alarm:
        raise InputError("alarm: none given; name the condition that tells a person")
    known = {condition.name: condition for condition in Condition}
    found = [
        choose(name, known, "alarm condition in alarm", "docs/reference/alarms.md")
        for name in claim.alarm
    ]
    unheard = [condition.name for condition in found if condition in UNHEARD]
    if unheard:
        raise InputError(f"alarm: {unheard[0]} is raised by nothing in the twin")
    for number, condition in enumerate(found):
        priority = condition.row.handling.priority
        if priority < claim.priority or (number == 0 and priority != claim.priority):
            raise InputError(
                f"priority: {claim.priority.name.lower()}, but the alarm table gives "
                f"{condition.name} {priority.name.lower()}; the first alarm must have the row's "
                "priority, the others no lower one"
            )


def spans_of(claim: HazardClaim, approach: str) -> list[str]:
    """Phases of an approach, or `SPANS`, that the fault comes in."""
    if ALL in claim.phases:
        return [*PHASES[approach]]
    return [name for name in claim.phases if name in (*PHASES[approach], *SPANS)]


def requirements() -> dict[str, str]:
    """Sentence of each requirement by its identifier."""
    return {name: str(sentence) for name, sentence in _bundled(REQUIREMENTS).items()}
