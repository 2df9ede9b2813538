"""The hazard analysis: safe states, hazards with their bounds, the walk, the requirements."""

import tomllib
from pathlib import Path
from typing import Any

from docs.generator.document import table
from opensuction.evidence.campaign.sound_machine import Shows
from opensuction.evidence.safety_case import hazard
from opensuction.evidence.safety_case.hazard_claim import (
    ALL,
    NEEDS_NO_ALARM,
    SAFE_STATES,
    Hazard,
    HazardClaim,
    Response,
)

WALK = Path(__file__).parent / "hazard_walk.toml"
GUIDE_WORDS = {
    "stuck": "stuck",
    "slow": "slow",
    "offset": "offset",
    "noisy": "noisy",
    "intermittent": "intermittent",
    "reversed": "reversed",
    "frozen": "frozen",
    "lost": "lost",
    "late": "late",
    "wrong": "wrong configuration",
}
"""Guide words by their key in the file of the walk."""


def walk() -> list[dict[str, Any]]:
    """Parts of the machine with what each guide word comes to, as the file holds them."""
    parts: list[dict[str, Any]] = tomllib.loads(WALK.read_text(encoding="utf-8"))["part"]
    return parts


def _shown(claim: HazardClaim) -> str:
    strengths = f" = {', '.join(f'{one:g}' for one in claim.strengths)}" if claim.strengths else ""
    contact = "" if claim.approach == ALL else f", by {claim.approach}"
    named = "" if ALL in claim.patient else f", {', '.join(claim.patients)}"
    why = f" ({claim.only_because})" if claim.only_because else ""
    shows = "" if claim.shows == Shows.ALWAYS else f", {claim.shows.value}"
    return f"`{claim.name}`{strengths} in {', '.join(claim.phases)}{shows}{contact}{named}{why}"


def _bounds(claim: HazardClaim) -> tuple[str, ...]:
    alarms = ", ".join(f"`{name}`" for name in claim.alarm) or "refused"
    if claim.response in NEEDS_NO_ALARM:
        alarms += ", or a whole cycle within every limit"
    if claim.response == Response.ALARM_LIMITS_OR_REFUSAL:
        alarms += ", or refused before the start"
    return (
        _shown(claim),
        alarms,
        claim.priority.name.lower(),
        f"{claim.detected_ms:g}",
        claim.safe_state,
        f"{claim.safe_ms:g}",
        claim.because,
    )


BOUND_COLUMNS = ("fault", "alarm", "priority", "ms", "safe state", "ms", "because")


def _row(one: Hazard) -> list[str]:
    row = one.row
    return [
        f"### {row.id} {row.hazard}",
        "",
        f"Cause: {row.cause}. Effect: {row.effect}. Severity: {row.severity.value}.",
        f"Detection: {row.detection}. Control: {row.control}. "
        f"Requirements: {', '.join(row.requirements)}.",
        "",
        *table(BOUND_COLUMNS, [_bounds(claim) for claim in one.claims]),
        "",
    ]


def markdown() -> str:
    """All tables under their headings."""
    hazards = hazard.load()
    lines = ["", "## Safe states", ""]
    states: list[tuple[str, ...]] = [
        (f"`{name}`", state.words) for name, state in SAFE_STATES.items()
    ]
    lines += table(("name", "means"), states)
    lines += ["", "## Hazards", ""]
    for one in hazards:
        lines += _row(one)
    lines += ["## Walk through the machine", ""]
    for part in walk():
        lines += [f"### {part['name']}", ""]
        rows: list[tuple[str, ...]] = []
        for key, word in GUIDE_WORDS.items():
            found = part[key]
            rows.append((word, ", ".join(found) if isinstance(found, list) else found))
        lines += [*table(("guide word", "hazards, or why none"), rows), ""]
    lines += ["## Requirements", ""]
    requirements = hazard.requirements()
    answered = {
        name: ", ".join(one.row.id for one in hazards if name in one.row.requirements)
        for name in requirements
    }
    lines += table(
        ("id", "requirement", "answers"),
        [(name, sentence, answered[name]) for name, sentence in requirements.items()],
    )
    return "\n".join([*lines, "", ""])
