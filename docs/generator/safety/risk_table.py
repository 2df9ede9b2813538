"""Every hazard's risk before and after its controls, and what verifies them."""

import re
from collections import Counter
from enum import Enum

from docs.generator.document import table
from opensuction.evidence.safety_case import hazard
from opensuction.evidence.safety_case.hazard_claim import (
    MATRIX,
    PROBABILITY_WORDS,
    SEVERITY_WORDS,
    Acceptability,
    HarmProbability,
    HarmSeverity,
    Hazard,
    RiskEstimate,
)
from tools.traceability import matrix

ANALYSIS = "../reference/hazard-analysis.md"
NOT_WORDS = re.compile(r"[^\w\- ]")


def _risk(one: Hazard) -> RiskEstimate:
    """The estimate of a hazard of the project's own table, all of which have one."""
    assert one.risk is not None
    return one.risk


def _shown(acceptability: Acceptability) -> str:
    """What follows from a risk; what is not accepted stands out."""
    word = acceptability.value
    return f"**{word}**" if acceptability == Acceptability.UNACCEPTABLE else word


def _level(severity: HarmSeverity, probability: HarmProbability) -> str:
    verdict = _shown(MATRIX[severity][probability])
    return f"{severity.value}, {probability.value}: {verdict}"


def _link(one: Hazard) -> str:
    """The hazard's row of the analysis, with the bounds that are run."""
    heading = f"{one.row.id} {one.row.hazard}"
    slug = NOT_WORDS.sub("", heading.lower()).replace(" ", "-")
    return f"[{one.row.id}]({ANALYSIS}#{slug}) {one.row.hazard}"


def _levels() -> list[str]:
    """What the levels mean, and the matrix."""

    def meanings(words: dict[HarmSeverity, str] | dict[HarmProbability, str]) -> list[str]:
        rows = [(level.value, text) for level, text in words.items()]
        kind = "severity" if words is SEVERITY_WORDS else "probability of the harm"
        return table((kind, "means"), rows)

    cells = [
        (one.value, *(_shown(MATRIX[severity][one]) for severity in HarmSeverity))
        for one in reversed(HarmProbability)
    ]
    header = ("", *(severity.value for severity in HarmSeverity))
    return [
        *meanings(SEVERITY_WORDS),
        "",
        *meanings(PROBABILITY_WORDS),
        "",
        *table(header, cells),
        "",
    ]


def _count(found: list[Acceptability]) -> str:
    counts = Counter(found)
    return ", ".join(f"{counts[one]} {one.value}" for one in reversed(Acceptability))


def _hazards(hazards: tuple[Hazard, ...]) -> list[str]:
    rows, before, after = [], [], []
    for one in hazards:
        risk = _risk(one)
        levels = (one.row.severity, risk.probability)
        left = (risk.residual_severity, risk.residual_probability)
        before.append(MATRIX[levels[0]][levels[1]])
        after.append(MATRIX[left[0]][left[1]])
        rows.append((_link(one), _level(*levels), one.row.control, _level(*left), risk.because))
    columns = ("hazard", "before", "controls", "after", "why so far and no further")
    return [
        f"{len(hazards)} hazards. Before: {_count(before)}. After: {_count(after)}.",
        "",
        *table(columns, rows),
        "",
    ]


def _verification(hazards: tuple[Hazard, ...]) -> list[str]:
    rows = [(one.row.id, _faults(one), ", ".join(one.row.requirements)) for one in hazards]
    files: dict[str, set[str]] = {}
    for mark in matrix.read().marks:
        files.setdefault(mark.requirement, set()).add(mark.test.split("::")[0])
    verified = [
        (name, sentence, ", ".join(f"`{file}`" for file in sorted(files.get(name, ()))))
        for name, sentence in hazard.requirements().items()
    ]
    return [
        *table(("hazard", "faults that `opensuction safety-case` runs", "requirements"), rows),
        "",
        *table(("requirement", "says", "verified by"), verified),
        "",
    ]


def _faults(one: Hazard) -> str:
    return ", ".join(dict.fromkeys(f"`{claim.name}`" for claim in one.claims))


def markdown() -> str:
    """Levels, hazards, verification, each under its heading."""
    hazards = hazard.load()
    return "\n".join(
        [
            "",
            "## Levels, and what follows from them",
            "",
            *_levels(),
            "## Hazards",
            "",
            *_hazards(hazards),
            "## Verification of the controls",
            "",
            *_verification(hazards),
            "",
        ]
    )


def unacceptable() -> list[str]:
    """Identifiers of the hazards whose risk is not acceptable with their controls either."""
    return [one.row.id for one in hazard.load() if _after(one) == Acceptability.UNACCEPTABLE]


def _after(one: Hazard) -> Enum:
    risk = _risk(one)
    return MATRIX[risk.residual_severity][risk.residual_probability]
