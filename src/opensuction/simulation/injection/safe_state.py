"""What a safe state is put together from: predicates on a trace, by name.

Each is true or false in every tick. They are judged on the truth of the twin and on the commands
that the drives obeyed, not on what the controller has read.
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
    """Limits of the predicates; none has a default."""

    boundary_mm: float
    """Tip here or above is outside the patient."""
    vented_mmhg: float
    """Vacuum up to this is none."""
    vacuum_mmhg: float
    """Highest vacuum allowed."""
    contact_n: float
    """Force up to this is no contact."""


def _is_tip_outside(columns: Columns, bounds: SafeBounds) -> Holds:
    """The tip is outside the patient."""
    return columns["truth.tip_mm"] <= bounds.boundary_mm


def _is_valve_closed(columns: Columns, _bounds: SafeBounds) -> Holds:
    """The suction valve is closed."""
    return np.equal(columns["truth.valve_open_ratio"], 0.0)


def _is_without_suction(columns: Columns, bounds: SafeBounds) -> Holds:
    """No vacuum reaches the tip."""
    return columns["truth.tip_vacuum_mmhg"] <= bounds.vented_mmhg


def _is_vented(columns: Columns, bounds: SafeBounds) -> Holds:
    """The line is vented."""
    return columns["truth.line_vacuum_mmhg"] <= bounds.vented_mmhg


def _is_vacuum_limited(columns: Columns, bounds: SafeBounds) -> Holds:
    """The line's vacuum is within its limit."""
    return columns["truth.line_vacuum_mmhg"] <= bounds.vacuum_mmhg


def _is_torque_off(columns: Columns, _bounds: SafeBounds) -> Holds:
    """The insertion drive has no torque."""
    return np.equal(columns["commands.insertion_on"], 0.0)


def _is_pump_off(columns: Columns, _bounds: SafeBounds) -> Holds:
    """The pump is commanded off."""
    return np.equal(columns["commands.pump_on"], 0.0)


def _is_standing(columns: Columns, _bounds: SafeBounds) -> Holds:
    """The catheter head stands still."""
    ticks = round(STANDING_S / DT_S)
    head = columns["truth.head_mm"]
    before = np.concatenate((np.full(min(ticks, head.size), head[0]), head[:-ticks]))
    return np.asarray(np.abs(head - before) <= STANDING_MM_PER_S * STANDING_S)


def _is_untouched(columns: Columns, bounds: SafeBounds) -> Holds:
    """The tip touches nothing."""
    return columns["truth.contact_n"] <= bounds.contact_n


def _is_resting(columns: Columns, _bounds: SafeBounds) -> Holds:
    """The controller waits for a person."""
    return np.isin(columns["phase"], (Phase.PARKED, Phase.HALTED, Phase.OUT_OF_SERVICE))


def _is_not_started(columns: Columns, _bounds: SafeBounds) -> Holds:
    """At every tick whether insertion has not begun yet."""
    begun = np.isin(columns["phase"], (Phase.PRELOADING, Phase.INSERTING))
    return ~np.logical_or.accumulate(begun)


PREDICATES: dict[str, Callable[[Columns, SafeBounds], Holds]] = {
    "tip-outside": _is_tip_outside,
    "valve-closed": _is_valve_closed,
    "no-suction": _is_without_suction,
    "vented": _is_vented,
    "vacuum-limited": _is_vacuum_limited,
    "torque-off": _is_torque_off,
    "pump-off": _is_pump_off,
    "standing": _is_standing,
    "untouched": _is_untouched,
    "resting": _is_resting,
    "not-started": _is_not_started,
}
"""Predicates by name."""


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
