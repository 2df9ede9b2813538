"""A play readout from a recording of one or several inputs, its penalties by cross-validation.

The gains of the first input are held at 0 or above, unless that surely predicts worse; what other
inputs add may have either sign. A slow state comes in only where it surely predicts better.
Source: [Eilers-1996] for the penalty on differences.
"""

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.bank import play_readout
from opensuction.hysteresis.bank.play_bank import PlayBank
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.catalogue.readout_model import (
    CELLS,
    DECAYS,
    RIDGES,
    WIDE_WIDTHS,
    WIDTHS,
)
from opensuction.identification.bank import bank_problem
from opensuction.identification.bank.bank_problem import PASTS, BankTrial, Scaled
from opensuction.identification.record import Folds, Scores, choose_simplest
from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.record import Array

BENDS = (1e-2, 1e-3, 1e-4, 1e-5)
"""Penalties on the differences of neighbouring gains of a play, as shares of the input's
variance."""

MEAN_RIDGE = 1e-5
"""Penalty on the mean gain of a play, likewise: it is held far less than what departs from it, so
that where a recording shows little a play has one gain, and the model is Prandtl-Ishlinskii's."""

FIRST = (1e-4, 1e-4)
"""Ridge and bend with which the past is looked for."""

WORTH_INVERSE = 0.7
"""[design] Gains below 0 are let in where they take away more than three tenths of the squared
error that is left: for less the inverse is not given away."""

WIDE_FROM, WIDE_SHARE = 0.5, 0.05
"""[design] A bank of wide plays is tried beside the usual one, whose widths are far apart there, if
plays wider than half of the range hold a twentieth of the gains."""

LAG_RIDGE = 1e-6
"""Penalty on a slow state: only so much that it is determined."""


class ReadoutFit(NamedTuple):
    """A play readout of one or several inputs, which add up."""

    records: tuple[PlayReadout, ...]
    """One for each input; the offset stands in the first."""
    pasts: tuple[float, ...]
    """Memory ratio of each."""
    scores: Scores
    freedom: float
    """Effective number of factors."""
    bounded: bool
    """Whether the gains of the first input are held at 0 or above."""


def _list_widths(inputs: int, first: Array) -> list[Array]:
    """Widths of each input's plays; those of inputs after the first are every second usual one."""
    return [first, *(WIDTHS[::2] for _ in range(inputs - 1))]


def _bank(widths: Sequence[Array]) -> PlayBank:
    whole = np.concatenate(widths)
    return PlayBank(
        widths_mm=whole,
        lows_mm=np.zeros(whole.size),
        cell_mm=1.0 / CELLS,
        cells=np.full(whole.size, CELLS),
        inputs=np.repeat(np.arange(len(widths)), [each.size for each in widths]),
        goes_on=True,
    )


def _penalty(rows: int, others: int, ridge: float, bend: float, variance: float) -> Array:
    """Penalty on the factors of a bank of plays with `CELLS` cells each, then on other columns.

    A factor is a gain times a cell: the penalties are on the gains.
    """
    steps = np.diff(np.eye(CELLS), axis=0)
    mean = np.full((CELLS, CELLS), 1.0 / CELLS)
    one = MEAN_RIDGE * mean + ridge * (np.eye(CELLS) - mean) + bend * (steps.T @ steps)
    size = rows * CELLS
    whole = np.zeros((size + others, size + others))
    whole[:size, :size] = np.kron(np.eye(rows), variance * CELLS * CELLS * one)
    whole[range(size, size + others), range(size, size + others)] = LAG_RIDGE
    return whole


@single_threaded
def fit(inputs: Array, output: Array, folds: Folds, rising: bool = False) -> ReadoutFit:
    """A play readout of a recording.

    inputs: shape (inputs, n), the one that drives first; each must move. output: shape (n,).
    folds: of the recording. rising: no gain of the first input below 0 and no slow state, whatever
    they would predict better: the output then never moves the wrong way, and a head can be driven.
    Raises InputError where no gains are found.
    """
    usual = _fit(inputs, output, folds, rising, WIDTHS)
    if not _is_wide(usual.records[0]):
        return usual
    wide = _fit(inputs, output, folds, rising, WIDE_WIDTHS)
    return (usual, wide)[choose_simplest([usual.scores.blocks, wide.scores.blocks])]


def _is_wide(record: PlayReadout) -> bool:
    """True where plays wider than `WIDE_FROM` of the range hold a share of the gains."""
    gains = np.abs(record.gains).sum(axis=1)
    far = record.widths_mm > WIDE_FROM * (record.high_mm - record.low_mm)
    return float(gains[far].sum()) > WIDE_SHARE * float(gains.sum())


