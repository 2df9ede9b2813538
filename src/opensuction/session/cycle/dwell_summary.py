"""Summary of the dwell of a cycle: its duration and the cause of its end."""

from typing import NamedTuple

import numpy as np

from opensuction.kernel.phase import Phase
from opensuction.procedure.cycle.transition import Event
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns

ENDINGS = {
    Event.DWELL_ELAPSED: "dwell-elapsed",
    Event.NOTHING_CAME: "nothing-came",
}
"""What ends a dwell that is not broken off."""


class Dwell(NamedTuple):
    """Duration of the dwell, the cause of its end, and how long nothing may come; None: was not."""

    dwell_s: float | None
    dwell_ended_by: str | None
    nothing_comes_s: float | None


def of_cycle(prepared: Prepared, columns: Columns) -> Dwell:
    """The dwell of a simulated cycle.

    The dwell begins when the valve is asked to open, with the tip where it stopped.
    """
    return measure(columns, prepared.loop.controller.plan.pace.nothing_comes_s, DT_S)


def measure(columns: Columns, wait_s: float, dt_s: float) -> Dwell:
    """The same of a run that need not have been simulated.

    wait_s: how long nothing may come; 0 where nobody asks. dt_s: length of a tick.
    """
    phase = columns["phase"]
    there = np.isin(phase, (Phase.OPENING, Phase.SUCTIONING))
    ticks = np.count_nonzero(there & (columns["demand.valve_open"] > 0.0))
    leaving = phase == Phase.WITHDRAWING
    ended = None
    if np.any(leaving):
        ended = ENDINGS.get(Event(int(columns["cause"][int(np.argmax(leaving))])))
    return Dwell(
        dwell_s=ticks * dt_s if ticks else None,
        dwell_ended_by=ended,
        nothing_comes_s=wait_s if wait_s > 0.0 else None,
    )
