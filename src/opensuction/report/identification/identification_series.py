"""Curves of an identification, thinned for a page: every extreme and every reversal is kept."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.report.series import decimals_of, directions, keep_rows, to_list

Array = npt.NDArray[np.float64]

BUCKETS = 350
"""Stretches of time of which each keeps its extremes: fewer than pixels, more than the eye asks."""

LOOP_REVERSALS = 30
"""Reversals that the loop plot shows; more lie on top of one another."""

REVERSAL_RATIO = 0.02
"""Motion against its direction, as a share of the range, that counts as a reversal."""

LAGS = 300
"""Lags of the autocorrelation that are drawn."""


class FittedCurves(NamedTuple):
    """A recording and what each model makes of it, arrays of shape (samples,)."""

    time_s: Array | None
    """None: samples are counted instead."""
    driven: Array
    answer: Array
    fitted: Mapping[str, Array]
    """By the name of the model, in the order of the page."""
    autocorrelation: Mapping[str, Array]
    """Of the residuals, from lag 0; by the name of the model."""
    fitted_samples: int
    """The samples after these were held out."""


def loop_end(driven: Array) -> int:
    """Number of samples that show the first `LOOP_REVERSALS` reversals; all of them if fewer."""
    rises = directions(driven, REVERSAL_RATIO * float(np.ptp(driven)))
    reversals = np.flatnonzero(np.diff(rises)) + 1
    return int(reversals[LOOP_REVERSALS] if reversals.size > LOOP_REVERSALS else driven.size)


def _loop(curves: FittedCurves, decimals: tuple[int, int]) -> dict[str, Any]:
    """Rows of the loop plot: consecutive in time, so that its lines are motions."""
    end = loop_end(curves.driven)
    shown = [curves.driven[:end], curves.answer[:end]]
    slope, intercept = (float(factor) for factor in np.polyfit(shown[0], shown[1], 1))
    line = slope * curves.driven + intercept
    rows = keep_rows([*shown, shown[1] - line[:end]], [], BUCKETS)
    return {
        "samples": end,
        "line": to_list(line[rows], decimals[1] + 1),
        "input": to_list(curves.driven[rows], decimals[0]),
        "output": to_list(curves.answer[rows], decimals[1]),
        "fitted": _thin(curves.fitted, rows, decimals[1]),
    }


def _thin(
    series: Mapping[str, Array], rows: npt.NDArray[np.int64], decimals: int
) -> dict[str, list[float | None]]:
    return {name: to_list(values[rows], decimals) for name, values in series.items()}


def _autocorrelation(curves: FittedCurves) -> dict[str, Any]:
    """Autocorrelation by lag, in seconds where the samples are evenly spaced in time."""
    most = max((values.size for values in curves.autocorrelation.values()), default=0)
    most = min(most, LAGS)
    step_s = 1.0
    if curves.time_s is not None and curves.time_s.size > 1:
        step_s = float(curves.time_s[-1] - curves.time_s[0]) / (curves.time_s.size - 1)
    return {
        "lag": to_list(step_s * np.arange(most, dtype=np.float64), 6),
        "values": {
            name: to_list(
                np.pad(values[:most], (0, most - values[:most].size), constant_values=np.nan), 4
            )
            for name, values in curves.autocorrelation.items()
        },
        # Residuals that are noise stay within this in 95 of 100 lags.
        "band": 1.96 / math.sqrt(curves.fitted_samples),
    }


def plots(curves: FittedCurves) -> dict[str, Any]:
    """Data that the page's script draws, ready for JSON."""
    size = curves.answer.size
    time = np.arange(size, dtype=np.float64) if curves.time_s is None else curves.time_s
    rests = {name: curves.answer - fitted for name, fitted in curves.fitted.items()}
    rows = keep_rows([curves.answer, *rests.values()], [curves.fitted_samples - 1], BUCKETS)
    decimals = decimals_of(float(np.ptp(curves.driven))), decimals_of(float(np.ptp(curves.answer)))
    held = None if curves.fitted_samples >= size else float(time[curves.fitted_samples])
    return {
        "timed": curves.time_s is not None,
        "time": to_list(time[rows], decimals_of(float(np.ptp(time)))),
        "output": to_list(curves.answer[rows], decimals[1]),
        "fitted": _thin(curves.fitted, rows, decimals[1]),
        "rest": _thin(rests, rows, decimals[1] + 1),
        "held_from": held,
        "loop": _loop(curves, decimals),
        "autocorrelation": _autocorrelation(curves),
    }
