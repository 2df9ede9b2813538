"""A judge of a machine that runs: by the twin's truth alone, whatever becomes of its controllers.

It reads a truth port, and is to look more often than that overwrites: a twin's holds 20 s. It
knows nothing of a controller, a recorder or a supervisor: of what people were told it takes what
the annunciator at the bedside has shown.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.machine.port import TruthPort
from opensuction.oracle import exposure
from opensuction.oracle.harm import Harm, Judged, LongRun, worst
from opensuction.safety.condition import Condition
from opensuction.simulation import outcome
from opensuction.simulation.outcome import Annunciation

_TICK = "tick"
_NAMES = (*(name for name in exposure.COLUMNS if name != "time_s"), *outcome.COLUMNS)


class Verdict(NamedTuple):
    """Verdict on a run so far. Times are those of the twin, from its own begin."""

    harm: tuple[Harm, ...]
    """Every bound that was broken in any of the runs, with the worst that it came to."""
    inside_at_end: bool
    """The tip, or a piece of the catheter, is in the airway now."""
    end_mm: float
    """Where the tip is now."""
    last_inside_s: float
    """When the tip was last in the airway; nan for never."""
    now_s: float
    """The last tick that was seen."""
    told: tuple[Annunciation, ...]
    """What people were told, when, and by whom: what was not shown before."""
    showing: tuple[Condition, ...]
    """What they are told now, since whenever."""
    runs: tuple[Judged, ...]
    """From one rest to the next; see `long_run`."""
    missed_ticks: int
    """Ticks that the twin played and nobody saw: what was so in them is not judged."""

    def told_since(self, from_s: float) -> tuple[Annunciation, ...]:
        """Annunciations from an instant on."""
        return tuple(one for one in self.told if one.at_s >= from_s)


class LiveJudge:
    """Follows a machine from its first tick that is still to be seen."""

    def __init__(self, truth: TruthPort, cap_mm: float) -> None:
        """truth: as `backend.open_truth` gives it. cap_mm: deepest tip position that is planned.

        Raises InputError where it tells too little to judge by.
        """
        if lacking := [name for name in (_TICK, *_NAMES) if name not in truth.columns]:
            raise InputError(f"the machine's truth lacks {', '.join(lacking)}: it cannot be judged")
        self._truth = truth
        self._tick = truth.columns.index(_TICK)
        self._places = [truth.columns.index(name) for name in _NAMES]
        self._run = LongRun(truth.built, cap_mm)
        self._told: list[Annunciation] = []
        self._shown: dict[str, Array] = {}
        """What the annunciator showed in the last tick that was seen."""
        self._end_mm, self._piece_mm = math.nan, 0.0
        self.now_s = math.nan
        """The last tick that was seen."""
        self.missed_ticks = 0

    def look(self) -> int:
        """Take what has come since the last call; how many ticks."""
        found = self._truth.read()
        self.missed_ticks += found.missed
        if not len(found.rows):
            return 0
        seen = dict(zip(_NAMES, np.ascontiguousarray(found.rows[:, self._places].T), strict=True))
        seen["time_s"] = found.rows[:, self._tick] * self._truth.period_s
        self._run.add(seen)
        self._hear(seen)
        self.now_s = float(seen["time_s"][-1])
        self._end_mm = float(seen["truth.tip_mm"][-1])
        self._piece_mm = float(seen["truth.piece_mm"][-1])
        return len(found.rows)

    def begin(self) -> None:
        """Judge apart all that comes from now on: a person has the patient recovered.

        A rest does so by itself; see `long_run`.
        """
        self.look()
        self._run.begin()

    def verdict(self) -> Verdict:
        """Verdict on the run by now.

        Raises InputError where nothing was seen, ValueError for a truth that is no number.
        """
        self.look()
        runs, last_s = self._run.runs, self._run.last_inside_s
        if math.isnan(self.now_s):
            raise InputError("the twin has not played a tick: there is nothing to judge")
        return Verdict(
            harm=worst(runs),
            inside_at_end=last_s == self.now_s or self._piece_mm > 0.0,
            end_mm=self._end_mm,
            last_inside_s=last_s if math.isfinite(last_s) else math.nan,
            now_s=self.now_s,
            told=tuple(self._told),
            showing=outcome.showing(self._shown),
            runs=runs,
            missed_ticks=self.missed_ticks,
        )

    def _hear(self, seen: dict[str, Array]) -> None:
        """Add the annunciations since the last look."""
        columns = {name: seen[name] for name in ("time_s", *outcome.COLUMNS)}
        joined = columns
        if self._shown:
            joined = {name: np.concatenate((self._shown[name], columns[name])) for name in columns}
        told = outcome.told(joined)
        known = bool(self._shown)
        self._told += [one for one in told if not known or one.at_s > self.now_s]
        self._shown = {name: column[-1:].copy() for name, column in columns.items()}
