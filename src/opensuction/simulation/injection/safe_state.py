"""What can be called safe: predicates over the truth of a trace, by name.

Each says of every tick whether it holds. What the controller believes does not count: the twin's
own columns are asked, and the commands that the drives obeyed.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns

Holds = npt.NDArray[np.bool_]
"""Whether something holds, one entry a tick."""

STANDING_MM_PER_S = 0.5
"""Head slower than this stands still."""
STANDING_S = 0.05
"""Time over which its speed is taken."""


class SafeBounds(NamedTuple):
    """What the predicates go by; none has a default."""

    boundary_mm: float
    """Tip here or above is outside the patient."""
    vented_mmhg: float
    """Vacuum up to this is none."""
    vacuum_mmhg: float
    """Highest vacuum allowed."""
    contact_n: float
    """Force up to this is no contact."""


def _tip_outside(columns: Columns, bounds: SafeBounds) -> Holds:
    return columns["truth.tip_mm"] <= bounds.boundary_mm


def _valve_closed(columns: Columns, _bounds: SafeBounds) -> Holds:
    return np.equal(columns["truth.valve_open_ratio"], 0.0)


def _no_suction(columns: Columns, bounds: SafeBounds) -> Holds:
    return columns["truth.tip_vacuum_mmhg"] <= bounds.vented_mmhg


def _vented(columns: Columns, bounds: SafeBounds) -> Holds:
    return columns["truth.line_vacuum_mmhg"] <= bounds.vented_mmhg


def _vacuum_limited(columns: Columns, bounds: SafeBounds) -> Holds:
    return columns["truth.line_vacuum_mmhg"] <= bounds.vacuum_mmhg


def _torque_off(columns: Columns, _bounds: SafeBounds) -> Holds:
    return np.equal(columns["commands.insertion_on"], 0.0)


def _pump_off(columns: Columns, _bounds: SafeBounds) -> Holds:
    return np.equal(columns["commands.pump_on"], 0.0)


def _standing(columns: Columns, _bounds: SafeBounds) -> Holds:
    ticks = round(STANDING_S / DT_S)
    head = columns["truth.head_mm"]
    before = np.concatenate((np.full(min(ticks, head.size), head[0]), head[:-ticks]))
    return np.asarray(np.abs(head - before) <= STANDING_MM_PER_S * STANDING_S)


def _untouched(columns: Columns, bounds: SafeBounds) -> Holds:
    return columns["truth.contact_n"] <= bounds.contact_n


def _resting(columns: Columns, _bounds: SafeBounds) -> Holds:
    return np.isin(columns["phase"], (Phase.PARKED, Phase.HALTED, Phase.OUT_OF_SERVICE))


def _not_started(columns: Columns, _bounds: SafeBounds) -> Holds:
    """At every tick whether insertion has not begun yet."""
    begun = np.isin(columns["phase"], (Phase.PRELOADING, Phase.INSERTING))
    return ~np.logical_or.accumulate(begun)


PREDICATES: dict[str, Callable[[Columns, SafeBounds], Holds]] = {
    "tip-outside": _tip_outside,
    "valve-closed": _valve_closed,
    "no-suction": _no_suction,
    "vented": _vented,
    "vacuum-limited": _vacuum_limited,
    "torque-off": _torque_off,
    "pump-off": _pump_off,
    "standing": _standing,
    "untouched": _untouched,
    "resting": _resting,
    "not-started": _not_started,
}
"""Predicates by name."""

MEANINGS = {
    "tip-outside": "the tip is outside the patient",
    "valve-closed": "the suction valve is closed",
    "no-suction": "no vacuum reaches the tip",
    "vented": "the line is vented",
    "vacuum-limited": "the line's vacuum is within its limit",
    "torque-off": "the insertion drive has no torque",
    "pump-off": "the pump is told to stand still",
    "standing": "the catheter head stands still",
    "untouched": "the tip touches nothing",
    "resting": "the controller waits for a person",
    "not-started": "no insertion has begun",
}
"""Predicates in words."""


def holds(columns: Columns, names: Sequence[str], bounds: SafeBounds) -> Holds:
    """Whether all of the named predicates hold, one entry a tick.

    Raises InputError for a name that is not known.
    """
    result = np.ones(columns["time_s"].size, dtype=np.bool_)
    for name in names:
        if name not in PREDICATES:
            raise InputError(f"unknown safe state '{name}': one of {', '.join(PREDICATES)}")
        result &= PREDICATES[name](columns, bounds)
    return result


def safe_s(columns: Columns, safe: Holds, from_s: float) -> float:
    """The instant from which a state holds to the end of the trace, at or after ``from_s``.

    nan where it does not hold at the end.
    """
    first = round(from_s / DT_S)
    if not safe[-1]:
        return float("nan")
    broken = np.flatnonzero(~safe[first:])
    tick = first if not broken.size else first + int(broken[-1]) + 1
    return float(columns["time_s"][tick])
