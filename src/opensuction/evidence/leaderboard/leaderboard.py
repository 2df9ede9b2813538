"""Models held against one another by their errors on held-out parts of data sets.

The interval of an error is a block bootstrap: the held-out part is cut into blocks, its strokes,
and blocks are drawn with replacement. It says how much the error would scatter over other strokes
of the same kind, and nothing of another recording.
Source: [Efron-1993].
"""

import math
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction import __version__
from opensuction.evidence.leaderboard import contender, data_set
from opensuction.evidence.leaderboard.contender import Contender
from opensuction.evidence.leaderboard.data_set import DataSet, Found, Published, Samples
from opensuction.evidence.leaderboard.data_set_table import DATA_SETS
from opensuction.identification import record
from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError
from opensuction.kernel.random_stream import RandomStream
from opensuction.kernel.record import Array
from opensuction.settings.wording import one_line

DRAWS = 2000
"""Of a bootstrap: the ends of an interval scatter by some 2 % of its width."""
SEED, PURPOSE = 39, 1
"""Of the draws: the same for every entry, so that equal errors have equal intervals."""
LEVEL_PERCENT = 95.0

Interval = tuple[float, float]


class HeldOutError(NamedTuple):
    """Error on the held-out samples, in free run; intervals hold 95 %."""

    rmse: float
    """Root mean square, in the output's unit."""
    rmse_ci95: Interval
    rmse_percent_of_range: float
    """Of the range of the output, fitted and held-out part together."""
    rmse_percent_of_range_ci95: Interval
    rrse: float
    """Root relative squared error: over the output's deviation from its mean on these samples, so
    that 1 is as good as that mean."""
    rrse_ci95: Interval
    largest: float


class Entry(NamedTuple):
    """One model on one data set."""

    data_set: str
    model: str
    place: int | None
    """By the error, from 1; None where the model could not be fitted."""
    like_best: bool
    """True where the error exceeds the least one by no more than one standard error of the
    difference, block by block."""
    error: HeldOutError | None
    fitted_rrse: float | None
    """On the samples that it was fitted to."""
    seconds: float
    """Of fit and simulation."""
    refused: str | None
    """Why there is no error, in one line."""


class DataSetSummary(NamedTuple):
    """A data set of the table."""

    name: str
    title: str
    state: str
    """``there``, ``generated``, ``not there`` or ``other file``."""
    note: str
    """Where it was found, or why it was not used."""
    simulated: bool
    inputs: tuple[str, ...]
    output: str
    units: tuple[str, ...]
    """Of the inputs and the output; empty where they are not known."""
    sampling: str
    split: str
    fitted_samples: int
    held_out_samples: int
    file: str | None
    sha256: str | None
    licence: str
    source: str
    published: tuple[Published, ...]


class ModelSummary(NamedTuple):
    """A model over all data sets."""

    name: str
    words: str
    scored: int
    """Data sets on which it has an error."""
    refused: int
    like_best: int
    """Data sets on which it is not surely worse than the best."""
    mean_place: float | None
    """Over those on which it has an error."""


class LeaderboardResult(NamedTuple):
    """The table."""

    version: str
    date_utc: str
    data_sets: tuple[DataSetSummary, ...]
    models: tuple[ModelSummary, ...]
    entries: tuple[Entry, ...]
    """By data set, the least error first."""
    interval: str
    """How intervals were made, in words."""
    wall_s: float


class _Scored(NamedTuple):
    entry: Entry
    squares: Array
    """Sums of squared errors of the blocks; empty where there is no error."""


@compiled
def _draw(squares: Array, sizes: NDArray[np.int64], source: RandomStream) -> Array:
    """Root mean squares of blocks drawn with replacement, shape (DRAWS,).

    squares, sizes: sum of squares and samples of each block.
    """
    found = np.empty(DRAWS)
    for draw in range(DRAWS):
        total, samples = 0.0, 0
        for _ in range(squares.size):
            share, _, source = random_stream.uniform_pair(source)
            block = int(share * squares.size)
            total += squares[block]
            samples += sizes[block]
        found[draw] = math.sqrt(total / samples)
    return found


def measure(predicted: Array, samples: Samples) -> tuple[HeldOutError, Array]:
    """Error on the held-out samples, and its sums of squares by block, shape (blocks,)."""
    held_out = slice(samples.held_out, None)
    output = samples.output[held_out]
    rest = output - predicted[held_out]
    folds = record.cut(np.ascontiguousarray(samples.inputs[0][held_out]))
    squares = np.array([float(rest[one] @ rest[one]) for one in folds.cuts])
    rmses = _draw(squares, np.diff(folds.edges), random_stream.stream(SEED, PURPOSE))
    tail = 0.5 * (100.0 - LEVEL_PERCENT)
    ends = np.percentile(rmses, [tail, 100.0 - tail])
    rmse = math.sqrt(float(squares.sum()) / rest.size)
    percent, relative = 100.0 / float(np.ptp(samples.output)), 1.0 / float(output.std())
    low, high = float(ends[0]), float(ends[1])
    error = HeldOutError(
        rmse=rmse,
        rmse_ci95=(low, high),
        rmse_percent_of_range=percent * rmse,
        rmse_percent_of_range_ci95=(percent * low, percent * high),
        rrse=relative * rmse,
        rrse_ci95=(relative * low, relative * high),
        largest=float(np.abs(rest).max()),
    )
    return error, squares


