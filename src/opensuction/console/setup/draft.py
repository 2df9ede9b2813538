"""A draft of a protocol: every reason why it cannot be, each with the field that it belongs to.

The fields of a protocol for a form: unit, range, meaning and source, from the same settings.
"""

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple, get_type_hints

from pydantic import TypeAdapter

from opensuction.controller import setup
from opensuction.kernel.errors import InputError
from opensuction.kernel.unit import unit_of
from opensuction.kernel.vocabulary import Meaning
from opensuction.procedure.planning import clinical, guideline, planner
from opensuction.procedure.planning.clinical import TEMPLATE_SOURCES, TEMPLATES
from opensuction.procedure.planning.guideline import GUIDELINES, Guideline
from opensuction.procedure.planning.planner import Abilities, Refused
from opensuction.procedure.planning.protocol import PAPER, PAPER_SOURCES, Protocol, Site
from opensuction.session.running.basis import Basis
from opensuction.settings.validation import trim, validate
from opensuction.settings.wording import one_line, show

FIXED = "bench_only"
"""Belongs to the machine: nobody sets it in a form."""
LIMITS = ("cap_mm", "contact_from_mm", "negative_pressure_budget_s", "in_airway_budget_s")
"""What the governor holds: changed by an engineer, with a reason."""
OF_TEMPLATE = {
    "travel_mm": "stop_short_mm",
    "cap_mm": "cap_margin_mm",
    "contact_from_mm": "window_mm",
    "backoff_mm": "backoff_mm",
    "insertion_mm_per_s": "insertion_mm_per_s",
    "withdrawal_mm_per_s": "withdrawal_mm_per_s",
    "nothing_comes_s": "nothing_comes_s",
    "vacuum_mmhg": "vacuum_mmhg",
}
"""Value of a clinical protocol that a field is made from."""
OF_GUIDELINE = {
    "vacuum_mmhg": "vacuum_mmhg",
    "dwell_s": "negative_pressure_s",
    "negative_pressure_budget_s": "negative_pressure_s",
    "in_airway_budget_s": "in_airway_s",
    "insertion_mm_per_s": "speed_mm_per_s",
}
"""Guideline that a field is held against."""


class FormField(NamedTuple):
    """One field."""

    name: str
    unit: str
    meaning: str
    least: float
    is_above: bool
    """The value must be above ``least``; otherwise it may be as small."""
    most: float
    is_limit: bool
    """Only an engineer changes it."""
    default_source: str
    """Where the value of a preset comes from."""
    guideline: str
    """Guideline that it is held against, by name; empty for none."""


@cache
def fields() -> tuple[FormField, ...]:
    """All that a person sets, in the order of the settings."""
    hints = get_type_hints(Protocol, include_extras=True)
    return tuple(_field(name, hints[name]) for name in Protocol._fields if name != FIXED)


def _field(name: str, hint: Any) -> FormField:
    schema = TypeAdapter[Any](hint).json_schema()
    is_above = "exclusiveMinimum" in schema
    return FormField(
        name=name,
        unit=unit_of(name),
        meaning=next(one.text for one in hint.__metadata__ if isinstance(one, Meaning)),
        least=trim(schema["exclusiveMinimum" if is_above else "minimum"]),
        is_above=is_above,
        most=trim(schema["maximum"]),
        is_limit=name in LIMITS,
        default_source=_source(name),
        guideline=OF_GUIDELINE.get(name, ""),
    )


def _source(name: str) -> str:
    """Of a clinical protocol's value; of what follows from it, the guideline; else the paper's."""
    if name in OF_TEMPLATE:
        return TEMPLATE_SOURCES[OF_TEMPLATE[name]]
    if name in OF_GUIDELINE:
        return guideline.SOURCES[OF_GUIDELINE[name]]
    return PAPER_SOURCES[name]


WHERE = "draft"
WHOLE = ""
"""Field of what belongs to none of them."""
CHANGES_FIRST = {
    "vacuum_mmhg": "vacuum_mmhg",
    "negative_pressure_s": "dwell_s",
    "in_airway_s": "dwell_s",
    "catheter_ratio": WHOLE,
    "speed_mm_per_s": "insertion_mm_per_s",
}
"""Field that a person would change for a guideline."""


class Draft(NamedTuple):
    """Settings that a person proposes, each number checked alone."""

    by_contact: bool
    site: Site
    """With the carina that is meant."""
    protocol: Protocol | None
    """None where a number is none, or out of its range."""
    refused: tuple[Refused, ...]


