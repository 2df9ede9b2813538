"""Recordings as estimators take them: checked, and thinned without losing a turn of the input."""

import math
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
