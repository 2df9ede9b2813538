"""The protocol in force, drafts of another, and who may set what of it.

The planner's arithmetic of a protocol, for people: travel, times, vacuum, guidelines.

The patient at the machine, as far as the machine's settings depend on it.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session, require
from opensuction.console.access import ConsoleContext, check_reason
from opensuction.console.guard.problem import FieldError, Problem
from opensuction.console.live import machine_description
from opensuction.console.setup import change
from opensuction.console.setup import draft as drafts
from opensuction.console.setup.change import APPROACHES, Now, SettingsChange
from opensuction.console.setup.draft import CHANGES_FIRST, FIXED, LIMITS, Draft
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning import clinical, planner
from opensuction.procedure.planning.guideline import GUIDELINES, SOURCES, Guideline
from opensuction.procedure.planning.protocol import Protocol, Site
from opensuction.records import entry
from opensuction.runtime import machine_folder
from opensuction.runtime.machine_folder import About
from opensuction.session.running import basis as bases
from opensuction.session.running.basis import Basis

FIXED_ON_TWIN = (
    "the twin plays one patient for as long as it runs: for another one end it, and start it with "
    "opensuction serve --patient"
)
PATIENT_FIXED = (
    "the machine's settings are made for one body: for another one end it, and prepare it anew for "
    "that one"
)
NOBODY = "nobody is on this machine: a bench has no patient"


def patient_shown(site: ConsoleContext) -> dict[str, Any]:
    """The patient."""
    found, told = change.basis_of(site), site.about()
    geometry, person = found.site, found.person
    return {
        "version": found.version,
        "is_twin": told.machine.is_twin,
        "is_bench": person is None,
        "pseudonym": told.patient,
        "age": geometry.age.name.lower(),
        "tube_mm": geometry.tube_mm,
        "tube_length_mm": None if person is None else person.tube_length_mm,
        "weight_kg": None if person is None else person.weight_kg,
        "catheter_mm": geometry.catheter_mm,
        "carina_mm": geometry.carina_mm,
        "peep_cmh2o": geometry.peep_cmh2o,
        "fixed": _why_fixed(told) if person is not None else NOBODY,
    }


def put_patient(
    site: ConsoleContext, who: Session, wanted: dict[str, Any], version: int, key: str
) -> None:
    """Another pseudonym; another body is refused. Raises Problem."""
    with change.LOCK:
        found, now = change.basis_of(site), change.now(site)
        change.check_version(found, version)
        change.require_parked(now)
        told = site.about()
        if found.person is None:
            raise Problem(409, NOBODY)
        _refuse_other(found, wanted, _why_fixed(told))
        pseudonym = wanted["pseudonym"]
        try:
            entry.check_pseudonym(pseudonym)
        except InputError as error:
            raise Problem(422, str(error), [FieldError("pseudonym", str(error))]) from None
        if pseudonym == told.patient:
            raise Problem(409, "nothing would be other than it is")
        detail = f"pseudonym {told.patient} -> {pseudonym}"
        change.record(site, who.account, "choose-patient", detail, key)
        machine_folder.write(site.folder, told._replace(patient=pseudonym))
        bases.write(site.folder, found._replace(version=found.version + 1))


def _why_fixed(told: About) -> str:
    """Reason why nobody else can be chosen here."""
    return FIXED_ON_TWIN if told.machine.is_twin else PATIENT_FIXED


def _refuse_other(found: Basis, wanted: dict[str, Any], why: str) -> None:
    """Raises Problem for another body than the one at the machine. why: it cannot be another."""
    assert found.person is not None
    is_there = {
        "age": found.site.age.name.lower(),
        "tube_mm": found.site.tube_mm,
        "weight_kg": found.person.weight_kg,
    }
    other = [
        FieldError(name, why)
        for name, value in is_there.items()
        if wanted.get(name) is not None and wanted[name] != value
    ]
    if other:
        raise Problem(409, why, other)


def planned(basis: Basis, draft: Draft) -> dict[str, Any]:
    """The arithmetic of a draft whose numbers are some, whether it is refused or not."""
    protocol, site = draft.protocol, draft.site
    assert protocol is not None
    able = drafts.abilities(basis, site)
    times = planner.timeline(protocol, able, site, draft.by_contact)
    total_s = times.preload + times.in_airway + times.stroke
    return {
        "sentence": machine_description.say(
            protocol.travel_mm,
            planner.suction_mm(protocol, site),
            protocol.vacuum_mmhg,
            protocol.negative_pressure_budget_s,
            draft.by_contact,
        ),
        "way_mm": number(protocol.travel_mm - site.park_mm),
        "travel_mm": number(protocol.travel_mm),
        "left_to_cap_mm": number(protocol.cap_mm - protocol.travel_mm),
        "left_to_carina_mm": number(site.carina_mm - protocol.travel_mm),
        "vacuum_mmhg": number(protocol.vacuum_mmhg),
        "times_s": {name: number(value) for name, value in times._asdict().items()},
        "total_s": number(total_s),
        "budgets_s": {
            "negative_pressure": number(protocol.negative_pressure_budget_s),
            "in_airway": number(protocol.in_airway_budget_s),
        },
        "guidelines": [
            {
                "field": CHANGES_FIRST[field],
                "name": one.name,
                "value": number(one.value),
                "limit": one.limit,
                "unit": one.unit,
                "is_strict": one.strict,
                "ok": one.ok,
                "source": one.source,
            }
            for field, one in zip(
                Guideline._fields,
                clinical.held_against_guidelines(protocol, able, site, draft.by_contact),
                strict=True,
            )
        ],
    }


def number(value: float) -> float | None:
    """As JSON has it; None for what is none."""
    return float(value) if math.isfinite(value) else None


def guidelines(site: Site) -> list[dict[str, Any]]:
    """The table of limits, by age, with the sources; which of them are this patient's."""
    return [
        {
            "age": age.name.lower(),
            "is_patients": age == site.age,
            "limits": [
                {"name": name, "limit": limit, "source": SOURCES[name]}
                for name, limit in limits._asdict().items()
            ],
        }
        for age, limits in GUIDELINES.items()
    ]


