"""Judge of what is left of a life: its recordings and records, held against what was published.

Whatever a controller has published while the machine was not at rest is in a recording once and as
it was; each cycle, alarm and request is on record once. Rows may be missing where a recorder was
away for longer than the ring holds, and as many as were told.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.evidence.lives.recording_judge import Kept, Recordings
from opensuction.evidence.lives.witness import Flags, Published, WitnessedRun
from opensuction.host.host import NS_PER_S
from opensuction.kernel.interface import STOP
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.records.entry import Outcome
from opensuction.records.history import PastAction, PastCycle
from opensuction.records.records import Records
from opensuction.runtime import recording_part
from opensuction.runtime.control_process import PERIOD_NS
from opensuction.runtime.database_writer import UNSEEN
from opensuction.runtime.journal import MACHINE, SUPERVISOR, in_words
from opensuction.runtime.machine_folder import SLOTS_S
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition

MOST = 1000
"""Entries of a life, of each kind."""
AWAY_S = SLOTS_S - 2.0
"""A recorder that was away for no longer has missed nothing: it reads what came before it is ready.
"""
SOON_S = 2.1
"""Later nobody means the machine any more that was pressed at."""
CLOCK_S = 1e-6
"""Rounding of instants."""


INVARIANTS = {
    "crash": "no process ends by an error that it does not know",
    "harm": "no bound of harm is broken",
    "outside": "at the end the tip is outside, or somebody is told",
    "told": "people are told within 1 s of a controller that dies in a cycle, 3 s of another",
    "hang": "a process that hangs is ended in time, and no other",
    "press": "each press is answered, carried out once, in its order and soon",
    "stop": "a STOP that was answered has been acted on",
    "rest": "the machine comes to rest after a cycle, and its processes work",
    "record": "every cycle is on record as it ended, and the audit trail verifies",
    "recording": "every recording can be read, replays bit for bit and tells its changes",
    "rows": "each row that was published is in a recording once; what is missing was told",
    "kept": "each cycle, alarm, request and file of a recording is on record once; the disk has "
    "each recording, or people were told",
    "ticks": "a controller counts every tick that it misses",
    "memory": "a controller undoes no limit of the one before, nor forgets that it died in a cycle",
    "end": "told to end, everything ends",
}
"""What must hold in every life."""


class BrokenInvariant(NamedTuple):
    """Something that must not be."""

    invariant: str
    """One of `INVARIANTS`."""
    detail: str


class Circumstances(NamedTuple):
    """Observations of a life while it was played."""

    runs: Sequence[WitnessedRun]
    away_s: float
    """For how long no recorder did anything that disk and database kept, at the longest."""
    is_told: bool
    """People were told that something is not kept."""
    is_refusal_told: bool
    """They were told since disk or database refused something."""
    synced: Mapping[Path, int]
    """Bytes that the disk has of each file."""
    unkept_s: tuple[tuple[float, float], ...] = ()
    """Begins and ends of times, by the computer's clock, of which a loss of power may have taken
    everything along."""
    set_back_s: float = 0.0
    """By how much the wall clock was set back in all."""

    def may_be_lost(self, time_s: Array) -> Flags:
        """True at instants of which nothing need be kept."""
        found = np.zeros(len(time_s), bool)
        for begin_s, end_s in self.unkept_s:
            found |= (time_s >= begin_s) & (time_s <= end_s)
        return found


def judge(seen: Circumstances, out: Path, database: Path, serial: str) -> Iterator[BrokenInvariant]:
    """Violations by what is left. out: folder of the recordings. serial: of the machine."""
    runs = seen.runs
    files = sorted(out.glob("*.mcap"))
    recordings = Recordings()
    for file in files:
        yield from (BrokenInvariant("recording", said) for said in recordings.judge(file))
        if seen.synced.get(file, 0) != file.stat().st_size and not seen.is_refusal_told:
            yield BrokenInvariant("kept", f"the disk has not all of {file.name}, nobody told")
    published = [(one, rows) for one in runs if (rows := one.published()) is not None]
    yield from _judge_runs([rows for _, rows in published], seen)
    if not database.exists():
        yield BrokenInvariant("record", "there is none")
        return
    with Records.open(str(database)) as records:
        audit = records.audit()
        if audit.broken is not None:
            yield BrokenInvariant("record", f"audit: {audit.broken}")
        cycles = records.history.list_cycles(serial, limit=MOST)
        for one in cycles:
            if one.outcome is None:
                yield BrokenInvariant("record", f"cycle {one.number} has no end")
        actions = records.history.list_actions(serial, limit=MOST)
        missed, unrecorded = (
            sum(int(one.detail.split(maxsplit=1)[0]) for one in actions if one.what == what)
            for what in ("rows-missed", "rows-unrecorded")
        )
        yield from _judge_twice(actions)
        yield from _judge_loss(seen, missed + unrecorded)
        yield from _judge_rows(published, recordings.kept(), missed + unrecorded, seen)
        if missed:
            return  # what happened in them nobody knows
        yield from _judge_cycles(published, cycles, seen)
        if not seen.unkept_s:  # the notes of what files held are gone with the power
            yield from _judge_files(records, files, recordings.unfinished)
        alarms = [one.condition for one in records.history.list_alarms(serial, limit=MOST)]
        wanted = [told for _, rows in published for told in _alarms_of(rows)]
        yield from _compare("alarms", wanted, alarms, seen)
        people = [one for one in actions if one.done_by not in (MACHINE, SUPERVISOR)]
        done = [f"{one.what} by {one.done_by}: {one.detail}" for one in people]
        yield from _compare("requests", list(_requests_of(runs)), done, seen)


def _judge_loss(seen: Circumstances, rows: int) -> Iterator[BrokenInvariant]:
    """Violations by rows that were told to be lost, where they need not be or no person knows."""
    if rows and seen.away_s < AWAY_S:
        said = f"{rows} rows are lost, though all was kept but for {seen.away_s:.1f} s"
        yield BrokenInvariant("rows", said)
    if rows and not seen.is_told:
        yield BrokenInvariant("rows", f"{rows} are lost, and no person was told")


def _judge_twice(actions: Sequence[PastAction]) -> Iterator[BrokenInvariant]:
    """Violations by what a supervisor did once and is on record more often."""
    said = [one._replace(id="", number=0) for one in actions if one.done_by == SUPERVISOR]
    for one, times in Counter(said).items():
        if times > 1:
            yield BrokenInvariant("kept", f"{one.what} is on record {times} times")


def _judge_files(
    records: Records, files: Sequence[Path], unfinished: set[Path]
) -> Iterator[BrokenInvariant]:
    """Violations by what is on record of the recordings' files."""
    for file in files:
        bound = records.history.find_recording(file.name)
        if bound is None and file.stat().st_size:
            yield BrokenInvariant("kept", f"what {file.name} holds is not on record")
        elif bound is not None and bound.file.is_closed and file in unfinished:
            yield BrokenInvariant("recording", f"{file.name} was closed, and has no end")


