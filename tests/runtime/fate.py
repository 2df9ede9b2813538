"""Fate of a machine whose processes died: by the twin's rows, the records and the recordings."""

import itertools
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.recording.cycle_file.reader import NothingRecordedError, RecordingReader
from opensuction.records.entry import Outcome
from opensuction.records.history import PastCycle
from opensuction.records.records import Records
from opensuction.runtime import replay
from opensuction.safety.condition import Condition
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from tests.runtime.identity import ABOUT

TOLD_WITHIN_S = 5.0


class Fate(NamedTuple):
    """What came of one death."""

    victim: str
    at_s: float
    """After the start's button."""
    phase: str
    depth_mm: float
    """Of the tip below the tube's end when it died."""
    out_s: float
    """From then until the tip was out for good."""
    told_s: float
    """From then until the bedside told somebody."""
    alone_s: float
    """From then until the drives acted on their own; -1: they did not."""
    lit: bool
    """The lamp was lit by what the cycle had come to before; it has stayed lit then."""
    outcome: str
    detail: str
    recordings: int
    hung: str | None
    """What hung besides from the death on."""
    replaced_s: float
    """From then, or from the next supervisor's first sign, until another one was in its place."""
    wrong: tuple[str, ...]
    """What was not as it must be; empty where all was."""


Kept = tuple[PastCycle, int, list[str]]
"""A cycle on record, how many files it has, and what is wrong with them."""


SEEN = [
    SHOWN_COLUMNS.index(name)
    for name in ("truth.tip_mm", "annunciator.said", "annunciator.watchdog_fired", "alone")
]
"""Places of the columns that are looked at."""
TIP, SAID, FIRED, ALONE = range(len(SEEN))


def last_inside_s(rows: np.ndarray, mouth_mm: float) -> float:
    """When the tip was last inside, after the first row; 0 for never."""
    inside = np.flatnonzero(rows[:, TIP] > mouth_mm)
    return 0.0 if not len(inside) else float(inside[-1] + 1) * 1e-3


def first_alone_s(rows: np.ndarray) -> float:
    """When the drives acted on their own for the first time; -1 for never."""
    alone = np.flatnonzero(rows[:, ALONE])
    return float(alone[0] + 1) * 1e-3 if len(alone) else -1.0


def shows(rows: np.ndarray, victim: str) -> np.ndarray:
    """Rows in which the bedside shows what it has to show of this death."""
    if victim in ("control", "all"):
        return np.asarray(rows[:, FIRED] == 1.0)
    return (rows[:, SAID].astype(np.int64) >> Condition.RECORDER_LOST & 1).astype(bool)


def first_told_s(rows: np.ndarray, victim: str, lit: bool) -> float:
    """When the bedside first showed it.

    lit: it did so before, in the same cycle. Then it must go on until people have been told.
    """
    shown = shows(rows, victim)
    if lit and shown[: round(TOLD_WITHIN_S / DT_S)].all():
        return 0.0
    # A lamp that was lit before and went out tells nobody anything new.
    found = np.flatnonzero(shown & ~np.concatenate((shown[:1], shown[:-1])))
    return float(found[0]) * 1e-3 if len(found) else float("inf")


def list_late_drives(victim: str, alone_s: float, most_s: float) -> list[str]:
    """Drives that acted on their own too late after a controller's death, to a tick."""
    if victim not in ("control", "all") or 0.0 < alone_s <= most_s + DT_S:
        return []
    return [f"the drives acted on their own after {alone_s:.3f} s"]


def look_at_records(
    database: str, out: Path, victim: str, in_cycle: bool, is_anyone_hung: bool
) -> Kept:
    """The last cycle, and what is wrong with what is on record of it.

    out: where recordings are. in_cycle: it was under way when the victim died. is_anyone_hung:
    besides.
    """
    wrong = []
    with Records.open(database) as records:
        cycle = records.history.list_cycles(ABOUT.machine.serial, 1)[0]
        broken = records.audit().broken
    if broken is not None:
        wrong.append(f"audit: {broken}")
    expected: tuple[Outcome, ...] = (Outcome.COMPLETED, Outcome.ABORTED)
    if victim in ("control", "all") and in_cycle:
        expected = (Outcome.INTERRUPTED,)
    if cycle.outcome not in expected:
        wrong.append(f"on record as {cycle.outcome}")
    assert cycle.recording is not None
    files = sorted(out.glob(f"{Path(cycle.recording).stem}*.mcap"))
    held = [verdict for file in files if (verdict := _look_at(file)) is not None]
    if not held:
        wrong.append(f"no row of the recording {cycle.recording}, in {len(files)} files")
    if len(held) < len(files) and not is_anyone_hung and victim not in ("recorder", "all"):
        wrong.append("a file without a row, whose recorder did not end")
    return cycle, len(files), [*wrong, *itertools.chain.from_iterable(held)]


def _look_at(file: Path) -> list[str] | None:
    """Flaws of a recording, which can be read and replays to the last bit without one.

    None of one without a row, which a recorder that ended as it began has left: that is no flaw
    where the parts after it hold the cycle.
    """
    try:
        with closing(RecordingReader(file)) as reader:
            verdict = replay.replay(reader)
    except NothingRecordedError:
        return None
    if not verdict.identical:
        return [f"{file.name}: replay differs: {verdict.first}"]
    return [f"{file.name}: {reader.flaw}"] if reader.is_damaged else []
