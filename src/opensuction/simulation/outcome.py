"""Outcome of a recorded cycle: the figures that reports, tests and trials share.

Notices to people in a run, with time and source, as the annunciator at the bedside gave them.

The controller's alarms count as far as its messages bring them to the annunciator. The
annunciator's own lines announce the states that no controller can report: that it is silent, late,
or without power.

The alarm log of a recorded run, from the signals in its trace.
"""

import math
from typing import NamedTuple, get_type_hints

import numpy as np
import numpy.typing as npt

from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure, harm
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import Harm
from opensuction.procedure.cycle.transition import Event
from opensuction.safety import condition_mask
from opensuction.safety.alarm import alarm_log
from opensuction.safety.alarm.alarm_log import Episode, Log
from opensuction.safety.alarm.alarm_state import Signals
from opensuction.safety.condition import Condition
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns, PhaseSpan, phase_spans
from opensuction.twin.machine.machine import Machine

CAPACITY = 10_000
"""Entries that are kept of one run; a day of cycles has some dozens."""
CHANGING = ("present", "latched", "acknowledged", "escalated")
"""Signals whose change is an entry in the log; the audio pause is the fifth."""


def _signals(trace: Columns, row: int) -> Signals:
    at = (trace[f"signals.{name}"][row] for name in Signals._fields)
    kinds = get_type_hints(Signals).values()
    return Signals(*(kind(value) for kind, value in zip(kinds, at, strict=True)))


def log(trace: Columns) -> Log:
    """The log of a run; what is signalled in its first tick counts as raised then."""
    time_s = trace["time_s"]
    noted = alarm_log.start(CAPACITY, float(time_s[0]) if time_s.size else 0.0)
    if time_s.size == 0:
        return noted
    changes = np.zeros(time_s.size, dtype=np.bool_)
    paused = (trace["signals.pause_left_s"] > 0.0).astype(np.float64)
    for values in (*(trace[f"signals.{name}"] for name in CHANGING), paused):
        changes |= np.diff(values, prepend=0.0) != 0.0
    for row in np.flatnonzero(changes):
        noted = alarm_log.note(noted, float(time_s[row]), _signals(trace, int(row)))
    return noted


CONTROLLER = "controller"
SAID = "annunciator.said"


class Line(NamedTuple):
    """A line of the annunciator that needs no controller."""

    condition: Condition
    """What it means."""
    by: str
    """Who has raised it."""


LINES = {
    "annunciator.watchdog_fired": Line(Condition.WATCHDOG_FIRED, "drives"),
    "annunciator.message_late": Line(Condition.MESSAGE_LATE, "drives"),
    "annunciator.reserve_used": Line(Condition.RESERVE_ENERGY_USED, "power"),
}
"""Lines by their column."""
COLUMNS = (SAID, *LINES)
"""What the annunciator shows, in the trace."""


class Annunciation(NamedTuple):
    """People were told of a condition."""

    condition: Condition
    at_s: float
    by: str
    """``controller``, ``drives`` or ``power``."""


def _shown(columns: Columns) -> npt.NDArray[np.int64]:
    """Mask of all that is shown in each tick."""
    mask = columns[SAID].astype(np.int64)
    for name, line in LINES.items():
        mask |= columns[name].astype(np.int64) << int(line.condition)
    return mask


def showing(columns: Columns) -> tuple[Condition, ...]:
    """Conditions that are shown in the last tick. columns: see `told`."""
    mask = int(_shown({name: columns[name][-1:] for name in COLUMNS})[0])
    return tuple(Condition(number) for number in condition_mask.decode(mask))


def _teller(columns: Columns, tick: int, condition: Condition) -> str:
    """Source of a condition that is shown in a tick; the controller where it raised it, too."""
    if int(columns[SAID][tick]) >> condition & 1:
        return CONTROLLER
    return next(line.by for line in LINES.values() if line.condition == condition)


def told(columns: Columns) -> list[Annunciation]:
    """Annunciations of a run, in order of time; each condition when it is first shown.

    A condition that is no longer shown and comes again is told again. columns: those of `COLUMNS`
    and ``time_s``, one entry a tick. What is shown in the first tick is told then.
    """
    shown = _shown(columns)
    before = np.concatenate(([0], shown[:-1]))
    news = shown & ~before
    return [
        Annunciation(
            Condition(number),
            float(columns["time_s"][tick]),
            _teller(columns, int(tick), Condition(number)),
        )
        for tick in np.flatnonzero(news)
        for number in condition_mask.decode(int(news[tick]))
    ]


IN_AIRWAY_PHASES = (
    Phase.INSERTING,
    Phase.BACKING_OFF,
    Phase.OPENING,
    Phase.SUCTIONING,
    Phase.WITHDRAWING,
)

VENTED_MMHG = 1.0
"""A line, or a tip, with less draws nothing."""


class TripTime(NamedTuple):
    """A trip and when it happened, s after the start of the run."""

    trip: Condition
    time_s: float


class Abort(NamedTuple):
    """Event that broke a cycle off, with its phase and time."""

    event: Event
    phase: Phase
    time_s: float


