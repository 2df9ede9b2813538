"""Risk of a hazard before and after its controls: severity and probability of the harm.

The words are those of [ISO-14971]; levels, matrix and every estimate are this project's own
judgement, for no machine is in the field. `docs/safety/risk.md` shows them.
"""

from enum import Enum
from typing import NamedTuple, TypeVar

from opensuction.kernel.errors import InputError

Level = TypeVar("Level", bound=Enum)


class HarmSeverity(Enum):
    """Severity of a harm, least first."""

    NEGLIGIBLE = "negligible"
    MINOR = "minor"
    SERIOUS = "serious"
    CRITICAL = "critical"


SEVERITY_WORDS = {
    HarmSeverity.NEGLIGIBLE: "inconvenience; nothing to treat",
    HarmSeverity.MINOR: "passes by itself, or is put right by the next suctioning",
    HarmSeverity.SERIOUS: "injury that must be treated, or a longer stay",
    HarmSeverity.CRITICAL: "death, or injury that stays, where nobody helps in time",
}


class HarmProbability(Enum):
    """Probability of a harm in a cycle, least first."""

    IMPROBABLE = "improbable"
    REMOTE = "remote"
    OCCASIONAL = "occasional"
    PROBABLE = "probable"
    FREQUENT = "frequent"


PROBABILITY_WORDS = {
    HarmProbability.IMPROBABLE: "less than 1 in 1,000,000 cycles",
    HarmProbability.REMOTE: "1 in 1,000,000 to 1 in 100,000",
    HarmProbability.OCCASIONAL: "1 in 100,000 to 1 in 10,000",
    HarmProbability.PROBABLE: "1 in 10,000 to 1 in 1,000",
    HarmProbability.FREQUENT: "more than 1 in 1,000",
}


class Acceptability(Enum):
    """Acceptability of a risk."""

    ACCEPTABLE = "acceptable"
    REDUCE = "reduce"
    """To be reduced as far as it can be, and weighed against the benefit."""
    UNACCEPTABLE = "unacceptable"


_A, _R, _U = Acceptability.ACCEPTABLE, Acceptability.REDUCE, Acceptability.UNACCEPTABLE
MATRIX = {
    severity: dict(zip(HarmProbability, row, strict=True))
    for severity, row in {
        HarmSeverity.NEGLIGIBLE: (_A, _A, _A, _A, _R),
        HarmSeverity.MINOR: (_A, _A, _A, _R, _U),
        HarmSeverity.SERIOUS: (_A, _R, _R, _U, _U),
        HarmSeverity.CRITICAL: (_R, _R, _U, _U, _U),
    }.items()
}
"""Acceptability by severity, then by probability."""


class RiskEstimate(NamedTuple):
    """Estimate of a hazard's risk beyond its severity; in the table, the section ``risk``."""

    probability: HarmProbability
    """Of the harm of the row's severity, with the machine of [paper]: no governor, watch or
    alarm."""
    residual_severity: HarmSeverity
    """Of the harm that is left with the row's controls."""
    residual_probability: HarmProbability
    because: str
    """Why the controls change it so far and no further."""


def rank(level: Enum) -> int:
    """Place of a level among those of its kind, 0 for the least."""
    return list(type(level)).index(level)


def check(severity: HarmSeverity, risk: RiskEstimate) -> None:
    """Raises InputError where controls make it worse, change nothing, or say nothing."""
    if not risk.because.strip():
        raise InputError("because: is empty; say why the controls change it so far")
    before, after = (
        (severity, risk.probability),
        (
            risk.residual_severity,
            risk.residual_probability,
        ),
    )
    for name, old, new in zip(
        ("residual_severity", "residual_probability"), before, after, strict=True
    ):
        if rank(new) > rank(old):
            raise InputError(
                f"{name}: '{new.value}' is above '{old.value}' before the controls; no control "
                "may make it worse"
            )
    if before == after:
        raise InputError(
            f"residual_probability: '{risk.residual_probability.value}' as before, and no less "
            "severe; controls that change nothing are none"
        )
