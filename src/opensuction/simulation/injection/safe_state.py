"""Predicates of safe states on a trace, by name.

Each is true or false in every tick. They are judged on the truth of the twin and on the commands
that the drives obeyed, not on what the controller has read.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import RESTING
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns

Holds = npt.NDArray[np.bool_]
"""Whether something holds, one entry a tick."""

STANDING_MM_PER_S = 0.5
"""Head slower than this stands still."""
STANDING_S = 0.05
"""Time over which its speed is taken."""


class SafeBounds(NamedTuple):
    """Limits of the predicates; none has a default."""

    boundary_mm: float
    """Tip here or above is outside the patient."""
    vented_mmhg: float
    """Vacuum up to this is none."""
    vacuum_mmhg: float
    """Highest vacuum allowed."""
    contact_n: float
    """Force up to this is no contact."""


def _is_standing(columns: Columns, _bounds: SafeBounds) -> Holds:
    """The catheter head stands still."""
    ticks = round(STANDING_S / DT_S)
    head = columns["truth.head_mm"]
    before = np.concatenate((np.full(min(ticks, head.size), head[0]), head[:-ticks]))
    return np.asarray(np.abs(head - before) <= STANDING_MM_PER_S * STANDING_S)


def _is_not_inserted(columns: Columns, bounds: SafeBounds) -> Holds:
    """At every tick whether the tip has never been in the patient."""
    inside = columns["truth.tip_mm"] > bounds.boundary_mm
    return ~np.logical_or.accumulate(inside)


PREDICATES: dict[str, Callable[[Columns, SafeBounds], Holds]] = {
    "tip-outside": lambda columns, bounds: columns["truth.tip_mm"] <= bounds.boundary_mm,
    "valve-closed": lambda columns, _: columns["truth.valve_open_ratio"] == 0.0,
    "no-suction": lambda columns, bounds: columns["truth.tip_vacuum_mmhg"] <= bounds.vented_mmhg,
    "vented": lambda columns, bounds: columns["truth.line_vacuum_mmhg"] <= bounds.vented_mmhg,
    "vacuum-limited": lambda columns, bounds: (
        columns["truth.line_vacuum_mmhg"] <= bounds.vacuum_mmhg
    ),
    "torque-off": lambda columns, _: columns["commands.insertion_on"] == 0.0,
    "pump-off": lambda columns, _: columns["commands.pump_on"] == 0.0,
    "standing": _is_standing,
    "untouched": lambda columns, bounds: columns["truth.contact_n"] <= bounds.contact_n,
    "resting": lambda columns, _: np.isin(columns["phase"], RESTING),
    "not-inserted": _is_not_inserted,
}
"""Predicates by name."""


def holds(columns: Columns, names: Sequence[str], bounds: SafeBounds) -> Holds:
    """True where all of the named predicates hold, one entry a tick.

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
