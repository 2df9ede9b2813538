"""A model that drives, as a section of a file: plays with a line over each, every number checked.

Preisach models, play readouts and Prandtl-Ishlinskii models all drive in this form
(`hysteresis.bank.play_lines`). A head goes by these numbers, so each is looked at before it may.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Gt

from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.kernel.errors import InputError

MOST_PLAYS = 64
"""[design] More than any model has that is identified, 41: a tick looks at each of them."""
MOST_CELLS = 64
"""[design] Likewise: 40 are the most that are identified."""


class Lines(NamedTuple):
    """`PlayLines` as lists."""

    widths_mm: list[float]
    lows_mm: list[float]
    cell_mm: Annotated[float, Gt(0)]
    gains: list[list[float]]
    """A list for each play."""
    decay_mm: Annotated[float, Gt(0)]
    lag: float
    offset_mm: float
    model: str = ""
    """The model of the catalogue that these are the lines of, for people."""


def write(lines: PlayLines, model: str = "") -> Lines:
    """The section of a model."""
    values = (np.asarray(value).tolist() for value in lines)
    return Lines(*values)._replace(model=model)


def read(section: Lines, name: str = "driven") -> PlayLines:
    """The model of a section. name: of the section, for messages.

    Raises InputError for lists of different length, too many or too few, numbers that are not
    finite or below 0 where they must not be, and a model that no head can be driven by.
    """
    plays = len(section.widths_mm)
    if not (plays == len(section.lows_mm) == len(section.gains) and 1 <= plays <= MOST_PLAYS):
        raise InputError(
            f"{name} has {plays} widths_mm, {len(section.lows_mm)} lows_mm and "
            f"{len(section.gains)} lists in gains, should have as many of one as of the others, "
            f"1 to {MOST_PLAYS}"
        )
    cells = {len(row) for row in section.gains}
    if len(cells) != 1 or not 1 <= min(cells) <= MOST_CELLS:
        raise InputError(
            f"{name}.gains has lists of {' and '.join(map(str, sorted(cells)))} numbers, should "
            f"have one number for each cell, the same for all plays, 1 to {MOST_CELLS}"
        )
    for key, values in _numbers(section).items():
        for value in values:
            if not math.isfinite(value):
                raise InputError(f"{name}.{key} holds {value}, should be a finite number")
    if min(section.widths_mm) < 0.0:
        raise InputError(
            f"{name}.widths_mm holds {min(section.widths_mm):g}, none should be below 0"
        )
    lines = PlayLines(
        widths_mm=np.array(section.widths_mm, dtype=np.float64),
        lows_mm=np.array(section.lows_mm, dtype=np.float64),
        cell_mm=section.cell_mm,
        gains=np.array(section.gains, dtype=np.float64),
        decay_mm=section.decay_mm,
        lag=section.lag,
        offset_mm=section.offset_mm,
    )
    reason = play_lines.why_not_driven(lines)
    if reason is not None:
        raise InputError(f"{name} cannot drive a head: {reason}; identify again instead")
    return lines


def _numbers(section: Lines) -> dict[str, list[float]]:
    """Every number by the key that it stands under."""
    return {
        "widths_mm": section.widths_mm,
        "lows_mm": section.lows_mm,
        "gains": [gain for row in section.gains for gain in row],
        "cell_mm": [section.cell_mm],
        "decay_mm": [section.decay_mm],
        "lag": [section.lag],
        "offset_mm": [section.offset_mm],
    }
