"""Time series of a trace, thinned for a page: every extreme and every change of phase is kept."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.result.cycle_result import CycleResult

Trace = Mapping[str, npt.NDArray[Any]]
"""Column name to values, one for each tick, all of one length; times rise."""

Series = dict[str, npt.NDArray[np.float64]]
"""Short name to values."""

BUCKETS = 250
"""Stretches of time of which each keeps its extremes: fewer than pixels, more than the eye asks."""

BREATHS_BUCKETS = 500
"""The same for a patient, who is followed for longer and breathes up to once in 1.5 s."""

AFTER_CYCLE_S = 2.0
"""What is seen of the rest after a cycle where the plots show the cycle alone."""
COARSE = 3
"""One of many cycles has so much less detail: a day of them shall not fill a disk."""
AFTER_BUCKETS = 80
"""Buckets of what comes after that: the machine rests, and only alarms and people act."""

REVERSAL_MM = 0.2
"""Head travel against its direction that counts as a reversal; encoder and servo jitter less."""


DIGITS = 4
"""Digits of a value that a plot can show, the first counted at the range of its quantity."""


class PlotColumn(NamedTuple):
    """A series of the page: its short name and the trace's column, with its decimals."""

    name: str
    column: str
    decimals: int
    measured: str = ""
    """Column in its place where a trace lacks it: a machine's own reading of the same."""


MACHINE = (
    PlotColumn("tip", "truth.tip_mm", 2),
    PlotColumn("estimated", "estimate.tip_mm", 2),
    PlotColumn("head", "readings.head_mm", 2),
    PlotColumn("reference", "demand.reference_mm", 2),
    PlotColumn("deepest", "verdict.deepest_mm", 2),
    PlotColumn("valve", "truth.valve_open_ratio", 3, "measured.valve_open_ratio"),
    PlotColumn("line_vacuum", "readings.line_vacuum_mmhg", 1),
    PlotColumn("tip_vacuum", "truth.tip_vacuum_mmhg", 1),
    PlotColumn("removed", "truth.secretion_removed_ml", 3),
    PlotColumn("contact", "truth.contact_n", 3),
)
"""Series of machine and airway; a column that a trace lacks is left out."""

PATIENT = (
    PlotColumn(
        "airway_pressure",
        "truth.airway_pressure_cmh2o",
        2,
        "readings.monitor.airway_pressure_cmh2o",
    ),
    PlotColumn("lung_volume", "truth.lung_volume_ml", 1),
    PlotColumn("lung_volume_loss", "truth.lung_volume_loss_ml", 1),
    PlotColumn("spo2", "truth.spo2_percent", 2, "readings.monitor.spo2_percent"),
    PlotColumn("heart_rate", "truth.heart_rate_per_min", 1, "readings.monitor.heart_rate_per_min"),
)
"""Series of the patient on the machine, likewise."""

MEASURED = ("truth.laser_mm", "truth.tip_mm")
"""Tip position that the tracking error is taken from: the first of these that the trace has."""


def extract(trace: Trace, columns: Sequence[PlotColumn]) -> Series:
    """Series by short name, full length."""
    found = {}
    for entry in columns:
        name = entry.column if entry.column in trace else entry.measured
        if name in trace:
            found[entry.name] = np.asarray(trace[name], dtype=np.float64)
    return found


def _machine(trace: Trace) -> Series:
    """Series of the machine, and the tracking error as measured."""
    series = extract(trace, MACHINE)
    measured = next((name for name in MEASURED if name in trace), None)
    if measured is not None and "reference" in series:
        series["error"] = np.asarray(trace[measured], dtype=np.float64) - series["reference"]
    return series


def keep_rows(
    series: Sequence[npt.NDArray[np.float64]], edges: Sequence[int], buckets: int = BUCKETS
) -> npt.NDArray[np.int64]:
    """Rows to keep: of each bucket its first row and the extremes of every series.

    series: arrays of one length. edges: rows that are kept whatever they hold.
    Returns row numbers in rising order, each once; the first and the last row are among them.
    """
    length = series[0].size
    starts = np.unique(np.linspace(0, length, min(buckets, length), endpoint=False, dtype=np.int64))
    size = int(np.max(np.diff(np.append(starts, length))))
    # Rows of each bucket, the last one repeated where a bucket is shorter than the longest.
    table = np.minimum(
        starts[:, None] + np.arange(size), np.append(starts[1:], length)[:, None] - 1
    )
    kept = [starts, np.asarray([length - 1, *edges], dtype=np.int64)]
    for values in series:
        within = np.where(np.isfinite(values), values, 0.0)[table]
        kept.append(starts + np.argmin(within, axis=1))
        kept.append(starts + np.argmax(within, axis=1))
    rows_kept = np.unique(np.concatenate(kept))
    return rows_kept[(rows_kept >= 0) & (rows_kept < length)].astype(np.int64)


