"""One tick of what the governor makes of readings."""

from opensuction.kernel.interface import Readings
from opensuction.safety.limits import Limits
from opensuction.safety.watch import watch
from opensuction.safety.watch.watch_state import Watch
from tests.safety.watchdog import DT_S, LIMITS, believed, changed, staying
from tests.settled import settled

HEAD_MM = 50.0


def seen(head_mm: float = HEAD_MM, **values: object) -> Watch:
    """What is known of a head that has been at rest; values: otherwise."""
    known: Watch = changed(
        watch.start(LIMITS, head_mm, read=True), {"advance.coast_mm_per_s": 0.0, **values}
    )
    return known


step = settled(watch.step)


def observed(
    before: Watch,
    readings: Readings,
    valve_command_changed: bool = False,
    overrun: bool = False,
    limits: Limits = LIMITS,
    **last: object,
) -> Watch:
    told = changed(staying(before.head_mm), last)
    vote = believed(limits, before, readings)
    return step(limits, before, told, valve_command_changed, readings, vote, overrun, DT_S)
