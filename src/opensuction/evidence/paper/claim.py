"""One published number beside ours: how far apart they are, and how far they may be."""

from typing import Any, NamedTuple


class PaperClaim(NamedTuple):
    """A number of the paper, or one that follows from its numbers, and ours."""

    name: str
    where: str
    """Place in the paper."""
    paper: float
    measured: float
    tolerance: float
    """Largest difference that counts as agreement, in the claim's unit."""
    unit: str
    origin: str
    """``calibrated`` (the twin was chosen so), ``predicted`` (nothing was fitted to it) or
    ``computed`` (follows from the paper's numbers alone)."""
    note: str = ""
    """Why the tolerance is what it is, or how it was measured."""
    explanation: str = ""
    """Why the two differ, where it is known that they do."""

    @property
    def ok(self) -> bool:
        """Whether the two agree; a number that could not be measured does not."""
        return abs(self.measured - self.paper) <= self.tolerance

    @property
    def verdict(self) -> str:
        """``ok``, ``explained`` (they differ, and it is known why) or ``differs``."""
        if self.ok:
            return "ok"
        return "explained" if self.explanation else "differs"


def plain(claim: PaperClaim) -> dict[str, Any]:
    """A claim as an object of the command's JSON."""
    return claim._asdict() | {"ok": claim.ok, "verdict": claim.verdict}
