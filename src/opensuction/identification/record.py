"""Checks that every estimator makes of the recordings it is given."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from opensuction.kernel.errors import InputError

REVERSAL_SHARE = 0.05
"""Smallest reversal counted, as a share of the input's range: smaller ones hardly leave the gap."""


def checked(name: str, values: ArrayLike, least: int) -> NDArray[np.float64]:
    """One recorded quantity as a contiguous array of finite numbers, shape (n,).

    name: how messages call it. least: smallest number of samples that makes sense.
    Raises InputError where it is not a row of numbers, too short, or holds a missing sample.
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
    return record


def checked_pair(
    names: tuple[str, str], first: ArrayLike, second: ArrayLike, least: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two quantities recorded at the same instants, both ``checked``.

    Raises InputError as ``checked`` does and where their lengths differ.
    """
    one, two = checked(names[0], first, least), checked(names[1], second, least)
    if one.size != two.size:
        raise InputError(
            f"{names[0]} has {one.size} samples, {names[1]} {two.size}; they should be as many"
        )
    return one, two


def check_motion(
    names: tuple[str, str], input_: NDArray[np.float64], output: NDArray[np.float64], unit: str = ""
) -> None:
    """Refuse what cannot show a hysteresis. names, unit: of the input, as messages call them.

    Raises InputError for an input or output that does not move and an input that never reverses.
    """
    for name, record in zip(names, (input_, output), strict=True):
        if not np.ptp(record) > 0.0:
            raise InputError(f"{name}: constant at {record[0]:g}, should move")
    range_ = float(np.ptp(input_))
    back = float(np.max(np.maximum.accumulate(input_) - input_))
    forth = float(np.max(input_ - np.minimum.accumulate(input_)))
    if min(back, forth) < REVERSAL_SHARE * range_:
        raise InputError(
            f"{names[0]}: reverses by {min(back, forth):.4g} of a range of "
            f"{f'{range_:.4g} {unit}'.rstrip()}, at least {REVERSAL_SHARE:.0%} are needed to see a "
            "hysteresis"
        )
