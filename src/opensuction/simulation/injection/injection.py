"""One cycle with up to two faults, each at its instant: the trace, and when each was noticed.

The loop runs in pieces; at the instant of a fault the machine is replaced by the faulty one, or the
link between controller and machine is. Which state is safe depends on the hazard: see
`opensuction.simulation.injection.invariant`.

The first sign of a fault in a trace: what noticed it, and when.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple, NoReturn

import numpy as np

from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import RESET
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.transition import Event
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.injection.fault_instant import AT_START, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun, RowBuffer
from opensuction.simulation.outcome import LINES
from opensuction.simulation.trace import Columns, InputSpan, Watcher
from opensuction.twin.fault.fault_table import ROWS

SIGNS = ("time_s", "phase", "cause", "check_failed", "verdict.trips", *LINES)
"""Columns in which the first sign of a fault is looked for."""


class Detector(IntEnum):
    """Means by which a fault is noticed first."""

    TRIP = 0
    """A limit of the governor; ``code`` is a `Condition`."""
    CHECK = 1
    """The pre-use test; ``code`` is a `CheckItem`."""
    ABORT = 2
    """The procedure broke off; ``code`` is an `Event`."""
    REFUSAL = 3
    """The start was refused; ``code`` is a `Refusal`."""
    DRIVE = 4
    """The drives, their watchdog or the power supply, without the controller; ``code`` is the
    `Condition` that the annunciator then shows."""


class FirstSign(NamedTuple):
    """The first sign of a fault."""

    detector: Detector
    code: int
    time_s: float

    @property
    def title(self) -> str:
        """Name of what noticed it, as JSON writes it."""
        names: dict[Detector, type[IntEnum]] = {
            Detector.TRIP: Condition,
            Detector.CHECK: CheckItem,
            Detector.ABORT: Event,
            Detector.REFUSAL: Refusal,
            Detector.DRIVE: Condition,
        }
        if self.detector == Detector.DRIVE and self.code == Condition.WATCHDOG_FIRED:
            return "drive-watchdog"
        return name_of(names[self.detector](self.code))


def _find_trip(columns: Columns, first: int) -> FirstSign | None:
    masks = columns["verdict.trips"].astype(np.int64)
    known = int(masks[first - 1]) if first > 0 else 0
    new = np.flatnonzero(masks[first:] & ~known)
    if not new.size:
        return None
    tick = first + int(new[0])
    code = condition_mask.decode_trips(int(masks[tick]) & ~known)[0]
    return FirstSign(Detector.TRIP, code, float(columns["time_s"][tick]))


def _find_failed_check(columns: Columns, first: int) -> FirstSign | None:
    failed = np.flatnonzero(columns["check_failed"][first:])
    if not failed.size or (first > 0 and columns["check_failed"][first - 1] != 0.0):
        return None
    tick = first + int(failed[0])
    code = int(columns["check_failed"][tick])
    return FirstSign(Detector.CHECK, code, float(columns["time_s"][tick]))


def _find_abort(columns: Columns, first: int) -> FirstSign | None:
    broken = np.isin(columns["phase"], (Phase.ABORTING, Phase.HALTED))
    began = np.flatnonzero(broken[first:])
    if not began.size or (first > 0 and broken[first - 1]):
        return None
    tick = first + int(began[0])
    return FirstSign(Detector.ABORT, int(columns["cause"][tick]), float(columns["time_s"][tick]))


def find_lines(columns: Columns, first: int) -> list[FirstSign]:
    """First signs on the annunciator's own lines, shown from a tick on and not before."""
    found = []
    for name, line in LINES.items():
        shown = np.flatnonzero(columns[name][first:])
        if shown.size and not (first > 0 and columns[name][first - 1]):
            time_s = float(columns["time_s"][first + int(shown[0])])
            found.append(FirstSign(Detector.DRIVE, line.condition, time_s))
    return found


