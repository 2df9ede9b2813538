"""Non-volatile memory of a machine: limits that a loss of power must not reset.

What one controller leaves to the next (`controller_memory`) lies in the computer's memory. The
recorder keeps a copy on the disk: as a cycle begins and ends, whenever a pass or a person changes
it, and every minute. Where the computer was switched off, the next controller goes on from there.

For how long it was off only the wall clock tells, which may be wrong. So of a rest no more counts
as over than the time since the computer was switched on, and a catheter whose age cannot be told,
as the clock stands before the copy, is taken for one that was used too long.
"""

import json
import math
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from opensuction.host.host import NS_PER_S, Clock, Host, Steps, Work, after
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.compiled import as_python
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import RESTING, Phase, name_of
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.interlocks import Interlocks
from opensuction.procedure.cycle.schedule import PassRule
from opensuction.runtime.controller_memory import Before
from opensuction.runtime.loop import ROW_COLUMNS

WRITES_S: Final = 60.0
"""How often it is written where nothing but time changes it."""
_UPKEEP: Final = "state.core.upkeep."
_PLACES: Final = [i for i, name in enumerate(ROW_COLUMNS) if name.startswith(_UPKEEP)]
_TIME: Final = ROW_COLUMNS.index("loop.time_s")
_PHASE: Final = ROW_COLUMNS.index("state.core.procedure.phase")
_AGE: Final = ROW_COLUMNS.index(f"{_UPKEEP}catheter_age_s")
_WATCHED: Final = [
    i
    for i, name in enumerate(ROW_COLUMNS)
    if name in (f"{_UPKEEP}episode.passes", f"{_UPKEEP}episode.exceeded")
    or name.startswith(f"{_UPKEEP}lock.")
]
_RESTING: Final = tuple(map(int, RESTING))
_BEFORE_A_PASS: Final = (Phase.CHECKING, Phase.PRELOADING)
_STEP_EPISODE: Final = as_python(schedule.step_episode)


AGAIN_S: Final = 1.0
"""How long the work waits where the disk has refused it."""
LOOKS_S: Final = 0.01


class _Known(NamedTuple):
    """State of a controller, as far as it makes the copy another one."""

    watched: tuple[float, ...]
    is_resting: bool
    age_s: float
    """Of the catheter, as of then."""
    at_s: float


class NonvolatileMemory:
    """The copy, for whoever keeps it; written beside its steps, for a disk may be slow."""

    def __init__(self, path: Path | None, host: Host) -> None:
        """path: of its file; None: nothing is kept."""
        self._path, self._files, self._clock = path, host.files, host.clock
        self._known: _Known | None = None
        self._due: str | None = None
        """Content that is to be written; None where the disk has the newest, or it is under way."""
        self._is_writing = False
        self.lost = ""
        """Reason why it is not kept; empty where it is."""
        self._worker = None if path is None else host.begin_worker(self._work(path))

    def take(self, row: Array, rule: PassRule) -> None:
        """Keep what a controller knows as of a row, where it has changed.

        row: by `loop.ROW_COLUMNS`. rule: for passes, that the controller goes by. A pass that a
        cycle is about to make counts as made.
        """
        if self._worker is None:
            return
        phase, now_s = int(row[_PHASE]), self._clock.monotonic_ns() / NS_PER_S
        # A row may be of a controller that died some time ago.
        age_s = float(row[_AGE]) + max(now_s - float(row[_TIME]), 0.0)
        found = _Known(tuple(row[_WATCHED].tolist()), phase in _RESTING, age_s, now_s)
        if self._known is not None and _is_same(self._known, found):
            return
        kept = plain_row.unpack(Interlocks, np.ascontiguousarray(row[_PLACES]))
        if phase in _BEFORE_A_PASS:
            begun = _STEP_EPISODE(rule, kept.episode, phase, Phase.INSERTING, 0.0)
            kept = kept._replace(episode=begun)
        kept = kept._replace(catheter_age_s=age_s)
        self._known, self._due = found, _compose(kept, phase, self._clock)
        self._worker.wake()

    def close(self, patience_s: float) -> Steps[bool]:
        """Wait until all is written; true where it is within this time."""
        ends_ns = after(self._clock, patience_s)
        while self._due is not None or self._is_writing:
            if self._clock.monotonic_ns() >= ends_ns:
                return False
            yield after(self._clock, LOOKS_S)
        return True

    def _work(self, path: Path) -> Work:
        """Write what is due, and the newest only."""
        while True:
            content, self._is_writing = self._due, True
            if content is None:
                self._is_writing = False
                yield None
                continue
            try:
                self._files.write(path, content)
            except OSError as error:
                self.lost = f"{path} cannot be written: {error.strerror or error}"
                self._is_writing = False
                yield after(self._clock, AGAIN_S)
                continue
            self.lost = ""
            if self._due is content:
                self._due = None
            self._is_writing = False


def _is_same(known: _Known, found: _Known) -> bool:
    """True where nothing has changed but by time, and that not for long."""
    is_other = found.watched != known.watched or found.is_resting != known.is_resting
    return not is_other and found.age_s >= known.age_s and found.at_s < known.at_s + WRITES_S


def _compose(kept: Interlocks, phase: int, clock: Clock) -> str:
    """Content of the file."""
    told = {
        "kept": plain_row.write(Interlocks, kept),
        "phase": phase,
        "wall_ns": clock.wall_ns(),
    }
    return json.dumps(told, indent=1)


def recall(path: Path, now_ns: int, on_s: float) -> Before | None:
    """State left behind by the last controller before a loss of power; None where none was kept.

    now_ns: by the wall clock. on_s: time for which the computer has been on.

    Raises InputError for what cannot be read: nobody knows then what must not be forgotten.
    """
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        kept = plain_row.read(Interlocks, told["kept"], "kept")
        phase, wall_ns = Phase(told["phase"]), int(told["wall_ns"])
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, InputError) as error:
        raise InputError(
            f"{path} cannot be read ({error}), and with it passes, rest and the catheter's age: "
            "look at the patient, put in a new catheter, and begin with --anew"
        ) from None
    off_s = (now_ns - wall_ns) / NS_PER_S
    rested_s = max(min(off_s, on_s), 0.0)
    aged_s = off_s if off_s >= 0.0 else math.nan
    kept = kept._replace(catheter_age_s=kept.catheter_age_s + aged_s - rested_s)
    return Before(kept, rested_s, died=True, phase=int(phase))


def forget(path: Path) -> None:
    """Another patient, or a person who begins anew. Raises InputError where it stays."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{path} cannot be removed: {error.strerror}") from None


def describe(before: Before) -> str:
    """Account of what was read from the disk, for a person."""
    episode = before.kept.episode
    rest_s = schedule.pass_idle_time_episode(episode, before.off_s).rest_left_s
    age_h = (before.kept.catheter_age_s + before.off_s) / 3600.0
    age = f"a catheter {age_h:.1f} h old" if math.isfinite(age_h) else "a catheter of unknown age"
    broken_off = (
        ""
        if before.phase in _RESTING
        else f", a cycle broken off in {name_of(Phase(before.phase))}"
    )
    return (
        f"Known from before the computer was off: passes since somebody looked: {episode.passes}; "
        f"{math.ceil(rest_s)} s of rest left; {age}{broken_off}"
    )
