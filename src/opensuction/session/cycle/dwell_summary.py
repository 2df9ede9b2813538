"""Summary of the dwell, for the JSON of a cycle: its duration and the cause of its end."""

import numpy as np

from opensuction.kernel.phase import Phase
from opensuction.procedure.cycle.transition import Event
from opensuction.result.plain import Json
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns

ENDINGS = {
    Event.DWELL_ELAPSED: "dwell-elapsed",
    Event.NOTHING_CAME: "nothing-came",
}
"""What ends a dwell that is not broken off."""


def plain(prepared: Prepared, columns: Columns) -> Json:
    """How long it lasted, what ended it, and how long nothing may come; None for what was not.

    The dwell begins when the valve is asked to open, with the tip where it stopped.
    """
    return measure(columns, prepared.loop.controller.plan.pace.nothing_comes_s, DT_S)


def measure(columns: Columns, wait_s: float, dt_s: float) -> Json:
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
    return {
        "dwell_s": ticks * dt_s if ticks else None,
        "dwell_ended_by": ended,
        "nothing_comes_s": wait_s if wait_s > 0.0 else None,
    }