def directions(values: npt.NDArray[np.float64], least: float) -> npt.NDArray[np.bool_]:
    """Direction of a quantity at each row: True while it rises, False while it falls.

    Motions back of up to ``least`` do not count. It counts as rising before its first reversal.
    """
    rises = np.zeros(values.size, dtype=np.bool_)
    turning, rising = float(values[0]), True
    for i, value in enumerate(values.tolist()):
        if rising == (value >= turning):
            turning = value
        elif abs(value - turning) > least:
            turning, rising = value, not rising
        rises[i] = rising
    return rises


def _edges(result: CycleResult, time_s: npt.NDArray[np.float64]) -> list[int]:
    """Rows at which a phase begins."""
    starts = np.asarray([phase.start_s for phase in result.phases], dtype=np.float64)
    return [int(row) for row in np.searchsorted(time_s, starts)]


def decimals_of(range_: float) -> int:
    """Decimals that a plot of a quantity with this range can show.

    >>> [decimals_of(range_) for range_ in (90.0, 0.02, 5000.0)]
    [3, 6, 1]
    """
    if not range_ > 0.0 or not math.isfinite(range_):
        return DIGITS
    return max(DIGITS - math.floor(math.log10(range_)), 0)


def to_list(values: npt.NDArray[np.float64], decimals: int) -> list[float | None]:
    """Values rounded for JSON; what is not finite becomes null."""
    rounded = np.round(values, decimals) + 0.0  # adding zero turns -0.0 into 0.0
    if np.all(np.isfinite(rounded)):
        return rounded.tolist()  # type: ignore[no-any-return]
    return [value if np.isfinite(value) else None for value in rounded.tolist()]


def focus_s(result: CycleResult) -> float | None:
    """End of the part of the record that has the cycle in it; None where it is not known."""
    cycle_s = result.timing.cycle_s
    return None if cycle_s is None else cycle_s + AFTER_CYCLE_S


def _keep(
    result: CycleResult, time_s: npt.NDArray[np.float64], series: Series, buckets: int
) -> npt.NDArray[np.int64]:
    """Rows to keep: the cycle finely, what comes after it coarsely, the last row in any case."""
    end_s = focus_s(result)
    turn = time_s.size
    if end_s is not None:
        turn = int(np.searchsorted(time_s, end_s, side="right"))
    edges = _edges(result, time_s)
    values = list(series.values())
    if not 0 < turn < time_s.size:
        return keep_rows(values, edges, buckets)
    first = keep_rows([part[:turn] for part in values], edges, buckets)
    later = [edge - turn for edge in edges if edge >= turn]
    second = keep_rows([part[turn:] for part in values], later, AFTER_BUCKETS)
    return np.concatenate([first, second + turn])


def _thin(
    result: CycleResult, time_s: npt.NDArray[np.float64], series: Series, buckets: int
) -> dict[str, list[Any]]:
    """Series and ``time``, thinned and ready for JSON; empty where there is nothing."""
    if time_s.size == 0 or not series:
        return {}
    columns = _listed(time_s, series, kept := _keep(result, time_s, series, buckets))
    if "head" in series:
        columns["inward"] = directions(series["head"][kept], REVERSAL_MM).astype(int).tolist()
    return columns


def _listed(
    time_s: npt.NDArray[np.float64], series: Series, kept: npt.NDArray[np.int64]
) -> dict[str, list[Any]]:
    """The rows that are kept as lists for JSON."""
    decimals = {entry.name: entry.decimals for entry in (*MACHINE, *PATIENT)}
    columns: dict[str, list[Any]] = {"time": to_list(time_s[kept], 3)}
    for name, values in series.items():
        columns[name] = to_list(values[kept], decimals.get(name, 3))
    return columns


def machine(result: CycleResult, trace: Trace, buckets: int = BUCKETS) -> dict[str, list[Any]]:
    """Series for the plots of the machine, by short name, all of one length, ready for JSON.

    Besides the series: ``time`` in s and ``inward``, 1 where the head moves inwards. They run to
    the end of the record. Empty where the trace has no rows. buckets: detail of the cycle.
    """
    time_s = np.asarray(trace.get("time_s", ()), dtype=np.float64)
    return _thin(result, time_s, _machine(trace), buckets)


def patient(
    result: CycleResult, trace: Trace, buckets: int = BREATHS_BUCKETS
) -> dict[str, list[Any]]:
    """Series for the plots of the patient, to the end of the trace; empty where nobody is there.

    The trace goes on after the cycle: saturation is lowest after the catheter is out.
    """
    if result.patient is None:
        return {}
    time_s = np.asarray(trace.get("time_s", ()), dtype=np.float64)
    series = extract(trace, PATIENT)
    if time_s.size == 0 or not series:
        return {}
    kept = keep_rows(list(series.values()), _edges(result, time_s), buckets)
    return _listed(time_s, series, kept)
