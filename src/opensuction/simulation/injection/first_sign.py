"""The first sign of a fault in a trace: what noticed it, and when."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from opensuction.kernel.name import name_of
from opensuction.kernel.phase import Phase
from opensuction.procedure.cycle.check_item import CheckItem
from opensuction.procedure.cycle.refusal import Refusal
from opensuction.procedure.cycle.transition import Event
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.simulation.annunciation import LINES
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns

SIGNS = ("time_s", "phase", "cause", "check_failed", "verdict.trips", *LINES)
"""Columns in which the first sign of a fault is looked for."""


class Detector(IntEnum):
    """Means by which a fault is noticed first."""

    TRIP = 0
    """A limit of the governor; ``code`` is a `Condition`."""
    CHECK = 1
    """The pre-use test; ``code`` is a `CheckItem`."""
    ABORT = 2
    """The procedure broke off; ``code`` is an `Event`."""
    REFUSAL = 3
    """The start was refused; ``code`` is a `Refusal`."""
    DRIVE = 4
    """The drives, their watchdog or the power supply, without the controller; ``code`` is the
    `Condition` that the annunciator then shows."""


class FirstSign(NamedTuple):
    """The first sign of a fault."""

    detector: Detector
    code: int
    time_s: float

    @property
    def title(self) -> str:
        """Name of what noticed it, as JSON writes it."""
        names: dict[Detector, type[IntEnum]] = {
            Detector.TRIP: Condition,
            Detector.CHECK: CheckItem,
            Detector.ABORT: Event,
            Detector.REFUSAL: Refusal,
            Detector.DRIVE: Condition,
        }
        if self.detector == Detector.DRIVE and self.code == Condition.WATCHDOG_FIRED:
            return "drive-watchdog"
        return name_of(names[self.detector](self.code))


def _find_trip(columns: Columns, first: int) -> FirstSign | None:
    masks = columns["verdict.trips"].astype(np.int64)
    known = int(masks[first - 1]) if first > 0 else 0
    new = np.flatnonzero(masks[first:] & ~known)
    if not new.size:
        return None
    tick = first + int(new[0])
    code = condition_mask.decode_trips(int(masks[tick]) & ~known)[0]
    return FirstSign(Detector.TRIP, code, float(columns["time_s"][tick]))


def _find_failed_check(columns: Columns, first: int) -> FirstSign | None:
    failed = np.flatnonzero(columns["check_failed"][first:])
    if not failed.size or (first > 0 and columns["check_failed"][first - 1] != 0.0):
        return None
    tick = first + int(failed[0])
    code = int(columns["check_failed"][tick])
    return FirstSign(Detector.CHECK, code, float(columns["time_s"][tick]))


def _find_abort(columns: Columns, first: int) -> FirstSign | None:
    broken = np.isin(columns["phase"], (Phase.ABORTING, Phase.HALTED))
    began = np.flatnonzero(broken[first:])
    if not began.size or (first > 0 and broken[first - 1]):
        return None
    tick = first + int(began[0])
    return FirstSign(Detector.ABORT, int(columns["cause"][tick]), float(columns["time_s"][tick]))


def find_lines(columns: Columns, first: int) -> list[FirstSign]:
    """First signs on the annunciator's own lines, shown from a tick on and not before."""
    found = []
    for name, line in LINES.items():
        shown = np.flatnonzero(columns[name][first:])
        if shown.size and not (first > 0 and columns[name][first - 1]):
            time_s = float(columns["time_s"][first + int(shown[0])])
            found.append(FirstSign(Detector.DRIVE, line.condition, time_s))
    return found


def find_notice(columns: Columns, from_s: float) -> FirstSign | None:
    """The first sign of trouble from an instant on that was not there before; None for none.

    A trip, an item of the pre-use test or another event that broke the cycle off, whichever comes
    first; of those of one tick the first named says most.
    """
    first = round(from_s / DT_S)
    signs = [find(columns, first) for find in (_find_trip, _find_failed_check, _find_abort)]
    found = [sign for sign in signs if sign is not None]
    return min(found, key=lambda sign: sign.time_s, default=None)
