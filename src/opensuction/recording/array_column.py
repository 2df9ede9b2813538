"""A column of a recording from an array, as files of arrays hold it: one row of finite numbers.

Bounds of a recording: how large it may be, and how much of it may be missing.

Two columns of a recording that belong together, what drives and what follows, and their time.

What is refused here is refused in the words of the file: names of its columns, numbers of its rows.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.column_unit import seconds_in_name

Array = NDArray[np.float64]

LEAST_SAMPLES = 12
"""Fewest samples that any estimator takes: five parameters, and something to judge them by."""


class Pair(NamedTuple):
    """Driven and following quantity at the same instants, arrays of shape (samples,)."""

    driven: Array
    answer: Array
    time_s: Array | None
    """Rising; None where the recording has no time, and its samples count as evenly spaced."""
    others: tuple[Array, ...] = ()
    """Further quantities that drive."""


LATEST_S = 1e11
"""Beyond the year 5000, counted from 1970: such a time is in ms or less."""


def check_time(name: str, time_s: Array) -> None:
    """Refuse a time that does not rise, or is in no seconds; raises InputError with the row."""
    late = np.flatnonzero(np.abs(time_s) > LATEST_S)
    if late.size:
        raise InputError(
            f"column {name!r}: sample {late[0] + 1} is at {time_s[late[0]]:g} s, more than any "
            "clock counts; if it is in another unit, give it by --time-unit, such as ms"
        )
    steps = np.diff(time_s)
    bad = np.flatnonzero(~(steps > 0.0))
    if not bad.size:
        return
    row = int(bad[0])
    what = "the same as" if steps[row] == 0.0 else "before"
    raise InputError(
        f"column {name!r}: sample {row + 2} is at {time_s[row + 1]:g} s, {what} the sample above "
        f"at {time_s[row]:g} s ({bad.size} such in {time_s.size}); time should rise: sort the "
        "rows and remove those given twice"
    )


def cut(pair: Pair, from_s: float | None, to_s: float | None) -> Pair:
    """The samples inside a span of time, both ends included; all of a pair without time.

    Raises InputError for a span without samples.
    """
    if pair.time_s is None or (from_s is None and to_s is None):
        return pair
    low = -np.inf if from_s is None else from_s
    high = np.inf if to_s is None else to_s
    inside = (pair.time_s >= low) & (pair.time_s <= high)
    if not inside.any():
        raise InputError(
            f"no sample is from {low:.10g} to {high:.10g} s; the recording is from "
            f"{pair.time_s[0]:.10g} to {pair.time_s[-1]:.10g} s"
        )
    others = tuple(other[inside] for other in pair.others)
    return Pair(pair.driven[inside], pair.answer[inside], pair.time_s[inside], others)


def find_idle_ends(time_s: Array, from_s: float | None, to_s: float | None) -> tuple[str, ...]:
    """Ends of a span that cut nothing off, a sentence each: often another origin was meant."""
    said, (first, last) = [], (float(time_s[0]), float(time_s[-1]))
    if from_s is not None and from_s < first:
        said.append(f"--from {from_s:.10g} cuts nothing: the recording begins at {first:.10g} s.")
    if to_s is not None and to_s > last:
        said.append(f"--to {to_s:.10g} cuts nothing: the recording ends at {last:.10g} s.")
    return tuple(said)


def check(pair: Pair, input_name: str, output_name: str, other_names: tuple[str, ...] = ()) -> None:
    """Refuse what cannot show how one follows the other: too few samples, or a constant."""
    if pair.driven.size < LEAST_SAMPLES:
        samples = f"{pair.driven.size} sample{'s' if pair.driven.size > 1 else ''}"
        raise InputError(f"{samples}, at least {LEAST_SAMPLES} are needed; record several cycles")
    others = zip(other_names, pair.others, strict=False)
    for name, values in ((input_name, pair.driven), (output_name, pair.answer), *others):
        if not np.ptp(values) > 0.0:
            raise InputError(
                f"column {name!r} is constant at {values[0]:g} in all {values.size} samples; "
                "record a motion to and fro"
            )


MOST_SAMPLES = 2_000_000
"""Samples of a recording: an hour at 500 Hz. Three columns of it take 48 MB, and the slowest
estimator still answers in minutes (assumed)."""

LARGEST_TEXT_BYTES = 1_000_000_000
"""Text is read through once, cell by cell: this much takes about half a minute."""


def megabytes(size_bytes: int) -> int:
    """Size in MB for a message, rounded up."""
    return -(-size_bytes // 1_000_000)


def describe_excess(samples: int) -> str:
    """Describe a recording with more samples than the bound."""
    return (
        f"has {samples} rows or more, above the limit of {MOST_SAMPLES}; keep every "
        f"{-(-samples // MOST_SAMPLES)}th row or fewer cycles"
    )


def describe_missing(rows: int, of: int) -> str:
    """Describe rows that lack a number, with a remedy."""
    return f"(in {rows} of {of} rows); fill it in, or leave such rows out with --skip-missing"


SECOND = np.timedelta64(1, "s")


def write_shape(shape: tuple[int, ...]) -> str:
    """A shape in words: ``3 x 4``; of a single number ``1``."""
    return " x ".join(str(length) for length in shape) or "1"


def is_row(shape: tuple[int, ...]) -> bool:
    """True if no more than one axis is longer than 1."""
    return sum(length != 1 for length in shape) <= 1


def check_shape(path: Path, name: str, shape: tuple[int, ...]) -> None:
    """Refuse what is no row or column, or too long; raises InputError."""
    if not is_row(shape):
        raise InputError(
            f"{path}: {name!r} is {write_shape(shape)}, should be one row or column of numbers; "
            "save each column under a name of its own"
        )
    samples = int(np.prod(shape, dtype=np.int64))
    if samples > MOST_SAMPLES:
        raise InputError(f"{path}: {name!r} {describe_excess(samples)}")
    if samples == 0:
        raise InputError(f"{path}: {name!r} has no samples in it")


def count_seconds(instants: NDArray[Any]) -> NDArray[np.float64]:
    """Dates or durations as seconds from the first that is there; NaN for those that are not."""
    there = np.flatnonzero(~np.isnat(instants))
    first = instants[there[0]] if there.size else instants[:1]
    seconds: NDArray[np.float64] = (instants - first) / SECOND
    return seconds


def check_finite(path: Path, name: str, numbers: NDArray[np.float64], allow_missing: bool) -> None:
    """Refuse what are no finite numbers; raises InputError with the first row and the remedy."""
    missing = np.isnan(numbers)
    bad = np.flatnonzero(np.isinf(numbers) if allow_missing else ~np.isfinite(numbers))
    if not bad.size:
        return
    where = f"{path}: row {bad[0] + 1}, column {name!r}"
    if missing[bad[0]]:
        lack = describe_missing(int(missing.sum()), numbers.size)
        raise InputError(f"{where}: missing, should be a number {lack}")
    raise InputError(
        f"{where}: {numbers[bad[0]]} is not finite ({bad.size} such in {numbers.size}); correct or "
        "remove them"
    )


def read_numbers(
    path: Path, name: str, values: NDArray[np.generic], allow_missing: bool = False
) -> NDArray[np.float64]:
    """One array as a row of doubles; dates and durations become seconds from the first.

    Those in a column whose name has a unit of time are in that unit. Raises InputError for another
    shape, and for what are no finite numbers; missing ones are NaN where they are allowed.
    """
    check_shape(path, name, values.shape)
    row = values.reshape(-1)
    if row.dtype.kind in "Mm":
        row = count_seconds(row) / seconds_in_name(name)
    elif row.dtype.kind not in "biuf":
        raise InputError(f"{path}: {name!r} holds {row.dtype}, should hold numbers")
    numbers: NDArray[np.float64] = np.ascontiguousarray(row, dtype=np.float64)
    check_finite(path, name, numbers, allow_missing)
    return numbers