class Outcome(NamedTuple):
    """Figures of one cycle; nan where the cycle did not get that far."""

    completed: bool
    target_mm: float
    reached_mm: float
    """Tip when suction began, standing still; its deepest position if it never began."""
    rmse_mm: float
    """Laser minus reference over the tracked span."""
    peak_error_mm: float
    cycle_s: float
    """Until the machine rests again; a patient is followed for longer."""
    negative_pressure_s: float
    """With the valve off its seat and vacuum in the line; the pre-use test strokes it without, and
    does not count."""
    peak_vacuum_mmhg: float
    """In the line, by the truth; not the pre-use test's, which tries the relief valve behind the
    closed one."""
    delivered_vacuum_mmhg: float
    """At the tip, by the truth: the mean over `negative_pressure_s`; nan where that is 0."""
    removed_ml: float
    removed_percent: float
    exposure: PatientExposure
    """What the patient had to bear, by the truth."""
    harm: tuple[Harm, ...]
    """Bounds of the patient that were broken, whosoever's doing it was."""
    trips: tuple[TripTime, ...]
    alarms: tuple[Episode, ...]
    """In the order in which they were raised."""
    told: tuple[Annunciation, ...]
    """What people were told at the bedside, in order of time: what nobody tells is not here."""
    abort: Abort | None


def tracked(trace: Columns, span_s: float | None) -> npt.NDArray[np.bool_]:
    """Ticks over which tracking is scored.

    span_s: that long from the start of insertion (29 s for the paper's cycle), an abort ends it;
    None is from the start of insertion to the end of withdrawal.
    """
    inside = np.isin(trace["phase"], IN_AIRWAY_PHASES)
    if span_s is None or not np.any(inside):
        return inside
    start = int(np.argmax(inside))
    ticks = np.arange(inside.size)
    return inside & (ticks < start + round(span_s / DT_S))


def tracking_error_mm(trace: Columns) -> npt.NDArray[np.float64]:
    """Laser minus reference, shape (ticks,)."""
    return trace["truth.laser_mm"] - trace["demand.reference_mm"]


def trip_times(trace: Columns) -> tuple[TripTime, ...]:
    """Every trip of a run with the tick in which it happened first, in order of time."""
    masks = trace["verdict.trips"].astype(np.int64)
    found = []
    for code in condition_mask.decode_trips(int(np.bitwise_or.reduce(masks))):
        first = int(np.argmax(masks >> int(code) & 1))
        found.append(TripTime(code, float(trace["time_s"][first])))
    return tuple(sorted(found, key=lambda item: item.time_s))


def find_abort(trace: Columns) -> Abort | None:
    """Event that broke a cycle off; None where none did."""
    broken = np.isin(trace["phase"], (Phase.ABORTING, Phase.HALTED))
    first = int(np.argmax(broken))
    if not broken[first] or first == 0:
        return None
    return Abort(
        event=Event(int(trace["cause"][first])),
        phase=Phase(int(trace["phase"][first - 1])),
        time_s=float(trace["time_s"][first]),
    )


def _reached_mm(trace: Columns) -> float:
    sucking = trace["phase"] == Phase.SUCTIONING
    tip = trace["truth.tip_mm"]
    return float(tip[np.argmax(sucking)] if np.any(sucking) else np.max(tip))


def _mean(values: npt.NDArray[np.float64]) -> float:
    return float(np.mean(values)) if values.size else float("nan")


def is_completed(spans: list[PhaseSpan]) -> bool:
    """True for a run of these phases that went on to its planned end."""
    closed = any(span.phase == Phase.CLOSING for span in spans)
    return closed and spans[-1].phase == Phase.PARKED


def outcome(
    trace: Columns,
    machine: Machine,
    target_mm: float,
    secretion_ml: float,
    span_s: float | None = None,
    cap_mm: float = math.inf,
) -> Outcome:
    """Figures of a cycle.

    trace: one run. machine: as it was built. target_mm: stopping point asked for. secretion_ml:
    secretions at the start. span_s: see `tracked`. cap_mm: deepest position that was planned.
    """
    scored = tracked(trace, span_s)
    error = tracking_error_mm(trace)[scored]
    spans = phase_spans(trace)
    resting = np.isin(trace["phase"], (Phase.PARKED, Phase.HALTED))
    checking = trace["phase"] == Phase.CHECKING
    drawing = trace["truth.line_vacuum_mmhg"] > VENTED_MMHG
    sucking = (trace["truth.valve_open_ratio"] > 0.0) & drawing & ~checking
    removed = float(
        trace["truth.secretion_removed_ml"][-1] - trace["truth.secretion_removed_ml"][0]
    )
    borne = exposure.measure(machine, trace)
    return Outcome(
        completed=is_completed(spans),
        target_mm=target_mm,
        reached_mm=_reached_mm(trace),
        rmse_mm=float(np.sqrt(np.mean(np.square(error)))) if error.size else float("nan"),
        peak_error_mm=float(np.max(np.abs(error))) if error.size else float("nan"),
        cycle_s=float(np.count_nonzero(~resting) + 1) * DT_S,
        negative_pressure_s=float(np.count_nonzero(sucking) * DT_S),
        peak_vacuum_mmhg=float(np.max(np.where(checking, 0.0, trace["truth.line_vacuum_mmhg"]))),
        delivered_vacuum_mmhg=_mean(trace["truth.tip_vacuum_mmhg"][sucking]),
        removed_ml=removed,
        removed_percent=100.0 * removed / secretion_ml if secretion_ml > 0.0 else float("nan"),
        exposure=borne,
        harm=harm.find(machine, borne, cap_mm),
        trips=trip_times(trace),
        alarms=alarm_log.list_episodes(log(trace)),
        told=tuple(told(trace)),
        abort=find_abort(trace),
    )
