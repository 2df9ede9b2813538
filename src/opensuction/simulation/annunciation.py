"""Notices to people in a run, with time and source, as the annunciator at the bedside gave them.

The controller's alarms count as far as its messages bring them to the annunciator. The
annunciator's own lines announce the states that no controller can report: that it is silent, late,
or without power.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.simulation.trace import Columns

CONTROLLER = "controller"
SAID = "annunciator.said"


class Line(NamedTuple):
    """A line of the annunciator that needs no controller."""

    condition: Condition
    """What it means."""
    by: str
    """Who has raised it."""


LINES = {
    "annunciator.watchdog_fired": Line(Condition.WATCHDOG_FIRED, "drives"),
    "annunciator.message_late": Line(Condition.MESSAGE_LATE, "drives"),
    "annunciator.reserve_used": Line(Condition.RESERVE_ENERGY_USED, "power"),
}
"""Lines by their column."""
COLUMNS = (SAID, *LINES)
"""What the annunciator shows, in the trace."""


class Annunciation(NamedTuple):
    """People were told of a condition."""

    condition: Condition
    at_s: float
    by: str
    """``controller``, ``drives`` or ``power``."""


def _shown(columns: Columns) -> npt.NDArray[np.int64]:
    """Mask of all that is shown in each tick."""
    mask = columns[SAID].astype(np.int64)
    for name, line in LINES.items():
        mask |= columns[name].astype(np.int64) << int(line.condition)
    return mask


def showing(columns: Columns) -> tuple[Condition, ...]:
    """Conditions that are shown in the last tick. columns: see `told`."""
    mask = int(_shown({name: columns[name][-1:] for name in COLUMNS})[0])
    return tuple(Condition(number) for number in condition_mask.decode(mask))


def _teller(columns: Columns, tick: int, condition: Condition) -> str:
    """Source of a condition that is shown in a tick; the controller where it raised it, too."""
    if int(columns[SAID][tick]) >> condition & 1:
        return CONTROLLER
    return next(line.by for line in LINES.values() if line.condition == condition)


def told(columns: Columns) -> list[Annunciation]:
    """Annunciations of a run, in order of time; each condition when it is first shown.

    A condition that is no longer shown and comes again is told again. columns: those of `COLUMNS`
    and ``time_s``, one entry a tick. What is shown in the first tick is told then.
    """
    shown = _shown(columns)
    before = np.concatenate(([0], shown[:-1]))
    news = shown & ~before
    return [
        Annunciation(
            Condition(number),
            float(columns["time_s"][tick]),
            _teller(columns, int(tick), Condition(number)),
        )
        for tick in np.flatnonzero(news)
        for number in condition_mask.decode(int(news[tick]))
    ]