def _score(one: Contender, samples: Samples) -> _Scored:
    began_s = time.perf_counter()
    empty = Entry(samples.data_set.name, one.name, None, False, None, None, 0.0, None)
    try:
        predicted = one.predict(samples)
        if not np.isfinite(predicted).all():
            raise InputError(f"diverges: sample {np.argmin(np.isfinite(predicted))} is no number")
    except InputError as refused:
        seconds = time.perf_counter() - began_s
        words = one_line(" ".join(str(refused).split()))
        return _Scored(empty._replace(seconds=seconds, refused=words), np.empty(0))
    seconds = time.perf_counter() - began_s
    error, squares = measure(predicted, samples)
    known = slice(samples.fitted)
    left = (samples.output - predicted)[known]
    fitted = float(np.sqrt(np.mean(left * left)) / samples.output[known].std())
    return _Scored(empty._replace(error=error, fitted_rrse=fitted, seconds=seconds), squares)


def _rank(scored: Sequence[_Scored]) -> list[Entry]:
    """Entries of one data set, the least error first, those without one last."""
    found = [one for one in scored if one.entry.error is not None]
    found.sort(key=lambda one: float(one.squares.sum()))
    ranked = [
        one.entry._replace(
            place=place, like_best=not record.is_surely_worse(one.squares, found[0].squares)
        )
        for place, one in enumerate(found, 1)
    ]
    return ranked + [one.entry for one in scored if one.entry.error is None]


def _summarise_data(found: Found) -> DataSetSummary:
    one = found.data_set
    split = one.split
    return DataSetSummary(
        name=one.name,
        title=one.title,
        state=found.state,
        note=found.note,
        simulated=one.simulated,
        inputs=one.inputs,
        output=f"-{one.output}" if one.negate_output else one.output,
        units=one.units,
        sampling=one.sampling,
        split=split.words,
        fitted_samples=split.fitted_end - split.first,
        held_out_samples=split.end - split.held_out,
        file=one.file or None,
        sha256=one.sha256 or None,
        licence=one.licence,
        source=one.source,
        published=one.published,
    )


def _summarise_model(one: Contender, entries: Sequence[Entry]) -> ModelSummary:
    own = [entry for entry in entries if entry.model == one.name]
    places = [entry.place for entry in own if entry.place is not None]
    return ModelSummary(
        name=one.name,
        words=one.words,
        scored=len(places),
        refused=sum(entry.refused is not None for entry in own),
        like_best=sum(entry.like_best for entry in own),
        mean_place=float(np.mean(places)) if places else None,
    )


def run(
    folder: Path | None = None,
    models: Sequence[Any] = (),
    data_sets: Sequence[DataSet] = tuple(DATA_SETS.values()),
    show: Callable[[str], None] = lambda _: None,
) -> LeaderboardResult:
    """Fit every model to every data set and measure its error on what was held out.

    folder: in which the files of the data sets lie; None: only what is generated. models: names,
    ``module:Class`` or estimators, as `contender.select` takes them; none: all that are built in.
    show: called with the standing before each fit.

    Raises InputError for an unknown model, a folder that is none, a damaged file, and where none of
    the data sets can be used.
    """
    began_s = time.perf_counter()
    contenders = contender.select(models)
    found = [data_set.find(one, folder) for one in data_sets]
    usable = [one.samples for one in found if one.samples is not None]
    if not usable:
        first = found[0].note if found else "none was named"
        raise InputError(
            f"none of {len(found)} data sets can be used, see --data; the first: {first}"
        )
    pairs = [[one for one in contenders if one.takes(samples)] for samples in usable]
    total, done = sum(map(len, pairs)), 0
    entries: list[Entry] = []
    for samples, taken in zip(usable, pairs, strict=True):
        scored = []
        for one in taken:
            show(f"{done + 1} of {total}: {one.name} on {samples.data_set.name}")
            scored.append(_score(one, samples))
            done += 1
        entries += _rank(scored)
    return LeaderboardResult(
        version=__version__,
        date_utc=datetime.now(tz=UTC).isoformat(timespec="seconds"),
        data_sets=tuple(map(_summarise_data, found)),
        models=tuple(_summarise_model(one, entries) for one in contenders),
        entries=tuple(entries),
        interval=f"{LEVEL_PERCENT:g} %, percentiles of {DRAWS} bootstraps over the strokes of the "
        "held-out part, at most 20 blocks",
        wall_s=time.perf_counter() - began_s,
    )
