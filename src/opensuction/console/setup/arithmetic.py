"""The planner's arithmetic of a protocol, for people: travel, times, vacuum, guidelines."""

import math
from typing import Any

from opensuction.console.live import plan_words
from opensuction.console.setup import draft as drafts
from opensuction.console.setup.draft import CHANGES_FIRST, Draft
from opensuction.procedure.planning import clinical, planner
from opensuction.procedure.planning.guideline import GUIDELINES, SOURCES, Guideline
from opensuction.procedure.planning.site import Site
from opensuction.session.running.basis import Basis


def planned(basis: Basis, draft: Draft) -> dict[str, Any]:
    """The arithmetic of a draft whose numbers are some, whether it is refused or not."""
    protocol, site = draft.protocol, draft.site
    assert protocol is not None
    able = drafts.abilities(basis, site)
    times = planner.timeline(protocol, able, site, draft.by_contact)
    total_s = times.preload + times.in_airway + times.stroke
    return {
        "sentence": plan_words.say(
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
