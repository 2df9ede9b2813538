"""Several programs and threads write at the same time: one trail, nothing lost."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from sqlalchemy import event, text

from opensuction.records.database import database
from opensuction.records.database.failure import RecordsError
from opensuction.records.records import Records
from tests.records.conftest import on_both
from tests.records.example import CLOGGED, COMPLETED, MACHINE, count_entries, start
from tests.records.writer import begin_writer

CYCLES = 25


def test_two_programs_make_a_new_database_and_one_trail(empty_url: str) -> None:
    url = empty_url
    writers = [begin_writer(url, machine, CYCLES) for machine in ("M-1", "M-2")]
    said = [writer.wait() for writer in writers]
    assert [writer.process.exitcode for writer in writers] == [0, 0]
    with Records.open(url) as records:
        report = records.audit()
        assert report.broken is None
        # Two machines, one patient, protocol and parameter file; a catheter, a cycle, an alarm and
        # an end for each cycle.
        assert report.entries == 2 + 3 + 2 * CYCLES * 4
        for cycle in (*said[0], *said[1]):
            assert records.find_end(cycle) == COMPLETED


@on_both
def test_threads_share_the_records(url: str) -> None:
    with Records.open(url) as records, ThreadPoolExecutor(4) as threads:
        cycle = records.begin_cycle(start())
        before = count_entries(records)

        def add(key: str | None) -> str:
            return records.add_alarm(MACHINE, CLOGGED, cycle, key)

        alarms = list(threads.map(lambda _: add(None), range(20)))
        keyed = set(threads.map(lambda _: add("k"), range(8)))
        assert len(set(alarms)) == 20
        assert len(keyed) == 1
        assert count_entries(records) == before + 20 + 2
        listed = records.history.list_alarms("M-1")
        assert [one.number for one in listed] == list(range(21, 0, -1))
        assert records.audit().broken is None


@on_both
def test_who_waits_too_long_is_told_in_a_line_and_nothing_is_stored(url: str) -> None:
    with Records.open(url) as first, Records.open(url, wait_s=0.05) as second:
        with first.database.writing() as connection:
            if connection.dialect.name == "postgresql":
                connection.execute(text("SELECT id FROM audit_head FOR UPDATE"))
            with pytest.raises(RecordsError, match="nothing of this request was stored; try again"):
                second.begin_cycle(start(), key="k")
        assert count_entries(first) == 0
        second.begin_cycle(start(), key="k")
        assert first.audit().broken is None


@on_both
def test_what_is_written_during_an_audit_does_not_disturb_it(url: str) -> None:
    with Records.open(url) as reader, Records.open(url) as writer:
        cycle = writer.begin_cycle(start())
        before = count_entries(writer)

        def write(_connection: object, _cursor: object, statement: str, *_: object) -> None:
            if "FROM audit_head" in statement:  # all entries have been read
                writer.add_alarm(MACHINE, CLOGGED, cycle)

        event.listen(reader.database.engine, "before_cursor_execute", write)
        report = reader.audit()
        assert report.broken is None
        assert report.entries == before < count_entries(writer)


def test_a_foreign_program_that_locks_the_file_is_waited_for(tmp_path: Path) -> None:
    import sqlite3

    file = tmp_path / "records.db"
    with Records.open(str(file), wait_s=0.05) as records:
        other = sqlite3.connect(file, isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(RecordsError, match="another program keeps it locked"):
            records.begin_cycle(start())
        other.execute("ROLLBACK")
        other.close()
        records.begin_cycle(start())


@on_both
def test_reading_waits_for_nobody(url: str) -> None:
    with Records.open(url) as first, Records.open(url, wait_s=0.05) as second:
        cycle = first.begin_cycle(start())
        with first.database.writing() as connection:
            if connection.dialect.name == "postgresql":
                connection.execute(text("SELECT id FROM audit_head FOR UPDATE"))
            assert [one.id for one in second.unfinished_cycles()] == [cycle]
            assert second.audit().broken is None


@pytest.mark.usefixtures("disk_awaited")
def test_no_checkpoint_runs_beside_a_writer(tmp_path: Path) -> None:
    """SQLite's own follow a commit, so the lock is held until that is over."""
    file = tmp_path / "records.db"
    free: list[bool] = []

    def try_lock() -> None:
        try:
            with database.hold(file, 0.0):
                free.append(True)
        except TimeoutError:
            free.append(False)

    with Records.open(str(file)) as records:
        event.listen(records.database.engine, "commit", lambda _: try_lock())
        records.begin_cycle(start())
        assert free == [False]
        try_lock()
        assert free == [False, True]
        with records.database.reading() as connection:
            try_lock()
            assert connection.exec_driver_sql("PRAGMA journal_mode").scalar_one() == "wal"
            assert connection.exec_driver_sql("PRAGMA synchronous").scalar_one() == 2
        assert free == [False, True, True, True]
