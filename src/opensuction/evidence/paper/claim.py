"""One number of the paper beside ours: how far apart they are, and how far they may be."""

import math
from typing import Any, NamedTuple

PRINTED, COMPUTED = "printed", "computed"
"""Sources: the paper prints the number, or it follows from numbers that it prints."""
CALIBRATED, PREDICTED, ARITHMETIC = "calibrated", "predicted", "arithmetic"
"""Kinds: the twin was chosen so; nothing was fitted to it; no twin takes part."""
AGREES, NO_EVIDENCE, DIFFERS = "agrees", "no evidence", "differs"
"""Verdicts."""


class PaperClaim(NamedTuple):
    """A number of the paper, or one that follows from its numbers, and ours."""

    name: str
    where: str
    """Place in the paper of the number, or of those that it is computed from."""
    source: str
    kind: str
    paper: float
    measured: float
    standard_error: float
    """Of the difference of the two, in the claim's unit; nan where neither has a scatter."""
    tolerance: float
    """Largest difference that counts as agreement, in the claim's unit."""
    unit: str
    nulls: tuple[float, ...] = (0.0,)
    """What would be measured were there nothing: no error, no compensator, no scatter."""
    note: str = ""
    """Why the tolerance is what it is, or how it was measured."""
    explanation: str = ""
    """Why the two differ, where it is known that they do."""

    @property
    def ok(self) -> bool:
        """Whether the two agree; a number that could not be measured does not."""
        return abs(self.measured - self.paper) <= self.tolerance

    @property
    def evidence(self) -> bool:
        """Whether agreement would tell something: predicted, and not what nothing would give."""
        passing = any(abs(null - self.paper) <= self.tolerance for null in self.nulls)
        return self.kind == PREDICTED and not passing

    @property
    def verdict(self) -> str:
        """``agrees`` (which is evidence), ``no evidence`` (it agrees, and had to), ``differs``."""
        if not self.ok:
            return DIFFERS
        return AGREES if self.evidence else NO_EVIDENCE

    @property
    def why_no_evidence(self) -> str:
        """Why agreement tells nothing; empty where it does."""
        if self.kind == CALIBRATED:
            return "the twin was calibrated to it"
        if self.kind == ARITHMETIC:
            return "no twin takes part"
        passing = [null for null in self.nulls if abs(null - self.paper) <= self.tolerance]
        return f"{passing[0]:g} would pass, too" if passing else ""

    @property
    def is_unexplained(self) -> bool:
        """Whether the two differ and nobody knows why."""
        return not self.ok and not self.explanation


def plain(claim: PaperClaim) -> dict[str, Any]:
    """A claim as an object of the command's JSON."""
    error = claim.standard_error
    return claim._asdict() | {
        "nulls": list(claim.nulls),
        "standard_error": error if math.isfinite(error) else None,
        "ok": claim.ok,
        "evidence": claim.evidence,
        "why_no_evidence": claim.why_no_evidence,
        "verdict": claim.verdict,
    }


def tally(claims: list[PaperClaim]) -> dict[str, int]:
    """How many claims there are of each verdict."""
    return {
        verdict: sum(claim.verdict == verdict for claim in claims)
        for verdict in (AGREES, NO_EVIDENCE, DIFFERS)
    }


def counted(counts: dict[str, int]) -> str:
    """The tally in words."""
    return (
        f"{counts[AGREES]} agree as evidence, {counts[NO_EVIDENCE]} agree but are no evidence, "
        f"{counts[DIFFERS]} differ"
    )
