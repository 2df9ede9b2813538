"""Two columns of a recording that belong together, what drives and what follows, and their time.

What is refused here is refused in the words of the file: names of its columns, numbers of its rows.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError

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


def check_time(name: str, time_s: Array) -> None:
    """Refuse a time that does not rise; raises InputError with the row."""
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
