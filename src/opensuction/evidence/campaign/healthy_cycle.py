"""The same cycle without a fault: when its phases come, and what its machine does when.

From it follow a fault's instants, and for how long a fault had a chance to show.
"""

import math
from enum import Enum
from typing import NamedTuple

import numpy as np

from opensuction.kernel.phase import Phase
from opensuction.oracle import exposure
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.safe_state import Holds
from opensuction.simulation.trace import Columns
from opensuction.twin.machine.machine import Machine

AIRWAY = "airway"
"""The time for which the tip is in the airway, and `BEFORE_S` more."""
BEFORE_S = 1.0
"""A fault this long before the tip comes in still meets it."""
MOVING_MM_PER_S = 0.5
"""[assumed] A slower head shows nothing that a sensor could tell from rest."""
SMOOTHED_S = 0.02
OPEN_RATIO = 0.95
"""[assumed] A valve this far open draws as one that is open."""
INSERTING = Phase.INSERTING.name.lower()
COLUMNS = (
    "time_s",
    "phase",
    "truth.tip_mm",
    "truth.head_mm",
    "truth.valve_open_ratio",
    "truth.contact_n",
)
"""What is looked at."""


class Shows(Enum):
    """While what a machine does a fault can show: its clock stands still in other ticks.

    Reckoned on the same cycle without the fault, so that nothing which the fault does delays it.
    """

    ALWAYS = "always"
    MOVING = "moving"
    """While the head moves: a head at rest can neither stall nor go astray."""
    OPEN = "open"
    """While the suction valve stands open: the line tells nothing before its stroke is done."""


class HealthyCycle(NamedTuple):
    """A cycle in which nothing is wrong."""

    spans: dict[str, tuple[float, float]]
    """Begin and end of each phase by name, and of the time in the airway where there is any."""
    moving: Holds
    """In which ticks the head moves."""
    open: Holds
    """In which ticks the valve stands open, for suction."""


def of(machine: Machine, columns: Columns) -> HealthyCycle:
    """Data of a cycle that was played; columns: at least `COLUMNS`."""
    spans = {
        span.phase.name.lower(): (span.start_s, span.end_s) for span in trace.phase_spans(columns)
    }
    inside = np.flatnonzero(exposure.find_inside(machine, columns["truth.tip_mm"]))
    touched = np.flatnonzero(columns["truth.contact_n"] > exposure.TOUCHING_N)
    if touched.size and INSERTING in spans:  # what comes after the touch meets no insertion
        spans[INSERTING] = (spans[INSERTING][0], float(touched[0]) * DT_S)
    if inside.size:
        spans[AIRWAY] = (inside[0] * DT_S - BEFORE_S, inside[-1] * DT_S)
    testing = columns["phase"] == Phase.CHECKING
    ticks = round(SMOOTHED_S / DT_S)
    head = columns["truth.head_mm"]
    travel = np.abs(head - np.concatenate((np.full(ticks, head[0]), head[:-ticks])))
    return HealthyCycle(
        spans=spans,
        moving=travel > MOVING_MM_PER_S * SMOOTHED_S,
        open=(columns["truth.valve_open_ratio"] >= OPEN_RATIO) & ~testing,
    )


def find_wait_s(cycle: HealthyCycle, shows: Shows, at_s: float, needed_s: float) -> float:
    """For how long a fault at an instant cannot have shown, on top of the time that it needs.

    needed_s: how long what it shows in must last. After the cycle there is nothing to wait for.
    """
    if shows == Shows.ALWAYS:
        return 0.0
    shown = cycle.moving if shows == Shows.MOVING else cycle.open
    later = shown[round(at_s / DT_S) :]
    needed = max(math.ceil(needed_s / DT_S), 1)
    counted = np.cumsum(later)
    if not counted.size or counted[-1] < needed:
        shown_s = 0.0 if not counted.size else float(counted[-1]) * DT_S
        return later.size * DT_S - shown_s
    return float(np.searchsorted(counted, needed) + 1) * DT_S - needed * DT_S
