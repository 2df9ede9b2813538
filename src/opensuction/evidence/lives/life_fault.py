"""Faults of a life: of processes, host, clock, datagrams, disk and people, with instants by a seed.

A machine's own faults (sensors, drives, conduit) are the safety case's; here the machine is sound.
"""

import math
import random
from collections.abc import Sequence
from enum import StrEnum
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import CYCLE, Phase, name_of

CONTROL, RECORDER, SUPERVISOR, ALL = "control", "recorder", "supervisor", "all"
TARGETS = (CONTROL, RECORDER, SUPERVISOR, ALL)
MOST = 5
"""Faults of one life."""
AT_EDGES = 0.5
"""Share of the faults that come as a phase begins."""
EDGE_S = 0.1
"""So long after its begin at most."""
SPAN_S = 25.0
"""Others come within this time after the life's begin: a start and a whole cycle."""
SHORTEST_S, LONGEST_S = 0.001, 10.0
"""Of what lasts; drawn evenly in its logarithm."""
STEP_S = 90_000.0
"""Largest step of the wall clock: more than a day."""


class Kind(StrEnum):
    """Kind of a fault."""

    KILL = "kill"
    """A process ends at once; ALL: all but the twin."""
    KILL_WRITING = "kill-writing"
    """The recorder ends in the middle of what it next asks of the disk or the database."""
    FREEZE = "freeze"
    """It stands still for a time."""
    STANDSTILL = "standstill"
    """The whole host does, and the twin with it."""
    SLOW = "slow"
    """Other work takes the processors for a time."""
    WALL_CLOCK = "wall-clock"
    """It is set forward or back by this many seconds."""
    MAIL = "mail"
    """For a time a third of the datagrams each is lost, late or comes twice."""
    DISK_FULL = "disk-full"
    """For a time the disk of recordings and records has no room."""
    DISK_FAILING = "disk-failing"
    """For a time it refuses to sync what was written."""
    DISK_SLOW = "disk-slow"
    """For a time it keeps whoever syncs, and some of those who write, waiting for .1 to 3 s."""
    DATABASE = "database"
    """For a time somebody else keeps the records' database locked."""
    POWER = "power"
    """The computer is without power for a time, and its memory is lost; drives and patient go on.
    """
    STOP = "stop"
    """A second person stops the machine."""
    IMPATIENT = "impatient"
    """From then on whoever presses a button presses it again at once."""


STORAGE = (Kind.DISK_FULL, Kind.DISK_FAILING, Kind.DISK_SLOW, Kind.DATABASE)
LASTS = (Kind.FREEZE, Kind.STANDSTILL, Kind.SLOW, Kind.MAIL, Kind.POWER, *STORAGE)


class LifeFault(NamedTuple):
    """A fault of a life."""

    kind: Kind
    target: str
    """One of `TARGETS`; empty where the kind has none."""
    phase: int | None
    """Begin of which phase it is counted from; None: of the life."""
    after_s: float
    """From there."""
    seconds: float
    """How long it lasts, or by how much the clock steps; 0 for what has no length."""
    cycle: int = 0
    """In which cycle of the life it comes, from 0 on."""

    @property
    def title(self) -> str:
        """The fault as people write it: ``freeze-control@inserting+0.020=1.500``.

        One of the second cycle has ``#2`` behind it.
        """
        name = f"{self.kind}-{self.target}" if self.target else str(self.kind)
        where = "" if self.phase is None else name_of(Phase(self.phase))
        sign = "+" if where else ""
        length = f"={self.seconds:.4g}" if self.seconds else ""
        cycle = f"#{self.cycle + 1}" if self.cycle else ""
        return f"{name}@{where}{sign}{self.after_s:.4f}{length}{cycle}"


def check_kinds(names: Sequence[str]) -> tuple[Kind, ...]:
    """Kinds by name; all of them for none. Raises InputError for an unknown one.

    names: each may be several, with commas between them.
    """
    known = {str(kind): kind for kind in Kind}
    names = [name.strip() for some in names for name in some.split(",")]
    for name in names:
        if name not in known:
            raise InputError(f"unknown kind of fault '{name}'; known: {', '.join(known)}")
    return tuple(dict.fromkeys(known[name] for name in names)) or tuple(Kind)


def draw(chance: random.Random, kinds: Sequence[Kind], cycles: int = 1) -> tuple[LifeFault, ...]:
    """One to five faults in each cycle."""
    return tuple(
        _draw_one(chance, kinds)._replace(cycle=cycle)
        for cycle in range(cycles)
        for _ in range(chance.randint(1, MOST))
    )


def _draw_one(chance: random.Random, kinds: Sequence[Kind]) -> LifeFault:
    kind = chance.choice(kinds)
    target = ""
    if kind is Kind.KILL:
        target = chance.choice(TARGETS)
    elif kind is Kind.FREEZE:
        target = chance.choice(TARGETS[:-1])
    seconds = 0.0
    if kind in LASTS:
        seconds = math.exp(chance.uniform(math.log(SHORTEST_S), math.log(LONGEST_S)))
    elif kind is Kind.WALL_CLOCK:
        seconds = chance.choice((-1.0, 1.0)) * math.exp(chance.uniform(0.0, math.log(STEP_S)))
    if chance.random() < AT_EDGES:
        phase = chance.choice(sorted(CYCLE))
        return LifeFault(kind, target, int(phase), chance.uniform(0.0, EDGE_S), seconds)
    return LifeFault(kind, target, None, chance.uniform(0.0, SPAN_S), seconds)
