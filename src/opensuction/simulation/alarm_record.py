"""The alarm log of a recorded run, from the signals in its trace."""

from typing import get_type_hints

import numpy as np

from opensuction.safety.alarm import alarm_log
from opensuction.safety.alarm.alarm_log import Log
from opensuction.safety.alarm.alarm_state import Signals
from opensuction.simulation.trace import Columns

CAPACITY = 10_000
"""Entries that are kept of one run; a day of cycles has some dozens."""
CHANGING = ("present", "latched", "acknowledged", "escalated")
"""Signals whose change is an entry in the log; the audio pause is the fifth."""


def _signals(trace: Columns, row: int) -> Signals:
    at = (trace[f"signals.{name}"][row] for name in Signals._fields)
    kinds = get_type_hints(Signals).values()
    return Signals(*(kind(value) for kind, value in zip(kinds, at, strict=True)))


def log(trace: Columns) -> Log:
    """The log of a run; what is signalled in its first tick counts as raised then."""
    time_s = trace["time_s"]
    noted = alarm_log.start(CAPACITY, float(time_s[0]) if time_s.size else 0.0)
    if time_s.size == 0:
        return noted
    changes = np.zeros(time_s.size, dtype=np.bool_)
    paused = (trace["signals.pause_left_s"] > 0.0).astype(np.float64)
    for values in (*(trace[f"signals.{name}"] for name in CHANGING), paused):
        changes |= np.diff(values, prepend=0.0) != 0.0
    for row in np.flatnonzero(changes):
        noted = alarm_log.note(noted, float(time_s[row]), _signals(trace, int(row)))
    return noted
