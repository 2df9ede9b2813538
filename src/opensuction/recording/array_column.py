"""A column of a recording from an array, as files of arrays hold it: one row of finite numbers."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.bound import MOST_SAMPLES, describe_excess

SECOND = np.timedelta64(1, "s")


def write_shape(shape: tuple[int, ...]) -> str:
    """A shape in words: ``3 x 4``; of a single number ``1``."""
    return " x ".join(str(length) for length in shape) or "1"


def is_row(shape: tuple[int, ...]) -> bool:
    """Whether no more than one axis is longer than 1."""
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


def read_numbers(path: Path, name: str, values: NDArray[np.generic]) -> NDArray[np.float64]:
    """One array as a row of finite doubles; dates and durations become seconds from the first.

    Raises InputError for another shape, and for what are no finite numbers.
    """
    check_shape(path, name, values.shape)
    row = values.reshape(-1)
    if row.dtype.kind in "Mm":
        row = (row - row[0]) / SECOND
    elif row.dtype.kind not in "biuf":
        raise InputError(f"{path}: {name!r} holds {row.dtype}, should hold numbers")
    numbers: NDArray[np.float64] = np.ascontiguousarray(row, dtype=np.float64)
    bad = np.flatnonzero(~np.isfinite(numbers))
    if bad.size:
        raise InputError(
            f"{path}: row {bad[0] + 1}, column {name!r}: {numbers[bad[0]]}, should be a number "
            f"({bad.size} such in {numbers.size}); fill or remove them"
        )
    return numbers