def read(given: Mapping[str, object], by_contact: bool, site: Site, bench_only: bool) -> Draft:
    """Each number of a form against its range. bench_only: the machine's."""
    numbers = {FIXED: bench_only} | dict(given)
    refused = [
        Refused(one_line(str(name))[:40], f"unknown field {show(name)}")
        for name in given
        if name not in Protocol._fields
    ]
    if numbers[FIXED] is not bench_only:
        words = "a bench has nobody on it" if bench_only else "a patient is on this machine"
        refused.append(Refused(FIXED, f"bench_only belongs to the machine: {words}"))
    refused += [
        Refused(name, problem)
        for name in Protocol._fields
        if name != FIXED and (problem := _problem(numbers, name))
    ]
    protocol = None
    if not refused:
        protocol = validate(Protocol, numbers, WHERE)
    return Draft(by_contact, site, protocol, tuple(refused))


def _problem(given: Mapping[str, object], name: str) -> str:
    """Error in one field alone; empty where there is none."""
    sound: dict[str, object] = PAPER._asdict()
    del sound[name]
    if given.get(name) is not None:
        sound[name] = given[name]
    try:
        validate(Protocol, sound, WHERE)
    except InputError as error:
        return str(error).removeprefix(f"{WHERE}: ")
    return ""


def abilities(basis: Basis, site: Site) -> Abilities:
    """Abilities of the machine, for the planner. Raises InputError where a model has no answer."""
    return setup.abilities(basis.profile, basis.compensation, basis.calibration, site)


def judge(basis: Basis, draft: Draft) -> list[Refused]:
    """All that speaks against a draft, on this machine and for this patient."""
    protocol, site = draft.protocol, draft.site
    if protocol is None:
        return list(draft.refused)
    able = abilities(basis, site)
    times = planner.timeline(protocol, able, site, draft.by_contact)
    if not all(map(math.isfinite, times)):
        return [Refused("insertion_mm_per_s", "so slow a cycle has no end: raise the speeds")]
    found = list(planner.refusals(protocol, able, site, draft.by_contact))
    if not protocol.bench_only:
        found += _refuse_clinically(protocol, able, draft)
    if not found:
        found += _refuse_on_machine(basis, draft, protocol)
    return list(dict.fromkeys(found))


def _refuse_clinically(protocol: Protocol, able: Abilities, draft: Draft) -> Iterator[Refused]:
    """Refusals by guidelines and by the patient's size."""
    site, limit = draft.site, GUIDELINES[draft.site.age]
    held = clinical.held_against_guidelines(protocol, able, site, draft.by_contact)
    for field, one in zip(Guideline._fields, held, strict=True):
        if not one.ok:
            yield Refused(CHANGES_FIRST[field], clinical.sentence(one))
    budgets = (
        ("negative_pressure_budget_s", clinical.suction_budget_s(site)),
        ("in_airway_budget_s", limit.in_airway_s),
    )
    for name, most_s in budgets:
        value_s = getattr(protocol, name)
        if value_s > most_s:
            yield Refused(
                name, f"{name} {value_s:g} s is more than this patient may have, {most_s:g} s"
            )
    try:
        clinical.check_depth(protocol, site, draft.by_contact)
    except InputError as error:
        yield Refused(_field_of(str(error)), str(error))
    try:
        clinical.check_relief(able, site)
    except InputError as error:
        yield Refused(WHOLE, str(error))


def _refuse_on_machine(basis: Basis, draft: Draft, protocol: Protocol) -> Iterator[Refused]:
    """Refusals that only the settings as a whole show."""
    try:
        setup.plan_settings(
            basis.profile,
            protocol,
            basis.compensation,
            basis.calibration,
            draft.by_contact,
            draft.site,
        )
    except InputError as error:
        yield Refused(_field_of(str(error)), str(error))


def _field_of(message: str) -> str:
    """The field that a message names first."""
    places = {name: message.find(name) for name in Protocol._fields if name in message}
    return min(places, key=lambda name: places[name], default=WHOLE)


def fitted(basis: Basis, site: Site, by_contact: bool) -> dict[str, Protocol | str]:
    """The clinical protocols for this patient by name, or why one cannot be fitted."""
    if basis.protocol.bench_only:
        return {}
    made: dict[str, Protocol | str] = {}
    for name, template in TEMPLATES.items():
        if site.age in template.vacuum_mmhg:
            try:
                made[name] = clinical.fitted(template, abilities(basis, site), site, by_contact)
            except InputError as error:
                made[name] = str(error)
    return made