BY_CONTACT = {name: by_contact for by_contact, name in APPROACHES.items()}
KNOWN, TAUGHT = "known", "taught"
"""Whose depth of the carina is meant: that which the settings go by, or the one just taught."""


class Wanted(NamedTuple):
    """Settings that a person asks for."""

    name: str | None
    approach: str
    carina: str
    numbers: Mapping[str, object]


def site_of(found: Basis, now: Now, carina: str) -> Any:
    """The patient's geometry with the carina that is meant. Raises Problem 409 for one untaught."""
    if carina == KNOWN:
        return found.site
    if now.taught_mm is None:
        raise Problem(409, "no travel length has been taught since the settings were last set")
    return found.site._replace(carina_mm=now.taught_mm)


def draft_of(found: Basis, now: Now, wanted: Wanted) -> Draft:
    """Draft of the settings asked for, its numbers checked."""
    geometry = site_of(found, now, wanted.carina)
    by_contact = BY_CONTACT[wanted.approach]
    return drafts.read(wanted.numbers, by_contact, geometry, found.protocol.bench_only)


def plan(site: ConsoleContext, wanted: Wanted) -> dict[str, Any]:
    """The planner's arithmetic of a draft, and why it cannot be."""
    found, now = change.basis_of(site), change.now(site)
    draft = draft_of(found, now, wanted)
    refused = drafts.judge(found, draft)
    needs = [] if draft.protocol is None else needed(found, draft)
    return {
        "version": found.version,
        "refused": [one._asdict() for one in refused],
        "plan": None if draft.protocol is None else planned(found, draft),
        "changes": [] if draft.protocol is None else changes(found, draft),
        "needs": [str(one) for one in needs],
    }


def changes(found: Basis, draft: Draft) -> list[dict[str, Any]]:
    """Fields in which a draft differs from the settings in force."""
    before, after = found.protocol, draft.protocol
    assert after is not None
    told = [
        {"field": name, "from": getattr(before, name), "to": getattr(after, name)}
        for name in Protocol._fields
        if getattr(before, name) != getattr(after, name)
    ]
    if draft.by_contact != found.by_contact:
        told.append(
            {
                "field": "approach",
                "from": APPROACHES[found.by_contact],
                "to": APPROACHES[draft.by_contact],
            }
        )
    if draft.site.carina_mm != found.site.carina_mm:
        told.append({"field": "carina", "from": found.site.carina_mm, "to": draft.site.carina_mm})
    return told


def needed(found: Basis, draft: Draft) -> list[Right]:
    """The rights that a change takes: a limit that the clinical protocol gives is no engineer's."""
    names = {str(one["field"]) for one in changes(found, draft)}
    fitted = [one for one in _fitted(found, draft).values() if isinstance(one, Protocol)]
    own = {
        name
        for name in names.intersection(LIMITS)
        if all(getattr(one, name) != getattr(draft.protocol, name) for one in fitted)
    }
    rights = [Right.CHANGE_LIMITS] if own else []
    return [Right.CHOOSE_PROTOCOL, *rights] if names - own else rights


