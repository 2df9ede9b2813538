"""Decision that a process of the machine is lost, from its signs of life; no clock.

A process that is being started is waited for, as long as the ring still keeps all that has happened
meanwhile. One that has worked is lost when it falls silent or when another one takes its place.
"""

from opensuction.ipc.heartbeat import Process, Signs
from opensuction.runtime.paths import SLOTS_S
from opensuction.safety.condition import Condition
from opensuction.safety.handling import UNANSWERED_S

MISSED_S = 0.5
"""Without a sign of life for longer than this a process is lost."""
LOST_S = 3.0
"""Lost it counts for at least so long: of every loss somebody is told, for something may not have
been kept, however soon it is there again."""
TOLD_BEFORE_S = 1.0
"""So long before the first row is gone people are told that nobody has kept it yet."""
STARTS_S = SLOTS_S - UNANSWERED_S - TOLD_BEFORE_S
"""For so long a start may take before the process is lost: a recorder that comes later finds rows
gone from the ring, and the alarm has a delay of its own (`UNANSWERED_S`)."""
WATCHED = {
    Process.SUPERVISOR: 1 << Condition.RECORDER_LOST,
    Process.RECORDER: 1 << Condition.RECORDER_LOST,
    Process.KEEPING: 1 << Condition.RECORDER_LOST,
    Process.CONSOLE: 1 << Condition.CONSOLE_LOST,
}
"""Condition of each process that the controller misses, as a mask."""


def is_lost(signs: Signs, known_deaths: int, running_s: float) -> bool:
    """Decide whether a process is lost now.

    known_deaths: how many deaths of it the controller has taken note of.
    running_s: how long the controller has run, by its ticks; before them there are no rows to lose.
    """
    if signs.deaths != known_deaths:
        return True
    if signs.starting_s is not None:
        return min(signs.starting_s, running_s) > STARTS_S
    return signs.is_expected and signs.age_s > MISSED_S
