"""One number of the paper beside ours: how far apart they are, and how far they may be."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Final, Literal, NamedTuple

from opensuction.result.plain import FLAT, IF_FINITE

ClaimSource = Literal["printed", "computed"]
ClaimKind = Literal["calibrated", "predicted", "arithmetic"]
ClaimVerdict = Literal["agrees", "no evidence", "differs"]

PRINTED: Final = "printed"
COMPUTED: Final = "computed"
"""Sources: the paper prints the number, or it follows from numbers that it prints."""
CALIBRATED: Final = "calibrated"
PREDICTED: Final = "predicted"
ARITHMETIC: Final = "arithmetic"
"""Kinds: the twin was chosen so; nothing was fitted to it; no twin takes part."""
AGREES: Final = "agrees"
NO_EVIDENCE: Final = "no evidence"
DIFFERS: Final = "differs"
"""Verdicts."""


class PaperClaim(NamedTuple):
    """A number of the paper, or one that follows from its numbers, and ours."""

    name: str
    where: str
    """Place in the paper of the number, or of those that it is computed from."""
    source: ClaimSource
    kind: ClaimKind
    paper: float
    measured: Annotated[float, IF_FINITE]
    standard_error: Annotated[float, IF_FINITE]
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
        """True if the two agree; a number that could not be measured does not."""
        return abs(self.measured - self.paper) <= self.tolerance

    @property
    def evidence(self) -> bool:
        """True if agreement would tell something: predicted, and not what nothing would give."""
        passing = any(abs(null - self.paper) <= self.tolerance for null in self.nulls)
        return self.kind == PREDICTED and not passing

    @property
    def verdict(self) -> ClaimVerdict:
        """``agrees`` (which is evidence), ``no evidence`` (it agrees, and had to), ``differs``."""
        if not self.ok:
            return DIFFERS
        return AGREES if self.evidence else NO_EVIDENCE

    @property
    def why_no_evidence(self) -> str:
        """Reason for which agreement tells nothing; empty where it tells something."""
        if self.kind == CALIBRATED:
            return "the twin was calibrated to it"
        if self.kind == ARITHMETIC:
            return "no twin takes part"
        passing = [null for null in self.nulls if abs(null - self.paper) <= self.tolerance]
        return f"{passing[0]:g} would pass, too" if passing else ""

    @property
    def is_unexplained(self) -> bool:
        """True if the two differ without an explanation."""
        return not self.ok and not self.explanation


class JudgedClaim(NamedTuple):
    """A claim with its verdict."""

    claim: Annotated[PaperClaim, FLAT]
    ok: bool
    evidence: bool
    why_no_evidence: str
    verdict: ClaimVerdict


def judge(claim: PaperClaim) -> JudgedClaim:
    """A claim with what `PaperClaim` says of it."""
    return JudgedClaim(claim, claim.ok, claim.evidence, claim.why_no_evidence, claim.verdict)


def tally(claims: Sequence[PaperClaim]) -> dict[ClaimVerdict, int]:
    """Number of claims of each verdict."""
    verdicts: tuple[ClaimVerdict, ...] = (AGREES, NO_EVIDENCE, DIFFERS)
    return {verdict: sum(claim.verdict == verdict for claim in claims) for verdict in verdicts}


def counted(counts: Mapping[ClaimVerdict, int]) -> str:
    """The tally in words."""
    return (
        f"{counts[AGREES]} agree as evidence, {counts[NO_EVIDENCE]} agree but are no evidence, "
        f"{counts[DIFFERS]} differ"
    )
