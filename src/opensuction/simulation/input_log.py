"""Log of the controller's inputs that the trace of a run lacks, so that the run can be replayed."""

from typing import NamedTuple

from opensuction.controller.record import State
from opensuction.kernel.requests import NO_REQUESTS, Requests

BEGUN = "begun"
"""Sets the first state of a run."""
RESTARTED = "restarted"
"""A new controller started, with what the one before had to remember."""
EXPIRED = "catheter-aged"
"""The catheter was made older than it is."""


class InputSpan(NamedTuple):
    """Ticks that follow each other, and what the controller got in them."""

    first: int
    """Row of the trace of the first tick."""
    ticks: int
    tick: int
    """Number of the first tick, as the controller counts."""
    requests: Requests
    """Pressed in the first tick only."""
    late_until_tick: int = 0
    """Ticks before this one are told that the one before them was late."""
    runs: bool = True
    """Whether a controller ran at all."""
    set_by: str = ""
    """What set its state before the first tick; empty where it is what the ticks before left."""
    state: State | None = None
    """That state, where something set it."""

    @property
    def end(self) -> int:
        """Row of the trace after the last tick."""
        return self.first + self.ticks


def _goes_on(span: InputSpan, after: InputSpan) -> bool:
    """True where nothing tells a span from the one before it."""
    same = (after.runs, after.late_until_tick) == (span.runs, span.late_until_tick)
    follows = after.end == span.first and after.tick + after.ticks == span.tick
    return same and follows and not span.set_by and span.requests == NO_REQUESTS


class InputLog:
    """The spans of a run, noted piece by piece as it is played."""

    def __init__(self) -> None:
        self.spans: list[InputSpan] = []
        self._set_by = BEGUN

    def set_state(self, by: str) -> None:
        """Note that the controller's state is another than the last tick left. by: a name."""
        self._set_by = by

    def note(self, span: InputSpan, state: State) -> None:
        """Add a span, in place of what was noted of its ticks before: they are played anew.

        state: before its first tick.
        """
        while self.spans and self.spans[-1].first >= span.first:
            gone = self.spans.pop()
            self._set_by = self._set_by or gone.set_by
        if self.spans:
            last = self.spans[-1]
            self.spans[-1] = last._replace(ticks=span.first - last.first)
        if self._set_by:
            span = span._replace(set_by=self._set_by, state=state)
        if self.spans and _goes_on(span, self.spans[-1]):
            last = self.spans[-1]
            self.spans[-1] = last._replace(ticks=last.ticks + span.ticks)
        else:
            self.spans.append(span)
        self._set_by = ""