def find_notice(columns: Columns, from_s: float) -> FirstSign | None:
    """The first sign of trouble from an instant on that was not there before; None for none.

    A trip, an item of the pre-use test or another event that broke the cycle off, whichever comes
    first; of those of one tick the first named says most.
    """
    first = round(from_s / DT_S)
    signs = [find(columns, first) for find in (_find_trip, _find_failed_check, _find_abort)]
    found = [sign for sign in signs if sign is not None]
    return min(found, key=lambda sign: sign.time_s, default=None)


MOST_FAULTS = 2
"""Single and double faults; more at once are not looked at."""
LIMIT_S = 180.0
"""No cycle lasts longer: every phase has a limit of its own."""
PIECE_S = 2.0
"""Simulated at once; the last piece before a fault ends with the tick before it. To hand a state
to compiled code and take it back costs as much as a few tenths of a second of it; what is played
beyond the begin of a phase that a fault waits for is played again."""
BEGIN_S = 0.5
"""Simulated at once until the machine has begun."""
IDLE_S = 1.0
"""A machine that has not begun by then was refused its start."""
AFTERMATH_S = 5.0
"""How long the machine is watched once it rests."""
ALONE_S = 30.0
"""How long it is watched once its controller is gone for good: longer than a withdrawal takes."""
RESET_S = 1.0
"""How long after the machine has come to rest a person resets it."""


class Injected(NamedTuple):
    """One fault of a run."""

    injection: Injection
    at_s: float
    """First tick with the fault; nan where its instant never came."""
    notice: FirstSign | None
    """The first sign after it; None where nothing noticed it."""


class InjectedRun(NamedTuple):
    """Result of a run with faults."""

    state: LoopState
    columns: Columns
    faults: tuple[Injected, ...]
    """In the order of the injections."""
    sent: Columns
    """The same columns with the commands that the controller sent: under a fault of the link the
    drives obeyed others."""
    stopped_tick: int = -1
    """When the controller stopped; -1 where it did not."""
    spans: tuple[InputSpan, ...] = ()
    """What the controller got beside its readings."""
    before: tuple[LoopState | None, ...] = ()
    """State of both sides before the first tick with each fault; None where it never came."""


def _check_one(injection: Injection) -> None:
    fault, at = injection.fault, injection.at
    ROWS[fault].check_strength(injection.strength)
    if at.after_s < 0.0 or (at.phase is not None and at.after_s >= LIMIT_S):
        _refuse_instant(injection)
    if ROWS[fault].is_setup and at != AT_START:
        raise InputError(
            f"fault '{fault.title}' is one of the set-up: it can only be there from the start, "
            f"without {at.title}"
        )


def _refuse_instant(injection: Injection) -> NoReturn:
    raise InputError(
        f"fault '{injection.fault.title}' at {injection.at.after_s:g} s: an instant is from 0 s to "
        f"less than {LIMIT_S:g} s, the longest that a cycle takes"
    )


def check_faults(injections: Sequence[Injection]) -> None:
    """Refuse what cannot be injected, but for instants beyond a cycle; raises InputError."""
    if len(injections) > MOST_FAULTS:
        raise InputError(f"{len(injections)} faults at once: at most {MOST_FAULTS} are injected")
    for injection in injections:
        _check_one(injection)


def check(injections: Sequence[Injection]) -> None:
    """Refuse what cannot be injected into one cycle; raises InputError."""
    check_faults(injections)
    for injection in injections:
        if not injection.at.after_s < LIMIT_S:
            _refuse_instant(injection)


UNWATCHED = Watcher(trace.NOBODY.hear, PIECE_S)


