"""One parameter of the twin: a row of the tables of machines, their sensors and patients."""

from typing import NamedTuple


class Parameter(NamedTuple):
    """One parameter of the twin."""

    value: float
    spread: float
    unit: str
    meaning: str
    source: str
    low: float
    """Least plausible value: a file may set it from here on."""
    high: float
    """Largest plausible value."""


def parameter_row(
    value: float,
    unit: str,
    within: tuple[float, float],
    meaning: str,
    source: str,
    spread: float = 0.0,
) -> Parameter:
    """A row as the tables write it: value, unit, range, meaning, source, spread."""
    low, high = within
    return Parameter(value, spread, unit, meaning, source, float(low), float(high))


Cells = tuple[tuple[float, float], ...]
"""Value and standard deviation between patients, for each preset of them."""
Numbers = tuple[Cells | float, str, tuple[float, float]]
"""Cells, or one value of all presets without spread; unit; least and largest plausible value."""
Words = tuple[str, str]
"""Meaning and source."""
