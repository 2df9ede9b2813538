"""Ticks by absolute deadlines.

A tick that is missed is counted and skipped: what was not done in time is not done twice as fast
afterwards, for a servo would see a step in time that was none.
"""

from typing import Protocol


class Pacing(Protocol):
    """Says when a loop's next tick is due."""

    deadline_ns: int
    """Of the present tick, by the monotonic clock."""

    @property
    def due_ns(self) -> int:
        """Instant at which the next tick is due, ns."""

    def begin(self, now_ns: int) -> int:
        """Begin the next tick, now; how many were missed before it."""


class DeadlineScheduler:
    """Deadlines a period apart, counted from when it was made."""

    def __init__(self, period_ns: int, now_ns: int) -> None:
        """The first deadline is a period from now."""
        self.period_ns = period_ns
        self.deadline_ns = now_ns
        """Of the present tick."""
        self.skipped = 0
        """Ticks that were missed in all."""

    @property
    def due_ns(self) -> int:
        """Instant at which the next tick is due, ns."""
        return self.deadline_ns + self.period_ns

    def begin(self, now_ns: int) -> int:
        """Begin the next tick, now; how many were missed before it.

        One that is late by less than a period has missed none. Nobody is woken at the deadline
        itself, so whole periods may go by until then.
        """
        self.deadline_ns += self.period_ns
        missed = max(now_ns - self.deadline_ns, 0) // self.period_ns
        self.deadline_ns += missed * self.period_ns
        self.skipped += missed
        return missed