def run(
    loop: Loop,
    start: LoopState,
    injections: Sequence[Injection],
    after_s: float = AFTERMATH_S,
    resets: int = 0,
    seed: int = 0,
    watcher: Watcher = UNWATCHED,
    room: RowBuffer | None = None,
) -> InjectedRun:
    """Ask for one cycle and let it run until the machine rests, and for ``after_s`` longer.

    resets: how often a person resets the machine if it has halted, each time after `RESET_S`.
    seed: chance of the faults. room: of a caller that has many runs; the next one overwrites its
    columns. Without a fault it gives the healthy loop's rows. Raises InputError for what cannot be
    injected (see `check`).
    """
    check(injections)
    room = make_room(after_s, resets) if room is None else room
    going = FaultyRun(loop, start, injections, room, seed)
    follow(going, after_s, resets, watcher)
    return take(going, injections)


def follow(going: FaultyRun, after_s: float, resets: int, watcher: Watcher = UNWATCHED) -> int:
    """Let a run come to rest, be reset where it has halted, and go on for ``after_s``.

    Returns how often it was reset, of the ``resets`` times that it may.
    """
    most = round(LIMIT_S / DT_S)
    _run_until_rest(going, most, watcher)
    for done in range(resets):
        _run_for(going, RESET_S)
        if not going.is_halted:
            resets = done
            break
        going.requests = RESET
        _run_until_rest(going, going.done + most, watcher)
    _run_for(going, after_s)
    return resets


def take(going: FaultyRun, injections: Sequence[Injection]) -> InjectedRun:
    """Result of a run so far; its columns share the memory of the run."""
    columns = going.columns
    sent, spans = going.sent(columns), tuple(going.inputs.spans)
    ran = InjectedRun(going.state, columns, (), sent, going.stopped_tick, spans)
    found = tuple(
        Injected(injection, at_s, find_first_sign(ran, at_s))
        for injection, at_s in zip(injections, going.at_s, strict=True)
    )
    return ran._replace(faults=found, before=tuple(going.before))


def make_room(
    after_s: float = AFTERMATH_S, resets: int = 0, names: Sequence[str] = COLUMNS
) -> RowBuffer:
    """Room for the longest run; names: columns that are wanted, `SIGNS` among them."""
    return RowBuffer((1 + resets) * LIMIT_S + ALONE_S + after_s, names)


def _run_until_rest(going: FaultyRun, last: int, watcher: Watcher) -> None:
    """Run until the machine rests, or its controller has been gone for long."""
    begun, active = going.done, False
    while going.done < last:
        piece_s = watcher.piece_s if active else min(watcher.piece_s, BEGIN_S)
        going.advance(min(round(piece_s / DT_S), last - going.done))
        watcher.hear(going.last_row)
        active = active or not going.is_resting
        idle = going.done - begun >= round(IDLE_S / DT_S)
        if going.is_abandoned:
            last = min(last, going.stopped_tick + round(ALONE_S / DT_S))
        elif going.is_resting and (active or idle):
            break


def _run_for(going: FaultyRun, seconds: float) -> None:
    """Run for a time."""
    last = going.done + round(seconds / DT_S)
    while going.done < last:
        going.advance(last - going.done)


def find_first_sign(run: InjectedRun, at_s: float) -> FirstSign | None:
    """As `find_notice`, or what was noticed without the controller, or its refusal to start.

    at_s: nan for what never came; negative for what had come before the run's first row.
    """
    if np.isnan(at_s):
        return None
    at_s = max(at_s, 0.0)
    seen = find_notice(run.columns, at_s)
    if seen is not None and round(seen.time_s / DT_S) == run.stopped_tick:
        seen = None  # a controller that stops notices nothing
    signs = [seen, *find_lines(run.columns, round(at_s / DT_S))]
    refusal = run.state.controller.core.upkeep.refusal
    if refusal != Refusal.NONE and at_s == 0.0:  # the start is asked for in the first tick
        signs.append(FirstSign(Detector.REFUSAL, refusal, 0.0))
    found = [sign for sign in signs if sign is not None]
    return min(found, key=lambda sign: sign.time_s, default=None)
