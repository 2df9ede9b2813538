"""One cycle with up to two faults, each at its instant: the trace, and when each was noticed.

The healthy loop runs in pieces; at the instant its machine is swapped for the faulty one. What is
safe is for the one who asks to say: `opensuction.simulation.safe_state`.
"""

from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import NO_REQUESTS, START, Requests
from opensuction.procedure.check import CheckItem
from opensuction.procedure.transition import Event
from opensuction.procedure.upkeep import Refusal
from opensuction.safety import trip
from opensuction.simulation import closed_loop, trace
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns
from opensuction.twin import fault_effect
from opensuction.twin.fault import Fault, Means
from opensuction.twin.fault_table import KINDS

MOST_FAULTS = 2
"""Single and double faults; more at once are not looked at."""
LIMIT_S = 180.0
"""No cycle lasts longer: every phase has a limit of its own."""
PIECE_S = 0.05
"""Simulated at once; the last piece before a fault ends with the tick before it."""
IDLE_S = 1.0
"""A machine that has not begun by then was refused its start."""
AFTERMATH_S = 5.0
"""How long the machine is watched once it rests."""
_INDEX = {name: i for i, name in enumerate(COLUMNS)}


class Instant(NamedTuple):
    """When a fault comes."""

    phase: Phase | None
    """None: reckoned from the start; else from the first tick of that phase."""
    after_s: float

    @property
    def title(self) -> str:
        """As the command line writes it."""
        if self.phase is None:
            return f"@{self.after_s:g}"
        return f"@{self.phase.name.lower()}+{self.after_s:g}"


AT_START = Instant(phase=None, after_s=0.0)


class Injection(NamedTuple):
    """A fault, when it comes and how strong it is."""

    fault: Fault
    at: Instant
    strength: float


class Detector(IntEnum):
    """What notices a fault first."""

    TRIP = 0
    """A limit of the governor; ``code`` is a `Trip`."""
    CHECK = 1
    """The pre-use test; ``code`` is a `CheckItem`."""
    ABORT = 2
    """The procedure broke off; ``code`` is an `Event`."""
    REFUSAL = 3
    """The start was refused; ``code`` is a `Refusal`."""
    DRIVE = 4
    """The drives' own watchdog; ``code`` is 0."""


class Notice(NamedTuple):
    """The first sign of a fault."""

    detector: Detector
    code: int
    time_s: float

    @property
    def title(self) -> str:
        """Name of what noticed it, as JSON writes it."""
        names: dict[Detector, type[IntEnum]] = {
            Detector.TRIP: trip.Trip,
            Detector.CHECK: CheckItem,
            Detector.ABORT: Event,
            Detector.REFUSAL: Refusal,
        }
        if self.detector not in names:
            return "drive-watchdog"
        return names[self.detector](self.code).name.lower().replace("_", "-")


class Injected(NamedTuple):
    """One fault of a run."""

    injection: Injection
    at_s: float
    """First tick with the fault; nan where its instant never came."""
    notice: Notice | None
    """The first sign after it; None where nothing noticed it."""


class InjectedRun(NamedTuple):
    """What came of a run with faults."""

    state: LoopState
    columns: Columns
    faults: tuple[Injected, ...]
    """In the order of the injections."""


def check(injections: Sequence[Injection]) -> None:
    """Refuse what cannot be injected; raises InputError."""
    if len(injections) > MOST_FAULTS:
        raise InputError(f"{len(injections)} faults at once: at most {MOST_FAULTS} are injected")
    for injection in injections:
        fault_effect.check_strength(injection.fault, injection.strength)
        if not 0.0 <= injection.at.after_s < LIMIT_S:
            raise InputError(
                f"fault '{injection.fault.title}' at {injection.at.after_s:g} s: an instant is "
                f"from 0 s to less than {LIMIT_S:g} s, the longest that a cycle takes"
            )


def _due_tick(injection: Injection, table: npt.NDArray[np.float64], done: int) -> int | None:
    """First tick that a fault acts in; None while its phase has not come.

    table, done: the trace so far. A phase is known after its first tick, so a fault that comes
    with it acts from the second.
    """
    after = round(injection.at.after_s / DT_S)
    if injection.at.phase is None:
        return after
    found = np.flatnonzero(table[:done, _INDEX["phase"]] == injection.at.phase)
    return int(found[0]) + max(after, 1) if found.size else None


def _injected(loop: Loop, injection: Injection) -> Loop:
    """The loop from the instant of a fault on."""
    if KINDS[injection.fault].means == Means.MACHINE:
        machine = fault_effect.faulty(loop.machine, injection.fault, injection.strength)
        return loop._replace(machine=machine)
    raise InputError(f"fault '{injection.fault.title}' cannot be injected into a run")


