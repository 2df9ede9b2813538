"""Recordings as estimators take them: checked, and thinned without losing a turn of the input.

Folds of a recording for cross-validation: blocks between reversals, and two separate parts.

A block is the recording between two reversals of the input, or a piece of it where there are few:
each stroke is then predicted from the others, and not from its own neighbours. The two parts, for a
model that is to be transferred, are the slow blocks and the fast ones, or, at one speed, the first
half and the second.
Source: [Racine-2000] for blocks where neighbours are alike; [Breiman-1984] sec. 3.4.3 for the rule
of one standard error.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

MOST_KEPT = 4
"""Turns may make a thinned recording this many times longer than asked for; smaller turns go."""

SMALLEST_TURNS = (0.0, 1e-4, 1e-3, 1e-2, 1e-1)
"""Turns left out of a thinned recording, as shares of the range: none if possible."""

REVERSAL_SHARE = 0.05
"""Smallest reversal counted, as a share of the input's range: smaller ones hardly leave the gap."""

LARGEST, LEAST_RANGE = 1e30, 1e-30
"""[design] Samples beyond the one, and ranges below the other, are of no quantity in a fitting
unit; products of four of them, as the fits form, stay within what a float holds."""


def read_samples(name: str, values: ArrayLike, least: int) -> Array:
    """One recorded quantity as a contiguous array of finite numbers, shape (n,).

    name: how messages call it. least: smallest number of samples that makes sense.
    Raises InputError where it is not a row of numbers, too short, or holds a missing sample or one
    beyond `LARGEST`.
    """
    try:
        record = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: not a row of numbers") from None
    if np.ndim(values) != 1:
        raise InputError(f"{name}: shape {np.shape(values)}, should be one row of samples")
    if record.size < least:
        raise InputError(f"{name}: {record.size} samples, at least {least} are needed")
    bad = np.flatnonzero(~np.isfinite(record))
    if bad.size:
        raise InputError(
            f"{name}: sample {bad[0]} is {record[bad[0]]} ({bad.size} such in {record.size}); "
            "remove or fill them first"
        )
    largest = int(np.argmax(np.abs(record)))
    if abs(record[largest]) > LARGEST:
        raise InputError(
            f"{name}: sample {largest} is {record[largest]:g}, beyond {LARGEST:g}; correct it, or "
            "record in a larger unit"
        )
    return record


def read_pair(
    names: tuple[str, str], first: ArrayLike, second: ArrayLike, least: int
) -> tuple[Array, Array]:
    """Two quantities recorded at the same instants, both as by `read_samples`.

    Raises InputError as `read_samples` does and where their lengths differ.
    """
    one, two = read_samples(names[0], first, least), read_samples(names[1], second, least)
    if one.size != two.size:
        raise InputError(
            f"{names[0]} has {one.size} samples, {names[1]} {two.size}; they should be as many"
        )
    return one, two


class _Extent(NamedTuple):
    """Extent of a quantity."""

    range: float
    back: float
    """Furthest that it comes back from the highest it was before."""
    forth: float
    """Furthest that it rises from the lowest it was before."""


@compiled
def _extent(record: Array) -> _Extent:
    lowest = highest = record[0]
    back = forth = 0.0
    for value in record:
        lowest, highest = min(lowest, value), max(highest, value)
        back, forth = max(back, highest - value), max(forth, value - lowest)
    return _Extent(highest - lowest, back, forth)


def check_motion(names: tuple[str, str], input_: Array, output: Array, unit: str = "") -> None:
    """Refuse what cannot show a hysteresis. names, unit: of the input, as messages call them.

    Raises InputError for an input or output that does not move, or by less than `LEAST_RANGE`, and
    an input that never reverses.
    """
    for name, record in zip(names, (input_, output), strict=True):
        range_ = _extent(record).range
        if not range_ > 0.0:
            raise InputError(f"{name}: constant at {record[0]:g}, should move")
        if range_ < LEAST_RANGE:
            raise InputError(
                f"{name}: moves within {range_:g}, less than {LEAST_RANGE:g}; record in a "
                "smaller unit"
            )
    range_, back, forth = _extent(input_)
    if min(back, forth) < REVERSAL_SHARE * range_:
        raise InputError(
            f"{names[0]}: reverses by {min(back, forth):.4g} of a range of "
            f"{f'{range_:.4g} {unit}'.rstrip()}, at least {REVERSAL_SHARE:.0%} are needed to see a "
            "hysteresis"
        )


