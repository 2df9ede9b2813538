"""A column of a recording from an array, as files of arrays hold it: one row of finite numbers."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.bound import MOST_SAMPLES, describe_excess, describe_missing

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

    Raises InputError for another shape, and for what are no finite numbers; missing ones are NaN
    where they are allowed.
    """
    check_shape(path, name, values.shape)
    row = values.reshape(-1)
    if row.dtype.kind in "Mm":
        row = count_seconds(row)
    elif row.dtype.kind not in "biuf":
        raise InputError(f"{path}: {name!r} holds {row.dtype}, should hold numbers")
    numbers: NDArray[np.float64] = np.ascontiguousarray(row, dtype=np.float64)
    check_finite(path, name, numbers, allow_missing)
    return numbers
