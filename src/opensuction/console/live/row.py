"""A row of the control loop, read by the names of its columns.

Remaining time of the present phase, where it can be predicted.
"""

import math

from opensuction.controller.record import Settings
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.plan import TUBE_END_MM, Motion
from opensuction.runtime.loop import ROW_COLUMNS

PLACES = {name: place for place, name in enumerate(ROW_COLUMNS)}


class Row:
    """One tick."""

    def __init__(self, values: Array) -> None:
        """values: by `ROW_COLUMNS`."""
        self._values = values

    def number(self, name: str) -> float:
        """A column as it is; may be no number."""
        return float(self._values[PLACES[name]])

    def whole(self, name: str) -> int:
        """A column that holds a whole number; 0 where it holds none."""
        value = self.number(name)
        return int(value) if math.isfinite(value) else 0

    def flag(self, name: str) -> bool:
        """A column that holds yes or no."""
        return self.number(name) == 1.0

    def reading(self, name: str) -> float | None:
        """A number that a page can show; None for one that is none."""
        return plain(self.number(name))

    def valid(self, name: str, flag: str) -> float | None:
        """A reading with its flag; None where the flag says that it is none."""
        return self.reading(name) if self.flag(flag) else None


def plain(value: float, digits: int = 4) -> float | None:
    """A number as JSON has it; None for one that is none."""
    return round(value, digits) if math.isfinite(value) else None


LEAST_MM_PER_S = 0.1
_PROCEDURE = "state.core.procedure"


def left_s(settings: Settings, row: Row) -> float | None:
    """Seconds until the phase ends as planned; None where a person or the patient decides it.

    A phase that lasts longer than it was planned to has 0 left.
    """
    phase = row.whole("outputs.phase")
    dt_s = row.number("inputs.dt_s")
    begun_s = row.number(f"{_PROCEDURE}.phase_ticks") * dt_s
    plan = settings.plan
    found: float | None = None
    if phase == Phase.PRELOADING:
        found = plan.preload_s - begun_s
    elif phase == Phase.INSERTING and not plan.contact.enabled:
        found = _way_in_s(plan.motion, row.number(f"{_PROCEDURE}.reference_mm"))
    elif phase == Phase.OPENING:
        # How long the vacuum takes to build nobody knows; the phase's limit grows by that.
        building_s = row.number(f"{_PROCEDURE}.limit_s") - plan.limits_s[Phase.OPENING]
        found = settings.limits.valve.stroke_s + max(building_s, 0.0) - begun_s
    elif phase == Phase.SUCTIONING:
        found = _dwell_s(settings, row, dt_s)
    elif phase == Phase.WITHDRAWING:
        found = _way_out_s(plan.motion, row)
    elif phase == Phase.CLOSING:
        found = settings.limits.valve.stroke_s - begun_s
    elif phase == Phase.IDENTIFYING:
        found = plan.excitation.duration_s - begun_s
    return None if found is None else max(found, 0.0)


def _way_in_s(motion: Motion, reference_mm: float) -> float:
    """At the planned speeds, fast within the tube; its gentle ends add a little."""
    in_tube_mm = max(TUBE_END_MM - reference_mm, 0.0)
    beyond_mm = max(motion.target_mm - max(reference_mm, TUBE_END_MM), 0.0)
    return in_tube_mm / motion.tube_mm_per_s + beyond_mm / motion.insertion_mm_per_s


def _way_out_s(motion: Motion, row: Row) -> float:
    """At the present speed; where mucus comes it is slow only while there is time to spare."""
    left_mm = max(row.number(f"{_PROCEDURE}.reference_mm") - motion.park_mm, 0.0)
    speed = motion.withdrawal_mm_per_s * row.number(f"{_PROCEDURE}.pace.ratio")
    # Each second that is lost to slowness is taken from those (`procedure.suction.line_flow`).
    planned_s = left_mm / motion.withdrawal_mm_per_s
    most_s = planned_s + row.number(f"{_PROCEDURE}.pace.spare_s")
    return min(left_mm / max(speed, LEAST_MM_PER_S), most_s)


def _dwell_s(settings: Settings, row: Row, dt_s: float) -> float:
    """Of the planned dwell; less where nothing has come for a while."""
    plan = settings.plan
    planned_s = plan.dwell_s - row.number(f"{_PROCEDURE}.arrived_ticks") * dt_s
    quiet_ticks = row.whole(f"{_PROCEDURE}.pace.quiet_ticks")
    if quiet_ticks == 0:
        return planned_s
    return min(planned_s, plan.pace.nothing_comes_s - quiet_ticks * dt_s)
