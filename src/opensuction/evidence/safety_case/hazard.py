"""The hazard table: what can go wrong, which fault shows it, and what must then happen in time.

The project's own table is `hazard.toml` beside this file; a user's has the same form. A row is
checked whole before anything runs: faults and strengths against the twin's, alarms and priorities
against the alarm table, phases against what a cycle has.
"""

import tomllib
from collections import Counter
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from opensuction.evidence.campaign.sound_machine import AIRWAY
from opensuction.evidence.safety_case.hazard_claim import (
    ALL,
    CONTACT,
    PATIENTS,
    PHASES,
    SAFE_STATES,
    SET_UP,
    SPANS,
    UNHEARD,
    Hazard,
    HazardClaim,
    HazardRow,
    Response,
    RiskEstimate,
)
from opensuction.evidence.safety_case.hazard_claim import check as check_risk
from opensuction.kernel.errors import InputError
from opensuction.oracle.harm import NAMES
from opensuction.safety.condition import Condition
from opensuction.safety.handling import Priority
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import choose, validate
from opensuction.settings.wording import name_source, one_line, show
from opensuction.twin.fault.fault import BY_NAME
from opensuction.twin.fault.fault_table import ROWS

FILE = "hazard.toml"
REQUIREMENTS = "requirement.toml"

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
KEYS = set(HazardRow._fields) | set(HazardClaim._fields) - {"name"} | {"fault", "risk"}
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


def pick(hazards: tuple[Hazard, ...], name: str | None) -> tuple[Hazard, ...]:
    """The hazard of an identifier alone; all for None. Raises InputError for an unknown one."""
    if name is None:
        return hazards
    return (choose(name, {one.row.id: one for one in hazards}, "--hazard"),)


def _check_words(words: HazardRow) -> None:
    """Raises InputError where a row says nothing."""
    for name, said in words._asdict().items():
        if not (said.strip() if isinstance(said, str) else said):
            raise InputError(f"{name}: is empty")


def _hazard(row: Any, numbered: str, where: str) -> Hazard:
    if not isinstance(row, Mapping):
        raise InputError(one_line(f"{numbered} is {show(row)}; rows begin with [[hazard]]"))
    words = validate(
        HazardRow, {key: row[key] for key in HazardRow._fields if key in row}, numbered
    )
    with name_source(numbered):
        _check_words(words)
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
    claims = tuple(_claim(common, fault, here, i) for i, fault in enumerate(faults, 1))
    return Hazard(words, claims, _risk(row["risk"], words, claims, here) if "risk" in row else None)


def _risk(given: Any, words: HazardRow, claims: tuple[HazardClaim, ...], here: str) -> RiskEstimate:
    """The estimate of a row; raises InputError for the first thing that is wrong with it."""
    place = f"{here}, risk"
    risk = validate(RiskEstimate, given, place)
    with name_source(place):
        check_risk(words.severity, risk)
        unmeasured = [claim.name for claim in claims if claim.response == Response.NOT_MEASURED]
        if unmeasured:
            raise InputError(
                f"residual_probability: nothing measures what answers '{unmeasured[0]}'; leave "
                "the section out until something does"
            )
    return risk


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


def _check_kinds(claim: HazardClaim) -> None:
    choose(claim.approach, dict.fromkeys((*APPROACHES, ALL)), "approach")
    named = [claim.patient] if isinstance(claim.patient, str) else claim.patient
    for patient in named or [""]:
        choose(patient, dict.fromkeys((*PATIENTS, ALL)), "patient")
    narrowed = claim.patient != ALL or claim.approach != ALL
    if narrowed and not claim.only_because.strip():
        raise InputError("only_because: say why the fault comes on no other patient or approach")


def _check_fault(claim: HazardClaim) -> None:
    choose(claim.name, BY_NAME, "fault in name", "docs/reference/faults.md")
    for strength in claim.strengths:
        ROWS[claim.fault].check_strength(strength)
    _check_kinds(claim)
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


def requirements() -> dict[str, str]:
    """Sentence of each requirement by its identifier."""
    return {name: str(sentence) for name, sentence in _bundled(REQUIREMENTS).items()}
