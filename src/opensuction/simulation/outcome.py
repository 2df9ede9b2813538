"""Outcome of a recorded cycle: the figures that reports, tests and trials share."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.phase import Phase
from opensuction.oracle import exposure, harm
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import Harm
from opensuction.procedure.cycle.transition import Event
from opensuction.safety import condition_mask
from opensuction.safety.alarm import alarm_episode
from opensuction.safety.alarm.alarm_episode import Episode
from opensuction.safety.condition import Condition
from opensuction.simulation import alarm_record, annunciation
from opensuction.simulation.annunciation import Annunciation
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns, PhaseSpan, phase_spans
from opensuction.twin.machine.machine import Machine

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
        alarms=alarm_episode.list_episodes(alarm_record.log(trace)),
        told=tuple(annunciation.told(trace)),
        abort=find_abort(trace),
    )
