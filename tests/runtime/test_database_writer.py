"""Records after a recorder that died between storing an entry and noting that it is stored."""

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from opensuction.host.host import NS_PER_S, Work, finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.records.database.failure import RecordsError
from opensuction.records.entry import Action, CycleEnd, Outcome
from opensuction.records.history import PastCycle
from opensuction.records.records import Records
from opensuction.runtime import recording_part
from opensuction.runtime.database_writer import AGAIN_S, Context, DatabaseWriter
from opensuction.runtime.journal import Begun, Entry
from tests.runtime.identity import ABOUT

RUN = "20261123T120000-0123abcd"
SERIAL = ABOUT.machine.serial
CONTEXT = Context(ABOUT, "ab" * 32)
BEGAN = datetime(2026, 11, 23, 12, tzinfo=UTC)


def begun(tick: int) -> Entry:
    what = Begun("nurse", recording_part.name_of(RUN, tick))
    return Entry(f"{RUN}-{tick}-begin", BEGAN + timedelta(milliseconds=tick), what)


def ended(tick: int) -> Entry:
    what = CycleEnd(Outcome.COMPLETED, inside_at_end=False)
    return Entry(f"{RUN}-{tick}-end", BEGAN + timedelta(milliseconds=tick), what)


def stored(database: Path, work: Callable[[DatabaseWriter], None]) -> list[PastCycle]:
    """What a clerk leaves, oldest first."""
    clerk = DatabaseWriter(str(database))
    work(clerk)
    assert finish(clerk.close(20.0), THIS_COMPUTER.clock), clerk.lost
    with Records.open(str(database)) as records:
        assert records.audit().broken is None
        return list(reversed(records.history.list_cycles(SERIAL)))


def test_a_cycle_that_was_stored_and_comes_again_is_one_cycle_with_its_own_end(
    tmp_path: Path,
) -> None:
    """Killed before it noted how far it was: the next one hands over the beginning once more."""
    database = tmp_path / "records.db"
    stored(database, lambda clerk: clerk.put(begun(500), CONTEXT))

    def go_on(clerk: DatabaseWriter) -> None:
        clerk.adopt(SERIAL, None, lambda name: recording_part.is_after(name, RUN, 400))
        clerk.put(begun(500), CONTEXT)
        clerk.put(ended(9000), CONTEXT)
        clerk.put(begun(12_000), CONTEXT)
        clerk.put(ended(20_000), CONTEXT)

    cycles = stored(database, go_on)
    assert [one.recording for one in cycles] == [
        recording_part.name_of(RUN, 500),
        recording_part.name_of(RUN, 12_000),
    ]
    assert [one.outcome for one in cycles] == [Outcome.COMPLETED] * 2


def test_one_that_comes_again_from_who_did_not_hear_who_asked_has_its_end(tmp_path: Path) -> None:
    """Killed after it had heard the request and noted that: the next one hears of nobody."""
    database = tmp_path / "records.db"
    stored(database, lambda clerk: clerk.put(begun(500), CONTEXT))
    again = begun(500)._replace(what=Begun("unknown", recording_part.name_of(RUN, 500)))

    def go_on(clerk: DatabaseWriter) -> None:
        clerk.adopt(SERIAL, None, lambda name: recording_part.is_after(name, RUN, 400))
        clerk.put(again, CONTEXT)
        clerk.put(ended(9000), CONTEXT)

    (cycle,) = stored(database, go_on)
    assert (cycle.requested_by, cycle.outcome) == ("nurse", Outcome.COMPLETED)


def test_one_of_which_nothing_comes_any_more_is_ended_as_not_seen(tmp_path: Path) -> None:
    database = tmp_path / "records.db"
    stored(database, lambda clerk: clerk.put(begun(500), CONTEXT))

    def go_on(clerk: DatabaseWriter) -> None:
        clerk.adopt(SERIAL, None, lambda name: recording_part.is_after(name, RUN, 500))
        clerk.put(begun(12_000), CONTEXT)
        clerk.put(ended(20_000), CONTEXT)

    first, second = stored(database, go_on)
    assert first.outcome == Outcome.INTERRUPTED
    assert first.detail == "nobody recorded how it ended"
    assert second.outcome == Outcome.COMPLETED


def test_an_end_that_is_refused_holds_nothing_of_the_next_cycle_up(tmp_path: Path) -> None:
    """Somebody has ended it meanwhile: what people do afterwards is not put down to it."""
    database = tmp_path / "records.db"

    def work(clerk: DatabaseWriter) -> None:
        clerk.put(begun(500), CONTEXT)
        clerk.put(ended(9000), CONTEXT)
        clerk.adopt(SERIAL, None, lambda _: False)
        clerk.put(begun(500), CONTEXT)  # again: the one that has ended
        clerk.put(ended(9001), CONTEXT)  # refused
        act = Action("nurse", "assessed", "pressed")
        clerk.put(Entry("act", BEGAN, act), CONTEXT)

    (cycle,) = stored(database, work)
    assert cycle.outcome == Outcome.COMPLETED
    with Records.open(str(database)) as records:
        (act,) = records.history.list_actions(SERIAL)
        assert act.cycle_id is None


def test_records_that_take_no_cycle_are_missed_before_one_begins(tmp_path: Path) -> None:
    database = str(tmp_path / "records.db")
    with Records.open(database) as records, records.database.writing() as connection:
        connection.exec_driver_sql(
            "CREATE TRIGGER refused BEFORE INSERT ON cycle "
            "BEGIN SELECT RAISE(ABORT, 'no more'); END"
        )
    clerk = DatabaseWriter(database)
    clerk.adopt(SERIAL, None, lambda _: False)  # only reads
    while not clerk.lost and not clerk.is_idle:
        pass
    assert "does not take the entry: no more" in clerk.lost
    with Records.open(database) as records, records.database.writing() as connection:
        connection.exec_driver_sql("DROP TRIGGER refused")
    assert finish(clerk.close(20.0), THIS_COMPUTER.clock), clerk.lost
    assert clerk.lost == ""


