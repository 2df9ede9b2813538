"""A machine that was lost: what is known of it, and what the next one under its name must keep.

The twin is its patient, too. Where it died nobody could bring the catheter out, and another one
that begins in its place has its rest, so that nobody suctions sooner by starting anew.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.controller import configuration
from opensuction.ipc.process_lock import holder
from opensuction.ipc.ring import RingReader
from opensuction.kernel.compiled import as_python
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import RESTING, Phase
from opensuction.machine.twin.twin_process import PLAYS
from opensuction.procedure.cycle import episode
from opensuction.procedure.cycle.interlocks import NEW_CATHETER_S
from opensuction.runtime import control_process, paths
from opensuction.runtime.control_process import Before
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.safety import tip_bound
from opensuction.safety.tip_bound import TipInterval

VALID = [
    place
    for place, name in enumerate(ROW_COLUMNS)
    if name.startswith("inputs.readings.") and name.endswith("_valid")
]
"""Columns of a row that say whether there was a reading."""
DEEPEST_MM = as_python(tip_bound.deepest_mm)
TIP = [ROW_COLUMNS.index(f"state.core.governor.watch.tip.{name}") for name in TipInterval._fields]
INSIDE = (
    "the machine did not answer any more, and the catheter's tip was last inside: look at the "
    "patient and draw the catheter out by the handle"
)
OUTSIDE = "the machine did not answer any more; the catheter's tip was last outside"


class Predecessor(NamedTuple):
    """A machine that does not answer any more."""

    before: Before
    """What its controller left."""
    was_inside: bool
    """The tip may have been in the airway when it was seen last."""

    @property
    def rest_left_s(self) -> float:
        """Time for which the patient still has to rest, in s."""
        return episode.pass_idle_time(self.before.kept.episode, self.before.off_s).rest_left_s

    @property
    def ending(self) -> str:
        """Ending of the earlier run, for a person."""
        return INSIDE if self.was_inside else OUTSIDE

    @property
    def succession(self) -> str:
        """Notice of the twin that has replaced it, for a person."""
        place = "inside: look at the patient" if self.was_inside else "outside"
        return (
            "Another twin has begun, and another patient with it: that of the earlier run is gone, "
            f"the catheter's tip was last {place}; {math.ceil(self.rest_left_s)} s of rest are kept"
        )


def find(folder: Path) -> Predecessor | None:
    """The machine of a folder that was lost; None where one answers, or none was."""
    before = control_process.read_before(folder)
    if before is None:
        return None
    try:
        row = RingReader(folder / paths.RING).drain().rows[-1]
    except (InputError, OSError):  # only what was handed on is left of it
        return Predecessor(before, before.phase not in RESTING)
    if holder(folder / PLAYS) is not None and row[VALID].any():
        return None
    return Predecessor(before, _was_inside(folder, row))


def _was_inside(folder: Path, row: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> bool:
    """True if the tip may have been in the airway, or its place is not known."""
    try:
        text = (folder / paths.CONFIGURATION).read_text(encoding="utf-8")
        limits = configuration.from_json(text).settings.limits
    except (InputError, OSError, UnicodeDecodeError):
        return True
    tip = TipInterval(*(float(row[place]) for place in TIP))
    return not DEEPEST_MM(limits.tip, tip) <= limits.outside_mm


def hand_on(folder: Path, lost: Predecessor) -> None:
    """Have the next controller in a folder keep what the lost one knew of its patient.

    Where the tip was inside it halts, says so, and waits for a person. The catheter is another one.
    """
    kept = lost.before.kept._replace(catheter_age_s=NEW_CATHETER_S)
    phase = Phase.ABORTING if lost.was_inside else Phase.PARKED
    control_process.hand_on(folder, lost.before._replace(kept=kept, phase=phase))