def _fitted(found: Basis, draft: Draft) -> dict[str, Protocol | str]:
    return drafts.fitted(found, draft.site, draft.by_contact)


def name_of(found: Basis, draft: Draft, wanted: str | None) -> tuple[str, str | None]:
    """The name of a protocol, and the clinical protocol that it is, where it is one."""
    for name, one in _fitted(found, draft).items():
        if one == draft.protocol:
            return name, name
    if wanted:
        return wanted, None
    if draft.protocol == found.protocol:
        return found.protocol_name, found.template
    return f"{found.protocol_name.removesuffix(', changed')}, changed", None


def put(
    site: ConsoleContext, who: Session, wanted: Wanted, version: int, key: str, reason: str | None
) -> Basis:
    """Set it on the machine that runs. Raises what `change.carry_out` does, and Problem 422."""
    with change.LOCK:
        found, now = change.basis_of(site), change.now(site)
        change.check_version(found, version)
        change.require_parked(now)
        draft = draft_of(found, now, wanted)
        refused = drafts.judge(found, draft)
        if refused or draft.protocol is None:
            raise Problem(
                422,
                "this protocol cannot be set",
                [FieldError(one.field, one.sentence) for one in refused],
            )
        told = changes(found, draft)
        if not told and not found.is_teaching:
            raise Problem(409, "nothing would be other than it is in force")
        why = _allow(who, needed(found, draft) or [Right.CHOOSE_PROTOCOL], reason)
        name, template = name_of(found, draft, wanted.name)
        following = found._replace(
            protocol=draft.protocol,
            protocol_name=name,
            template=template,
            by_contact=draft.by_contact,
            site=draft.site,
            is_teaching=False,
            taught_by=f"taught by {who.account}" if wanted.carina == TAUGHT else found.taught_by,
        )
        what = "change-limits" if why else "choose-protocol"
        detail = f"{name}: {_in_words(told)}" + (f"; reason: {why}" if why else "")
        return change.carry_out(site, SettingsChange(who.account, key, what, detail, following))


def _allow(who: Session, rights: list[Right], reason: str | None) -> str:
    """The reason, where one is needed. Raises NotAllowedError, or Problem 422 without a reason."""
    why = ""
    for one in rights:
        require(who, one, "asked for below")
        if one == Right.CHANGE_LIMITS:
            why = check_reason(reason)
    return why


def _in_words(told: list[dict[str, Any]]) -> str:
    def words(value: object) -> str:
        return f"{value:.6g}" if isinstance(value, float) else str(value)

    return "; ".join(f"{one['field']} {words(one['from'])} -> {words(one['to'])}" for one in told)


def shown(site: ConsoleContext) -> dict[str, Any]:
    """Settings in force, with all that their form needs."""
    found, now = change.basis_of(site), change.now(site)
    given = found.protocol._asdict()
    draft = drafts.read(given, found.by_contact, found.site, bool(given[FIXED]))
    is_parked = now.phase == Phase.PARKED
    return {
        "version": found.version,
        "name": found.protocol_name,
        "approach": APPROACHES[found.by_contact],
        "is_teaching": found.is_teaching,
        "carina_mm": found.site.carina_mm,
        "taught_by": found.taught_by,
        "taught_mm": now.taught_mm,
        "compensation": found.compensation.name.lower().replace("_", "-"),
        "calibrated_by": found.calibrated_by,
        "bench_only": found.protocol.bench_only,
        "protocol": {name: value for name, value in given.items() if name != FIXED},
        "plan": planned(found, draft),
        "fields": [one._asdict() for one in drafts.fields()],
        "presets": presets(found, now),
        "phase": now.phase_name,
        "may_change_now": is_parked,
        "why_not_now": ""
        if is_parked
        else f"the machine is {now.phase_name.replace('-', ' ')}: only while it is parked",
    }


def presets(found: Basis, now: Now) -> list[dict[str, Any]]:
    """The clinical protocols as they fit this patient, either way and for either carina."""
    carinas = [KNOWN] if now.taught_mm is None else [KNOWN, TAUGHT]
    told = []
    for carina in carinas:
        geometry = site_of(found, now, carina)
        for approach, by_contact in BY_CONTACT.items():
            for name, one in drafts.fitted(found, geometry, by_contact).items():
                is_refused = isinstance(one, str)
                told.append(
                    {
                        "name": name,
                        "approach": approach,
                        "carina": carina,
                        "carina_mm": geometry.carina_mm,
                        "protocol": None if is_refused else _numbers(one),
                        "refused": one if is_refused else "",
                    }
                )
    return told


def _numbers(protocol: Any) -> dict[str, float]:
    return {name: value for name, value in protocol._asdict().items() if name != FIXED}