def test_whether_a_recording_is_of_a_cycle_to_come() -> None:
    name = recording_part.name_of(RUN, 500)
    assert recording_part.is_after(name, RUN, 499)
    assert not recording_part.is_after(name, RUN, 500)
    assert not recording_part.is_after(name, f"{RUN}0", 0)
    assert not recording_part.is_after(None, RUN, 0)
    assert not recording_part.is_after("somebody's.mcap", RUN, 0)


def test_one_that_nobody_saw_begin_is_begun_late_and_one_that_was_seen_is_not_begun_twice(
    tmp_path: Path,
) -> None:
    recording, unseen = recording_part.name_of(RUN, 500), (begun(500), CONTEXT)

    def go_on(clerk: DatabaseWriter) -> None:
        clerk.adopt(SERIAL, recording, lambda _: False, unseen)
        clerk.put(ended(9000), CONTEXT)

    (late,) = stored(tmp_path / "late.db", go_on)
    assert (late.recording, late.outcome) == (recording, Outcome.COMPLETED)

    stored(tmp_path / "seen.db", lambda clerk: clerk.put(begun(400), CONTEXT))
    recording = recording_part.name_of(RUN, 400)
    (seen,) = stored(tmp_path / "seen.db", go_on)
    assert (seen.recording, seen.outcome) == (recording, Outcome.COMPLETED)


def test_it_says_when_all_of_the_controllers_before_is_on_record(tmp_path: Path) -> None:
    (tmp_path / "records.db").mkdir()  # no database can be there
    clerk = DatabaseWriter(str(tmp_path / "records.db"))
    clerk.follow(0)
    clerk.put(begun(500), CONTEXT)
    clerk.follow(0)
    assert not clerk.has_caught_up
    (tmp_path / "records.db").rmdir()
    assert finish(clerk.close(20.0), THIS_COMPUTER.clock), clerk.lost
    assert clerk.has_caught_up


class Stepped:
    """A clock that is set, and work that goes on whenever it is woken."""

    has_ended = False

    def __init__(self) -> None:
        self.now_ns, self.woken = 0, 0

    def monotonic_ns(self) -> int:
        return self.now_ns

    def begin(self, work: Work) -> "Stepped":
        self.work = work
        return self

    def wake(self) -> None:
        self.woken += 1
        next(self.work, None)


def test_a_database_that_is_away_is_asked_now_and_then_and_at_once_before_an_end() -> None:
    """However often the work is woken."""
    stepped, asked = Stepped(), []

    def refuse(_: str | None) -> Records:
        asked.append(stepped.now_ns)
        raise RecordsError("nobody answers")

    host = THIS_COMPUTER._replace(clock=stepped, begin_worker=stepped.begin)  # type: ignore[arg-type]
    clerk = DatabaseWriter("away", host, refuse)
    clerk.put(begun(500), CONTEXT)
    for row in range(100):
        stepped.now_ns += 20_000_000
        clerk.reach(row)
        stepped.wake()
    assert len(asked) == pytest.approx(2.0 / AGAIN_S, abs=2)
    assert min(np.diff(asked)) >= AGAIN_S * NS_PER_S
    stepped.now_ns += 1
    list(clerk.close(0.0))
    assert asked[-1] == stepped.now_ns


def test_however_long_a_database_is_away_what_waits_is_what_happened(tmp_path: Path) -> None:
    """Each row that is followed is one more to be on record, 50 of them a second."""
    stepped, at = Stepped(), "away"

    def open_records(_: str | None) -> Records:
        if at == "away":
            raise RecordsError("nobody answers")
        return Records.open(str(tmp_path / "records.db"))

    host = THIS_COMPUTER._replace(clock=stepped, begin_worker=stepped.begin)  # type: ignore[arg-type]
    clerk = DatabaseWriter(None, host, open_records)
    for entry, rows in ((begun(500), range(2000)), (ended(9000), range(2000, 4000))):
        clerk.put(entry, CONTEXT)
        for row in rows:
            clerk.reach(row)
    assert stepped.woken == 4  # two entries, and a row behind each
    assert (clerk.stored, clerk.is_idle) == (0, False)
    at = "back"
    stepped.now_ns = NS_PER_S
    stepped.wake()
    assert (clerk.stored, clerk.is_idle) == (3999, True)
    list(clerk.close(0.0))


def test_a_row_is_not_on_record_before_the_entry_that_it_is_behind() -> None:
    stepped, refused = Stepped(), [begun(500)]
    seen = []

    class Recorded:
        def unfinished_cycles(self) -> list[object]:
            seen.append(clerk.stored)
            if len(seen) > 1:
                raise RecordsError("away again")
            return []

        def begin_cycle(self, *_: object) -> str:
            return "cycle"

    host = THIS_COMPUTER._replace(clock=stepped, begin_worker=stepped.begin)  # type: ignore[arg-type]
    at = ["away"]

    def open_records(_: str | None) -> Records:
        if at:
            raise RecordsError("nobody answers")
        return Recorded()  # type: ignore[return-value]

    clerk = DatabaseWriter(None, host, open_records)
    clerk.put(refused[0], CONTEXT)
    clerk.reach(7)
    clerk.reach(8)
    clerk.put(begun(12_000), CONTEXT)
    clerk.reach(9)
    clerk.reach(10)
    at.clear()
    stepped.now_ns = NS_PER_S
    stepped.wake()
    assert seen == [0, 8]
    assert clerk.stored == 8