def _fit(
    inputs: Array, output: Array, folds: Folds, rising: bool, first_widths: Array
) -> ReadoutFit:
    """A play readout with these widths of the first input's plays, as shares of its range."""
    scaled = bank_problem.scale(inputs, output)
    widths = _list_widths(len(inputs), first_widths)
    bank = _bank(widths)
    rows, variance = bank.widths_mm.size, float(scaled.inputs[0].var())
    bounded = np.zeros(rows * CELLS, dtype=np.bool_)
    bounded[: first_widths.size * CELLS] = True
    nothing = np.empty((0, output.size))

    def gather(pasts: list[float], others: Array) -> Array:
        """The sums of the recording after a past of each input."""
        starts = scaled.inputs[:, 0][bank.inputs]
        starts = starts - 0.5 * np.array(pasts)[bank.inputs] * bank.widths_mm
        return bank_problem.gather(bank, scaled.inputs, starts, others, scaled.output, folds.edges)

    first = _penalty(rows, 0, *FIRST, variance)
    pasts = [PASTS[0]] * len(inputs)
    best: tuple[float, Array] | None = None
    for place in range(len(inputs)):
        for past in PASTS if place == 0 else PASTS[1:]:
            trial = [*pasts[:place], past, *pasts[place + 1 :]]
            sums = gather(trial, nothing)
            whole = sums.sum(axis=0)
            left = bank_problem.squares_left(whole, bank_problem.solve(whole, None, first, bounded))
            if best is None or left < best[0]:
                best, pasts = (left, sums), trial
    assert best is not None
    problem = bank_problem.pose(best[1], bounded)
    pairs = [(RIDGES[0], BENDS[0]), *product(RIDGES[1:], BENDS)]
    penalties = [_penalty(rows, 0, ridge, bend, variance) for ridge, bend in pairs]
    chosen = bank_problem.choose_penalty(problem, penalties, folds)
    decays = np.empty(0)
    if rising:
        return _write(scaled, chosen, widths, decays, tuple(pasts), folds)
    unbound = problem._replace(bounded=np.zeros_like(bounded))
    free = bank_problem.evaluate(unbound, chosen.penalty, folds)
    if float(free.blocks.sum()) < WORTH_INVERSE * float(chosen.blocks.sum()):
        chosen = free
    lagging = [_try_lag(gather, pasts, scaled.inputs[0], share, chosen, folds) for share in DECAYS]
    slow = min(range(len(DECAYS)), key=lambda place: float(lagging[place].blocks.sum()))
    if choose_simplest([chosen.blocks, lagging[slow].blocks]) == 1:
        chosen, decays = lagging[slow], np.array([DECAYS[slow]])
    return _write(scaled, chosen, widths, decays, tuple(pasts), folds)


def _try_lag(
    gather: Callable[[list[float], Array], Array],
    pasts: list[float],
    input_: Array,
    decay: float,
    chosen: BankTrial,
    folds: Folds,
) -> BankTrial:
    """The candidate that was chosen, with one slow state beside its plays."""
    lengths = np.array([decay])
    states = play_readout.lag_columns(lengths, input_, -pasts[0] * lengths) / decay
    size = chosen.penalty.shape[0]
    penalty = np.zeros((size + 1, size + 1))
    penalty[:size, :size] = chosen.penalty
    penalty[size, size] = LAG_RIDGE
    bounded = np.append(chosen.problem.bounded, False)
    return bank_problem.evaluate(bank_problem.pose(gather(pasts, states), bounded), penalty, folds)


def _write(
    scaled: Scaled,
    chosen: BankTrial,
    all_widths: Sequence[Array],
    decays: Array,
    pasts: tuple[float, ...],
    folds: Folds,
) -> ReadoutFit:
    """The candidate in the recording's own units."""
    factors = scaled.range_ * chosen.solution.found.factors
    records, first = [], 0
    for place, widths in enumerate(all_widths):
        low, range_ = float(scaled.lows[place]), float(scaled.ranges[place])
        gains = factors[first : first + widths.size * CELLS].reshape(widths.size, CELLS)
        first += gains.size
        lengths = decays * range_ if place == 0 else np.empty(0)
        records.append(
            PlayReadout(
                low_mm=low,
                high_mm=low + range_,
                widths_mm=widths * range_,
                gains=gains * CELLS / range_,
                decays_mm=lengths,
                lags=factors[chosen.penalty.shape[0] - decays.size :][: lengths.size] / lengths,
                offset_mm=scaled.mean + scaled.range_ * chosen.solution.offset * (place == 0),
            )
        )
    records[1:] = [record._replace(offset_mm=0.0) for record in records[1:]]
    return ReadoutFit(
        records=tuple(records),
        pasts=pasts,
        scores=bank_problem.score(chosen, folds, scaled.range_),
        freedom=bank_problem.freedom(chosen.problem, chosen.penalty, chosen.solution),
        bounded=bool(chosen.problem.bounded.any()),
    )
