"""Records of a life: as it was drawn, and what came of it."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

from opensuction.evidence.lives.life_course import Course
from opensuction.evidence.lives.life_fault import LifeFault
from opensuction.evidence.lives.record_judge import BrokenInvariant

EventKind = Literal["fault", "phase", "process", "told"]


class LifeEvent(NamedTuple):
    """Something that happened."""

    at_s: float
    """From the life's begin."""
    what: str
    kind: EventKind
    """A fault of the life, a phase of the cycle, a process's begin or end, or people told."""


class Life(NamedTuple):
    """A life as it was drawn."""

    seed: int
    machine_seed: int
    faults: tuple[LifeFault, ...]
    cycles: int = 1
    """So many, one after the other, each once the patient has rested."""


class LifeResult(NamedTuple):
    """Outcome of a life."""

    life: Life
    violations: tuple[BrokenInvariant, ...]
    steps: int
    """Steps of all processes."""
    simulated_s: float
    trace: str
    """Hash of all steps in their order, and of the truth."""
    events: tuple[LifeEvent, ...]
    """Course of the life."""


class WatchedLife(NamedTuple):
    """A life that somebody looked at from its begin to its end."""

    result: LifeResult
    course: Course
    recordings: Mapping[str, bytes]
    """Files that its recorders wrote, by their names."""
