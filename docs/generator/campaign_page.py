"""A campaign of faults as a page: counts with bounds, breaches, and what went untold."""

import math

from opensuction.session.plain import Json
from opensuction.simulation.injection.fault_allowance import ALLOWANCES, OWN_HARM

KINDS_SHOWN = 40
"""Kinds of breaches that are listed, the most frequent first."""
LABELS = {
    "commands": "invariants of the command side, all cycles",
    "fault_free": "bounds of the patient, no fault came in time",
    "single": "bounds of the patient, one fault",
    "double": "bounds of the patient, two faults",
}


def _count(label: str, found: Json) -> str:
    return (
        f"| {label} | {found['cycles']:,} | {found['broken']:,} | {found['upper_percent']:.2g} % |"
    )


def _kind(kind: Json) -> str:
    examples = ", ".join(str(number) for number in kind["examples"])
    side = "" if kind["physical"] else " (command)"
    return (
        f"| {kind['faults']} | {kind['invariant']}{side} | {kind['cycles']} | {kind['worst']:.3g} "
        f"| {kind['bound']:.3g} | {examples} |"
    )


def _kinds(breaches: list[Json]) -> list[str]:
    if not breaches:
        return ["None."]
    rows = [_kind(kind) for kind in breaches[:KINDS_SHOWN]]
    left = len(breaches) - len(rows)
    return [
        "| faults | what was broken | cycles | worst | bound | numbers |",
        "|---|---|---|---|---|---|",
        *rows,
        *([f"\nand {left} more kinds."] if left else []),
    ]


def _untold(unnoticed: Json) -> list[str]:
    rows = [
        f"| `{title}` | {counts['cycles']} | {counts['unnoticed']} |"
        for title, counts in unnoticed.items()
        if counts["unnoticed"]
    ]
    return ["| fault, alone | cycles | of these untold |", "|---|---|---|", *rows]


def _allowances() -> list[str]:
    rows = [
        f"| `{one.fault.title}` | {one.bound} | "
        f"{'its strength' if one.for_strength else f'{one.more:g}'}"
        f"{'' if math.isinf(one.up_to) else f', up to strength {one.up_to:g}'} | {one.reason} |"
        for one in ALLOWANCES
    ]
    own = [
        f"| `{one.fault.title}` | {', '.join(one.bounds)} | all | {one.reason} |"
        for one in OWN_HARM
    ]
    head = ["| fault | bound | on top of the common one | because |", "|---|---|---|---|"]
    return [*head, *rows, *own]


def _left_inside(found: Json) -> list[str]:
    rows = [
        f"| {name} | {one['count']} | {one['unavoidable']} | {one['told']} |"
        for name, one in found.items()
    ]
    head = "| faults that came | left inside | of these unavoidable | told high in time |"
    return [head, "|---|---|---|---|", *rows]


def markdown(found: Json, date: str) -> str:
    """The page of a campaign. found: its JSON object (a `Tally` as a mapping, and what was run)."""
    counts = [_count(label, found[key]) for key, label in LABELS.items()]
    return "\n".join(
        [
            f"# Random faults: {found['commands']['cycles']:,} cycles",
            "",
            f"Date: {date}. In-silico. Compensation `{found['compensation']}`, {found['machines']} "
            f"drawn machines and patients from seed {found['first_seed']}, cycles "
            f"{found['first']} to {found['last'] - 1}; each is drawn from its number alone and can "
            "be played again (`evidence/trial/fault_campaign.py`).",
            "",
            "| held against | cycles | broke something | share at most (95 %) |",
            "|---|---|---|---|",
            *counts,
            "",
            f"False alarms in cycles to which no fault came in time: {found['false_alarms']}.",
            "",
            "## Left inside",
            "",
            *_left_inside(found["left_inside"]),
            "",
            "## Breaches",
            "",
            *_kinds(found["breaches"]),
            "",
            "## Bounds that faults state for themselves",
            "",
            *_allowances(),
            "",
            "## What nothing told",
            "",
            *_untold(found["unnoticed"]),
            "",
        ]
    )
