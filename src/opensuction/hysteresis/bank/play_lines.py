"""Plays with a line over each: the one form in which every model of plays drives a head.

A Prandtl-Ishlinskii model has one gain a play, a row of a Preisach triangle a gain for each of its
cells, a play readout likewise, with a slow state beside them. Beyond the recorded range
every line goes on with its mean gain, also a Preisach model's, whose own output stands still there:
a head that is driven goes further than a recording did, and the last cell tells of its own place
only.
Source: [Brokate-1996] ch. 2 for a triangle of relays as rows of plays.
"""

from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach
from opensuction.kernel.record import Array

NO_DECAY_MM = 1.0
"""Decay length where no slow state counts."""


class PlayLines(NamedTuple):
    """Plays that a head moves, and what the tip makes of their positions."""

    widths_mm: Array
    """Full width of each play, at least 0; shape (k,)."""
    lows_mm: Array
    """Position at which the first cell of each begins; shape (k,)."""
    cell_mm: float
    """Length of a cell, the same for all, above 0."""
    gains: Array
    """Slope of the line over each play in each of its cells, mm of tip for each mm of play; shape
    (k, m). The first and the last go on beyond their ends."""
    decay_mm: float
    """Travel over which the slow state forgets, above 0."""
    lag: float
    """mm of tip for each mm of the slow state; 0 where there is none."""
    offset_mm: float
    """Tip with every play at its low and the slow state at 0."""


def of_prandtl_ishlinskii(model: PrandtlIshlinskii) -> PlayLines:
    """The model as plays of one cell; its curvature, which is no line over a play, is left out."""
    weights = np.append(model.slope, model.weights)
    return _lean(
        PlayLines(
            widths_mm=np.append(0.0, 2.0 * model.thresholds_mm),
            lows_mm=np.zeros(weights.size),
            cell_mm=1.0,
            gains=weights[:, None],
            decay_mm=NO_DECAY_MM,
            lag=0.0,
            offset_mm=model.offset_mm,
        )
    )


def of_preisach(model: Preisach) -> PlayLines:
    """The rows of the triangle; a row of fewer cells than the first goes on with its mean gain."""
    levels = model.weights_mm.shape[0]
    level_mm = (model.high_mm - model.low_mm) / levels
    counts = levels - np.arange(levels)
    own = np.arange(levels)[None, :] < counts[:, None]
    gains = np.where(own, model.weights_mm, 0.0) / level_mm
    means = gains.sum(axis=1) / counts
    return _extend(
        PlayLines(
            widths_mm=level_mm * np.arange(levels),
            lows_mm=model.low_mm + 0.5 * level_mm * np.arange(levels),
            cell_mm=level_mm,
            gains=np.where(own, gains, means[:, None]),
            decay_mm=NO_DECAY_MM,
            lag=0.0,
            offset_mm=model.offset_mm,
        ),
        means,
    )


def of_readout(model: PlayReadout) -> PlayLines:
    """The readout of one input, with its slow state. Raises ValueError for more than one."""
    if model.lags.size > 1:
        raise ValueError(f"{model.lags.size} slow states: at most one has a place here")
    lags = bool(model.lags.size)
    return _extend(
        PlayLines(
            widths_mm=model.widths_mm,
            lows_mm=np.full(model.widths_mm.size, model.low_mm),
            cell_mm=(model.high_mm - model.low_mm) / model.gains.shape[1],
            gains=model.gains,
            decay_mm=float(model.decays_mm[0]) if lags else NO_DECAY_MM,
            lag=float(model.lags[0]) if lags else 0.0,
            offset_mm=model.offset_mm,
        ),
        model.gains.mean(axis=1),
    )


def _extend(lines: PlayLines, beyond: Array) -> PlayLines:
    """With a cell more at either end, which goes on. beyond: gains there, shape (k,)."""
    edge = beyond[:, None]
    return _lean(
        lines._replace(
            lows_mm=lines.lows_mm - lines.cell_mm,
            gains=np.hstack([edge, lines.gains, edge]),
            offset_mm=float(lines.offset_mm - lines.cell_mm * beyond.sum()),
        )
    )


def _lean(lines: PlayLines) -> PlayLines:
    """Without plays that add nothing anywhere; one is kept."""
    kept = np.any(lines.gains != 0.0, axis=1)
    kept[0] |= not kept.any()
    return lines._replace(
        widths_mm=np.ascontiguousarray(lines.widths_mm[kept]),
        lows_mm=np.ascontiguousarray(lines.lows_mm[kept]),
        gains=np.ascontiguousarray(lines.gains[kept]),
    )


def total_slopes(lines: PlayLines) -> Array:
    """Slope of the tip over a long travel in each cell, every play moving; shape (m,)."""
    slopes: Array = lines.gains.sum(axis=0)
    return slopes


def why_not_driven(lines: PlayLines) -> str | None:
    """Reason why no head can be driven by the model; None where one can.

    No gain may count against the head, and wherever all plays move the tip must move. A gap, where
    it does not move at all, is crossed and no reason. A slow state takes up to twice its share from
    the slope, right after a reversal; the play without width must make that good.
    """
    if not all(np.isfinite(np.ravel(field)).all() for field in lines):
        return "it holds a number that is not finite"
    if not (lines.cell_mm > 0.0 and lines.decay_mm > 0.0 and (lines.widths_mm >= 0.0).all()):
        return "its cells, its decay length or a width is no length"
    if (lines.gains < 0.0).any():
        worst = float(lines.gains.min())
        return f"it is not monotone: a gain is {worst:.3g}, none should be below 0"
    if not (total_slopes(lines) > 0.0).all():
        return "its tip stands still somewhere while every play moves"
    lagging = 2.0 * max(lines.lag, 0.0)
    direct = float(lines.gains[lines.widths_mm == 0.0].sum(axis=0).min(initial=np.inf))
    direct = direct if (lines.widths_mm == 0.0).any() else 0.0
    if lagging > 0.0 and not direct > lagging:
        return (
            f"it is not monotone: its slow state takes up to {lagging:.3g} from the slope after a "
            f"reversal, and the play without width has {direct:.3g}"
        )
    return None