def judge_presses(
    runs: Sequence[WitnessedRun], asked_ns: Mapping[str, int]
) -> Iterator[BrokenInvariant]:
    """Violations by what became of people's presses.

    asked_ns: when each was sent, by its key, in their order.
    """
    numbers = {key: number for number, key in enumerate(asked_ns)}
    for run in runs:
        last: dict[str, int] = {}
        for fields in (one.fields for one in run.events if one.fields["kind"] == "request"):
            key, who, ask = str(fields["key"]), str(fields["who"]), str(fields["ask"])
            if fields["verdict"] != "pressed" or ask == STOP or key not in numbers:
                continue
            waited_s = (int(fields["time_ns"]) - asked_ns[key]) / NS_PER_S
            if waited_s > SOON_S:
                yield BrokenInvariant("press", f"{key} ({ask}) {waited_s:.1f} s after it was sent")
            if numbers[key] <= last.get(who, -1):
                yield BrokenInvariant("press", f"{key} ({ask}) twice, or after a later one")
            last[who] = numbers[key]


class _Wanted(NamedTuple):
    """Entry that should be on record."""

    name: str
    at_s: float
    """By the computer's clock."""


def _compare(
    what: str, wanted: Sequence[_Wanted], found: Sequence[str], seen: Circumstances
) -> Iterator[BrokenInvariant]:
    """Violations where entries on record are not those that should be, or may be."""
    may = seen.may_be_lost(np.array([one.at_s for one in wanted]))
    least = Counter(one.name for one, is_free in zip(wanted, may, strict=True) if not is_free)
    most, there = Counter(one.name for one in wanted), Counter(found)
    for name in sorted(most | there):
        if not least[name] <= there[name] <= most[name]:
            said = f"{what}: {name}: {there[name]} on record of {least[name]}"
            yield BrokenInvariant("kept", said)


