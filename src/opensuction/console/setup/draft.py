"""A draft of a protocol: every reason why it cannot be, each with the field that it belongs to."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from opensuction.console.setup.field import FIXED
from opensuction.controller import setup
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning import clinical, planner
from opensuction.procedure.planning.clinical import TEMPLATES
from opensuction.procedure.planning.guideline import GUIDELINES, Guideline
from opensuction.procedure.planning.planner import Abilities, Refused
from opensuction.procedure.planning.protocol import PAPER, Protocol
from opensuction.procedure.planning.site import Site
from opensuction.session.running.basis import Basis
from opensuction.settings.validation import validate
from opensuction.settings.wording import one_line, show

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