@compiled
def find_turns(head_mm: Array, smallest_mm: float) -> NDArray[np.int64]:
    """Samples where the head turns, turns smaller than ``smallest_mm`` left out, shape (turns,)."""
    found = np.empty(head_mm.size, dtype=np.int64)
    count, extreme, direction = 0, 0, 0.0
    for k in range(1, head_mm.size):
        beyond = head_mm[k] - head_mm[extreme]
        if direction == 0.0:
            if abs(beyond) > smallest_mm:
                direction, extreme = math.copysign(1.0, beyond), k
        elif direction * beyond >= 0.0:
            extreme = k
        elif -direction * beyond > smallest_mm:
            found[count] = extreme
            count += 1
            direction, extreme = -direction, k
    return found[:count].copy()


def thin(head_mm: Array, tip_mm: Array, samples: int) -> tuple[Array, Array]:
    """The same recording with about as many samples as asked for, and every turn of the head.

    Between turns a move of the head is monotone, in however many samples it was recorded, so
    the regressors at the samples that stay are those of the full recording. Only where the head
    trembles at every sample are its smallest turns left out.
    """
    regular = np.arange(0, head_mm.size, max(head_mm.size // samples, 1))
    if 2 * regular.size > head_mm.size:
        return head_mm, tip_mm
    range_mm = float(np.ptp(head_mm))
    for share in SMALLEST_TURNS:
        kept = find_turns(head_mm, share * range_mm)
        if kept.size <= (MOST_KEPT - 1) * samples:
            break
    kept = np.union1d(np.append(regular, head_mm.size - 1), kept)
    return head_mm[kept], tip_mm[kept]


BLOCKS = 20
"""Most blocks: short enough that what one holds is seen elsewhere too."""

FEWEST_STROKES = 10
"""With fewer strokes between reversals they are cut into pieces, as many as `BLOCKS` in all: what
one of so few strokes shows cannot be predicted from the others."""

APART = 1.5
"""Ratio of the speeds of fast and slow blocks from which they are told apart."""

LEAST_TURNS = 2
"""Reversals that a fast and a slow part must each have to be told apart: a whole loop."""

ENDS = (0.1, 0.9)
"""Quantiles of the blocks' speeds between which, at their geometric mean, slow ends and fast
begins."""

PLACES = 20
"""Places of the range for each of which is asked whether strokes of either direction passed."""

LEAST_SHARE = 1e-6
"""A block's error is not taken for smaller than this share of the mean: below it is rounding."""


class Folds(NamedTuple):
    """A cut of a recording."""

    edges: NDArray[np.int64]
    """First sample of each block, and the end; shape (blocks + 1,)."""
    parts: NDArray[np.int64]
    """Of each block, which of two parts it belongs to, 0 or 1; shape (blocks,)."""
    by_speed: bool
    """Whether the parts differ in speed, or only in time."""
    reversals: tuple[int, int]
    """Reversals of the input in either part."""
    both_ways: float = 1.0
    """Share of the input's range that strokes of either direction passed through."""

    @property
    def cuts(self) -> list[slice]:
        """The blocks."""
        return [slice(int(a), int(b)) for a, b in zip(self.edges[:-1], self.edges[1:], strict=True)]

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return self.edges.size - 1


class Scores(NamedTuple):
    """Prediction errors of what was left out: sums of squares, in the output's unit squared."""

    blocks: Array
    """Of each block, predicted from all others; shape (blocks,)."""
    parts: Array
    """Of each block, predicted from the blocks of the other part alone; shape (blocks,)."""
    samples: int

    @property
    def rmse(self) -> float:
        """Root mean square error of the blocks left out."""
        return math.sqrt(float(self.blocks.sum()) / self.samples)

    @property
    def apart_rmse(self) -> float:
        """Root mean square error of the parts, each predicted from the other."""
        return math.sqrt(float(self.parts.sum()) / self.samples)


def cut_evenly(samples: int) -> Folds:
    """Folds of a recording of which no input is known: neighbouring blocks of equal length."""
    edges = np.linspace(0, samples, min(BLOCKS, samples) + 1).astype(np.int64)
    parts = (np.arange(edges.size - 1) >= (edges.size - 1) // 2).astype(np.int64)
    return Folds(edges, parts, by_speed=False, reversals=(0, 0))


def cut(input_: Array, time_s: Array | None = None) -> Folds:
    """Folds of a recording. input_: shape (n,); time_s: likewise, None: evenly sampled."""
    turns = find_turns(input_, REVERSAL_SHARE * float(np.ptp(input_)))
    edges = _edges(turns, input_.size)
    marks = np.concatenate([[0], turns, [input_.size - 1]])
    clock = np.arange(input_.size, dtype=np.float64) if time_s is None else time_s
    path = np.append(0.0, np.cumsum(np.abs(np.diff(input_))))
    speeds = np.diff(path[marks]) / np.maximum(np.diff(clock[marks]), 1e-300)
    middles = (edges[:-1] + edges[1:]) // 2
    of_blocks = speeds[np.searchsorted(turns, middles, side="right")]
    low, high = np.quantile(of_blocks, ENDS)
    parts = (of_blocks > math.sqrt(float(low * high))).astype(np.int64)
    fast, slow = of_blocks[parts == 1], of_blocks[parts == 0]
    medians = [float(np.median(each)) if each.size else 0.0 for each in (fast, slow)]
    by_speed = medians[0] > APART * medians[1] > 0.0
    by_speed = by_speed and min(_count_turns(turns, edges, parts)) >= LEAST_TURNS
    if not by_speed:
        parts = (middles > input_.size // 2).astype(np.int64)
    reversals = _count_turns(turns, edges, parts)
    return Folds(edges, parts, by_speed, reversals, _share_both_ways(input_, marks))


def _share_both_ways(input_: Array, marks: NDArray[np.int64]) -> float:
    """Share of the input's range that strokes of either direction passed. marks: their ends."""
    low, range_ = float(input_.min()), max(float(np.ptp(input_)), 1e-300)
    places = np.floor((input_ - low) / range_ * PLACES).clip(0, PLACES - 1).astype(np.int64)
    passed = np.zeros((2, PLACES), dtype=np.bool_)
    for first, end in pairwise(marks.tolist()):
        ends = sorted((int(places[first]), int(places[end])))
        passed[int(input_[end] > input_[first]), ends[0] : ends[1] + 1] = True
    return float(np.mean(passed[0] & passed[1]))


def _count_turns(
    turns: NDArray[np.int64], edges: NDArray[np.int64], parts: NDArray[np.int64]
) -> tuple[int, int]:
    """Reversals in either part; one between blocks belongs to the block that it begins."""
    of_turns = parts[np.searchsorted(edges, turns, side="right") - 1]
    return int(np.sum(of_turns == 0)), int(np.sum(of_turns == 1))


def _edges(turns: NDArray[np.int64], samples: int) -> NDArray[np.int64]:
    """Edges of the blocks: some of the turns, or all of them and places between."""
    marks = np.unique(np.concatenate([[0], turns, [samples]]))
    if marks.size - 1 > BLOCKS:
        even = np.linspace(0, samples, BLOCKS + 1)
        marks = np.unique(marks[np.abs(marks[:, None] - even).argmin(axis=0)])
    usual = samples / BLOCKS if marks.size - 1 < FEWEST_STROKES else samples
    edges = [0]
    for first, end in pairwise(marks.tolist()):
        pieces = max(round((end - first) / usual), 1)
        edges += [int(first + (end - first) * (k + 1) // pieces) for k in range(pieces)]
    return np.array(edges, dtype=np.int64)


def list_parts(folds: Folds) -> list[list[int]]:
    """The blocks of each of the two parts."""
    return [np.flatnonzero(folds.parts == part).tolist() for part in (0, 1)]


def standard_error(differences: Array) -> float:
    """Standard error of a sum over blocks, from their scatter. differences: shape (blocks,)."""
    if differences.size < 2:
        return math.inf
    return math.sqrt(differences.size) * float(differences.std(ddof=1))


def choose_simplest(squares: Sequence[Array]) -> int:
    """The first of candidates, simplest first, that is not surely worse than the best of them.

    squares: of each candidate, sums of squared errors of the blocks left out, shape (blocks,).
    Not surely worse: by no more than one standard error of the difference, block by block. That is
    asked twice: of the squares, and, among those that pass, of their logarithms. A block that holds
    what is seen nowhere else, as the end of a range, outweighs all others in the one; in the other
    every block counts alike.
    """
    totals = np.array([float(each.sum()) for each in squares])
    least = squares[int(np.argmin(totals))]
    passed = [place for place, each in enumerate(squares) if not is_surely_worse(each, least)]
    floor = max(LEAST_SHARE * float(least.mean()), 1e-300)
    logs = {place: np.log(np.maximum(squares[place], floor)) for place in passed}
    best = min(passed, key=lambda place: float(logs[place].sum()))
    return next(place for place in passed if not is_surely_worse(logs[place], logs[best]))


def is_surely_worse(one: Array, other: Array) -> bool:
    """True where errors exceed others by more than one standard error; shape (blocks,)."""
    gap = one - other
    return float(gap.sum()) > standard_error(gap)
