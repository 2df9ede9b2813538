"""Faults to inject: kind, instant and strength."""

from typing import NamedTuple

from opensuction.kernel.phase import Phase
from opensuction.twin.fault.fault import Fault


class FaultInstant(NamedTuple):
    """Instant at which a fault begins."""

    phase: Phase | None
    """None: reckoned from the start; else from the first tick of that phase."""
    after_s: float

    @property
    def title(self) -> str:
        """As the command line writes it."""
        if self.phase is None:
            return f"@{self.after_s:g}"
        return f"@{self.phase.name.lower()}+{self.after_s:g}"


AT_START = FaultInstant(phase=None, after_s=0.0)


class Injection(NamedTuple):
    """A fault, when it comes and how strong it is."""

    fault: Fault
    at: FaultInstant
    strength: float