class _Run:
    """The run as far as it has come."""

    def __init__(
        self, loop: Loop, state: LoopState, injections: Sequence[Injection], room_s: float
    ):
        self.loop, self.state = loop, state
        self.table = trace.rows(room_s)
        self.done = 0
        self.waiting = list(range(len(injections)))
        self.injections = injections
        self.at: list[float] = [float("nan")] * len(injections)
        self.requests: Requests = START

    def inject(self) -> None:
        """Inject whatever is due before the next tick."""
        for i in list(self.waiting):
            if _due_tick(self.injections[i], self.table, self.done) == self.done:
                self.loop = _injected(self.loop, self.injections[i])
                self.at[i] = self.done * DT_S
                self.waiting.remove(i)

    def _next_due(self) -> int | None:
        """Tick of the next fault among those whose instant is known; it may be past."""
        known = (_due_tick(self.injections[i], self.table, self.done) for i in self.waiting)
        return min((tick for tick in known if tick is not None), default=None)

    def advance(self, most: int) -> None:
        """Run one piece of at most so many ticks, which ends where a fault is due."""
        before, begun = self.state, self.done
        due = self._next_due()
        ticks = most if due is None else min(most, due - begun)
        self._play(ticks)
        due = self._next_due()
        if due is not None and due < self.done:  # a phase began within the piece
            self.state, self.done = before, begun
            self._play(due - begun)
        self.requests = NO_REQUESTS

    def _play(self, ticks: int) -> None:
        piece = self.table[self.done : self.done + ticks]
        self.state, ran = closed_loop.run(self.loop, self.state, self.requests, piece)
        self.done += ran

    @property
    def resting(self) -> bool:
        """Whether the machine waits for a person."""
        return bool(closed_loop.is_resting(self.state.controller.procedure.phase))


Watcher = Callable[[npt.NDArray[np.float64]], None]
"""Hears of the last row of each piece."""


def run(
    loop: Loop,
    start: LoopState,
    injections: Sequence[Injection],
    after_s: float = AFTERMATH_S,
    watch: Watcher = lambda _: None,
) -> InjectedRun:
    """Ask for one cycle and let it run until the machine rests, and for ``after_s`` longer.

    With no fault it gives the healthy loop's rows. A machine that is refused its start rests from
    the first tick on. Raises InputError for what cannot be injected (see `check`).
    """
    check(injections)
    going = _Run(loop, start, injections, LIMIT_S + after_s)
    most, piece = round(LIMIT_S / DT_S), round(PIECE_S / DT_S)
    active = False
    while going.done < most:
        going.inject()
        going.advance(min(piece, most - going.done))
        watch(going.table[going.done - 1])
        active = active or not going.resting
        if going.resting and (active or going.done >= round(IDLE_S / DT_S)):
            break
    last = going.done + round(after_s / DT_S)
    while going.done < last:
        going.inject()
        going.advance(min(last - going.done, last))
    columns = trace.by_name(going.table[: going.done])
    found = tuple(
        Injected(injection, at_s, None if np.isnan(at_s) else noticed(columns, at_s))
        for injection, at_s in zip(injections, going.at, strict=True)
    )
    return InjectedRun(going.state, columns, found)


def _trip(columns: Columns, first: int) -> Notice | None:
    masks = columns["verdict.trips"].astype(np.int64)
    known = int(masks[first - 1]) if first > 0 else 0
    new = np.flatnonzero(masks[first:] & ~known)
    if not new.size:
        return None
    tick = first + int(new[0])
    code = trip.names(int(masks[tick]) & ~known)[0]
    return Notice(Detector.TRIP, code, float(columns["time_s"][tick]))


def _check(columns: Columns, first: int) -> Notice | None:
    failed = np.flatnonzero(columns["check_failed"][first:])
    if not failed.size or (first > 0 and columns["check_failed"][first - 1] != 0.0):
        return None
    tick = first + int(failed[0])
    code = int(columns["check_failed"][tick])
    return Notice(Detector.CHECK, code, float(columns["time_s"][tick]))


def _abort(columns: Columns, first: int) -> Notice | None:
    broken = np.isin(columns["phase"], (Phase.ABORTING, Phase.HALTED))
    began = np.flatnonzero(broken[first:])
    if not began.size or (first > 0 and broken[first - 1]):
        return None
    tick = first + int(began[0])
    return Notice(Detector.ABORT, int(columns["cause"][tick]), float(columns["time_s"][tick]))


def noticed(columns: Columns, from_s: float) -> Notice | None:
    """The first sign of trouble from an instant on that was not there before; None for none.

    A trip, an item of the pre-use test or another event that broke the cycle off, whichever comes
    first; of those of one tick the first named says most.
    """
    first = round(from_s / DT_S)
    signs = [find(columns, first) for find in (_trip, _check, _abort)]
    found = [sign for sign in signs if sign is not None]
    return min(found, key=lambda sign: sign.time_s, default=None)