def _judge_runs(runs: Sequence[Published], seen: Circumstances) -> Iterator[BrokenInvariant]:
    """Violations by what controllers published themselves, and by what the next one knows of it."""
    for rows in runs:
        ticks = 1.0 + rows.skipped[1:]
        late_s = np.diff(rows.time_s) - ticks * PERIOD_NS * 1e-9
        if (np.diff(rows.tick) != 1.0).any() or (np.abs(late_s) > CLOCK_S).any():
            yield BrokenInvariant("ticks", "one is missing, and was not counted")
    for before, after in pairwise(runs):
        off_s = after.time_s[0] - before.time_s[-1]
        dark = [
            begin_s
            for begin_s, end_s in seen.unkept_s
            if before.time_s[-1] <= end_s <= after.time_s[0]
        ]
        if any(begin_s < before.time_s[0] for begin_s in dark):
            continue  # it need not have been kept
        # For how long the computer was off it knows by the wall clock alone.
        set_back_s = seen.set_back_s if dark else 0.0
        told = {
            "passes": after.passes[0] >= before.passes[-1],
            "catheter's age": not after.age_s[0] < before.age_s[-1] - set_back_s,
            "rest": after.rest_left_s[0] >= before.rest_left_s[-1] - off_s - 1.0,
        }
        for name, holds in told.items():
            if not holds:
                yield BrokenInvariant("memory", f"a controller does not know the {name} before it")
        if before.phase[-1] not in map(int, RESTING) and int(after.phase[0]) == Phase.PARKED:
            yield BrokenInvariant("memory", "a controller does not know that one died in a cycle")


def _judge_rows(
    published: Sequence[tuple[WitnessedRun, Published]],
    kept: Mapping[str, Kept],
    missed: int,
    seen: Circumstances,
) -> Iterator[BrokenInvariant]:
    """Violations by rows that are not in a recording once, as they were published."""
    lost = 0
    for run, rows in published:
        wanted, sums = rows.tick[rows.has_left], rows.sums[rows.has_left]
        if not len(wanted):
            continue
        found = kept.get(run.name, Kept(np.zeros(0), np.zeros(0, np.uint64)))
        order = np.argsort(found.tick, kind="stable")
        ticks, have = found.tick[order], found.sums[order]
        first, after = (np.searchsorted(ticks, wanted, side) for side in ("left", "right"))
        count = after - first
        free = seen.may_be_lost(rows.time_s[rows.has_left])
        lost += int(np.count_nonzero((count == 0) & ~free))
        if (count > 1).any():
            tick = int(wanted[count > 1][0])
            yield BrokenInvariant("rows", f"tick {tick} of {run.name} is in recordings twice")
        there = count > 0
        if (have[first[there]] != sums[there]).any():
            yield BrokenInvariant("rows", f"one of {run.name} is not as it was published")
    if lost > missed:
        yield BrokenInvariant("rows", f"{lost} are in no recording, of {missed} that were told")


def _judge_cycles(
    published: Sequence[tuple[WitnessedRun, Published]],
    cycles: Sequence[PastCycle],
    seen: Circumstances,
) -> Iterator[BrokenInvariant]:
    """Violations by cycles on record that are not those that were."""
    wanted: dict[str, Outcome] = {}
    begun: list[_Wanted] = []
    unseen: set[str] = set()
    for run, rows in published:
        for left in np.unique(rows.left_rest[rows.in_cycle & rows.has_left]):
            its = np.flatnonzero(rows.left_rest == left)
            first, last = int(its[0]), int(its[-1])
            outcome = Outcome.INTERRUPTED
            if last + 1 < len(rows.tick):
                is_parked = int(rows.phase[last + 1]) == Phase.PARKED
                outcome = Outcome.COMPLETED if is_parked else Outcome.ABORTED
            name = recording_part.name_of(run.name, left)
            wanted[name] = outcome
            begun.append(_Wanted(name, float(rows.time_s[first])))
            if seen.may_be_lost(rows.time_s[last : last + 1]).any():
                unseen.add(name)
    yield from _compare("cycles", begun, [one.recording or "" for one in cycles], seen)
    for one in cycles:
        if one.recording in unseen:
            continue  # how it ended went with the power
        expected = wanted.get(one.recording or "", one.outcome)
        if one.outcome is not None and (one.outcome != expected or one.detail == UNSEEN.detail):
            said = f"cycle {one.number} is on record as {one.outcome} ({one.detail})"
            yield BrokenInvariant("record", f"{said}, not as {expected}")


def _alarms_of(rows: Published) -> Iterator[_Wanted]:
    """Names of the conditions that people were told, one for each time that one began."""
    before = np.concatenate(([0], rows.told[:-1]))
    for at in np.flatnonzero(rows.told != before):
        for number in condition_mask.decode(int(rows.told[at] & ~before[at])):
            yield _Wanted(Condition(number).name, float(rows.time_s[at]))


def _requests_of(runs: Sequence[WitnessedRun]) -> Iterator[_Wanted]:
    """Requests of people with what became of them."""
    for run in runs:
        for event in run.events:
            fields = event.fields
            if fields["kind"] == "request" and fields["verdict"] != "malformed":
                who, ask = in_words(str(fields["who"])), in_words(str(fields["ask"]))
                at_s = int(fields["time_ns"]) / NS_PER_S
                yield _Wanted(f"{ask} by {who}: {fields['verdict']}", at_s)
