"""One number of the paper beside ours: how far apart they are, and how far they may be.

Standard errors of the difference of two numbers, from the scatter of both.

A tolerance is exceeded by chance in one case of twenty: it is the standard error times the quantile
of Student's t, its degrees of freedom by Welch and Satterthwaite.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Final, Literal, NamedTuple

import numpy as np
from scipy.special import ndtr, stdtrit

from opensuction.result.plain import FLAT, IF_FINITE

CHANCE = 0.05
"""Share of equal pairs that a tolerance takes for different."""
GRID = 4001
"""Points at which a largest value's distribution is integrated."""


class Uncertainty(NamedTuple):
    """Of the difference of two numbers, in their unit."""

    standard_error: float
    tolerance: float


def _combined(variances: Sequence[float], degrees: Sequence[float]) -> Uncertainty:
    """From the variance of each number and the degrees of freedom that it is known with."""
    total = math.fsum(variances)
    if total == 0.0:
        return Uncertainty(0.0, 0.0)
    freedom = total**2 / math.fsum(v * v / d for v, d in zip(variances, degrees, strict=True))
    error = math.sqrt(total)
    return Uncertainty(error, error * float(stdtrit(freedom, 1.0 - 0.5 * CHANCE)))


def of_means(*samples: Sequence[float]) -> Uncertainty:
    """Of the difference of the means of two samples."""
    return _combined(
        [float(np.var(sample, ddof=1)) / len(sample) for sample in samples],
        [len(sample) - 1.0 for sample in samples],
    )


def of_spreads(*samples: Sequence[float]) -> Uncertainty:
    """Of the difference of the standard deviations of two samples, taken as normal."""
    degrees = [len(sample) - 1.0 for sample in samples]
    spreads = [float(np.var(sample, ddof=1)) for sample in samples]
    halves = [value / (2.0 * freedom) for value, freedom in zip(spreads, degrees, strict=True)]
    return _combined(halves, degrees)


def of_one(sample: Sequence[float]) -> Uncertainty:
    """Of one number and the mean of a sample, the one being one more draw of the same."""
    drawn = float(np.var(sample, ddof=1))
    return _combined([drawn * (1.0 + 1.0 / len(sample))], [len(sample) - 1.0])


def of_same_mean(sample: Sequence[float], others: int) -> Uncertainty:
    """Of a mean of ``others`` values and that of a sample, both scattered like the sample."""
    drawn = float(np.var(sample, ddof=1))
    return _combined([drawn * (1.0 / others + 1.0 / len(sample))], [len(sample) - 1.0])


def of_largest(*samples: Sequence[float]) -> Uncertainty:
    """Of the difference of the largest absolute values of two samples, taken as normal."""
    return _combined(
        [_largest_variance(sample) for sample in samples],
        [len(sample) - 1.0 for sample in samples],
    )


def _largest_variance(sample: Sequence[float]) -> float:
    """Variance of the largest absolute value of as many normal draws."""
    mean, spread = float(np.mean(sample)), float(np.std(sample, ddof=1))
    values = np.linspace(0.0, abs(mean) + 8.0 * spread, GRID)
    with np.errstate(divide="ignore", invalid="ignore"):  # of equal values: not known
        below = ndtr((values - mean) / spread) - ndtr((-values - mean) / spread)
    share = np.diff(below ** len(sample))
    centre = 0.5 * (values[1:] + values[:-1])
    largest = float(np.sum(share * centre))
    return float(np.sum(share * (centre - largest) ** 2))


def of_counts(first: int, second: int, trials: int) -> Uncertainty:
    """Of the difference of two counts out of as many trials each.

    Two successes and failures more are reckoned than were seen, so that none or all is not taken
    for certain. Source: [Agresti-1998].
    """
    shares = [(count + 2.0) / (trials + 4.0) for count in (first, second)]
    return _combined([trials * p * (1.0 - p) for p in shares], [trials - 1.0] * 2)


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
