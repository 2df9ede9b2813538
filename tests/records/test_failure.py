"""Whatever is wrong with a database: one plain line, nothing lost, and no password in it."""

import contextlib
import os
import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import URL, event, make_url, text

from opensuction.records import audit
from opensuction.records.database import database as database_module
from opensuction.records.database import schema
from opensuction.records.database.failure import RecordsError
from opensuction.records.database.schema import access_token, account_state
from opensuction.records.records import Records
from tests.records.conftest import in_server, on_both
from tests.records.example import CLOGGED, COMPLETED, MACHINE, count_entries, fill, start
from tests.records.writer import begin_writer

NOBODY = 65534


def refusal(call: Callable[[], object]) -> str:
    """The one line that is said."""
    with pytest.raises(RecordsError) as refused:
        call()
    line = str(refused.value)
    assert len(line.splitlines()) == 1
    assert len(line) < 400
    return line


ADDRESSES = [
    ("", "is missing"),
    ("  ", "is missing"),
    ("a\0b", "is missing"),
    ("mysql://anna:secret@host/records", "mysql: no kind of database that is known here"),
    ("http://anna:secret@host/records", "http: no kind"),
    ("postgresql+psycopg2://anna:secret@host/records", "no kind of database"),
    ("a" * 5000, "is no name of a file"),
    ("\ud800.db", "is no name of a file"),
    ("sqlite://", "records in memory would be lost"),
    ("sqlite:///:memory:", "records in memory would be lost"),
    ("sqlite:///ward.db?mode=ro", "a file takes no options"),
    ("postgresql://anna:secret@host", "names no database"),
    ("postgresql://anna:secret@host:port/records", "cannot be read"),
    ("://anna:secret@host", "cannot be read"),
]


@pytest.mark.parametrize(("url", "words"), ADDRESSES, ids=[ascii(url[:60]) for url, _ in ADDRESSES])
def test_an_address_that_is_none_is_refused(url: str, words: str) -> None:
    line = refusal(lambda: Records.open(url))
    assert words in line
    assert "postgresql://USER@HOST/NAME" in line
    assert "secret" not in line


@given(st.text(st.characters(codec=None, exclude_categories=[]), max_size=30))
def test_any_address_is_one_or_one_line(url: str) -> None:
    try:
        database_module.parse(url)
    except RecordsError as refused:
        assert len(str(refused).splitlines()) == 1


def test_no_password_is_ever_shown() -> None:
    url = "postgresql://anna:secret@host/records?password=secret&sslpassword=secret"
    assert database_module.parse(url).shown == "postgresql://anna@host/records"


def test_the_default_is_the_environment_s_else_the_user_s(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(database_module.VARIABLE, raising=False)
    assert database_module.default().endswith("records.db")
    monkeypatch.setenv(database_module.VARIABLE, "ward.db")
    assert database_module.parse().shown == "ward.db"


def test_a_folder_is_no_database(tmp_path: Path) -> None:
    assert "is a folder; name a file" in refusal(lambda: Records.open(str(tmp_path)))


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    line = refusal(lambda: Records.open(str(tmp_path / "file" / "records.db")))
    assert "cannot be made" in line


def test_a_file_that_is_not_there_is_not_made_by_an_audit(tmp_path: Path) -> None:
    file = tmp_path / "records.db"
    assert "no such file" in refusal(lambda: audit.open_for_audit(str(file)))
    assert list(tmp_path.iterdir()) == []


def test_an_empty_database_has_nothing_to_audit(tmp_path: Path) -> None:
    file = tmp_path / "records.db"
    file.touch()
    database = audit.open_for_audit(str(file))
    assert "is empty" in refusal(lambda: audit.audit(database))
    database.close()


@pytest.mark.parametrize("content", [b"ward;bed\n" * 200, b"SQLite format 3\0" + b"\xff" * 4096])
def test_a_file_of_something_else_is_refused_and_left_alone(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "records.db"
    file.write_bytes(content)
    assert "is damaged" in refusal(lambda: Records.open(str(file)))
    assert file.read_bytes() == content


@pytest.fixture(scope="module")
def filled_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("filled") / "records.db"
    with Records.open(str(file)) as records:
        fill(records, 5)
    return file


def test_a_file_cut_off_is_refused_or_found_broken(filled_file: Path, tmp_path: Path) -> None:
    whole = filled_file.read_bytes()
    for length in range(4096, len(whole), 4096 * 3):
        file = tmp_path / "cut.db"
        file.write_bytes(whole[:length])
        database = audit.open_for_audit(str(file))
        with contextlib.suppress(RecordsError):
            assert audit.audit(database).broken is not None, length
        database.close()


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_page_is_refused_or_found_or_of_no_matter(
    filled_file: Path, tmp_path: Path, data: st.DataObject
) -> None:
    content = bytearray(filled_file.read_bytes())
    at = data.draw(st.integers(100, len(content) - 64))
    content[at : at + 64] = data.draw(st.binary(min_size=64, max_size=64))
    file = tmp_path / "damaged.db"
    file.write_bytes(content)
    database = audit.open_for_audit(str(file))
    with contextlib.suppress(RecordsError):
        report = audit.audit(database)
        if report.broken is None:  # the damage lay where nothing is, or was none
            assert report.entries == 5 * 6 + 4
    database.close()


def test_an_index_that_lost_its_entries_is_found(filled_file: Path, tmp_path: Path) -> None:
    file = tmp_path / "damaged.db"
    content = bytearray(filled_file.read_bytes())
    connection = sqlite3.connect(filled_file)
    query = "SELECT rootpage FROM sqlite_master WHERE name = 'ix_alarm_cycle_id'"
    at = (connection.execute(query).fetchone()[0] - 1) * 4096
    connection.close()
    content[at + 3 : at + 5] = b"\0\0"  # how many cells the page has
    file.write_bytes(content)
    database = audit.open_for_audit(str(file))
    assert "the file is damaged: " in str(audit.audit(database).broken)
    database.close()


def test_a_full_disk_is_one_line_and_what_was_stored_stays(tmp_path: Path) -> None:
    with Records.open(str(tmp_path / "records.db")) as records:
        cycle = records.begin_cycle(start())

        @event.listens_for(records.database.engine, "begin")
        def fill_up(connection: object) -> None:
            connection.exec_driver_sql("PRAGMA max_page_count = 1")  # type: ignore[attr-defined]

        before, long = count_entries(records), CLOGGED._replace(detail="x" * 4000)
        line = refusal(lambda: [records.add_alarm(MACHINE, long, cycle) for _ in range(1000)])
        assert "the disk is full; nothing of this request was stored; make room and" in line
        report = records.audit()
        assert report.broken is None
        assert report.entries == count_entries(records) >= before


def test_a_server_s_full_disk_is_one_line_and_what_was_stored_stays(postgresql_url: str) -> None:
    with Records.open(postgresql_url) as records:
        cycle = records.begin_cycle(start())
        before = records.head()
        with records.database.writing() as connection:
            connection.exec_driver_sql(
                "CREATE FUNCTION fill_up() RETURNS trigger LANGUAGE plpgsql AS $$ "
                "BEGIN RAISE disk_full USING MESSAGE = 'could not extend file'; END $$"
            )
            connection.exec_driver_sql(
                "CREATE TRIGGER full_disk BEFORE INSERT ON alarm "
                "FOR EACH ROW EXECUTE FUNCTION fill_up()"
            )
        line = refusal(lambda: records.add_alarm(MACHINE, CLOGGED, cycle))
        assert "the disk is full; nothing of this request was stored" in line
        assert records.head() == before
        records.end_cycle(cycle, COMPLETED)
        assert records.audit().broken is None


@contextlib.contextmanager
def unprivileged() -> Iterator[Path]:
    """A folder, and a person who may write nothing in it, even where the tests run as root."""
    folder = Path(tempfile.mkdtemp())
    folder.chmod(0o755)
    try:
        yield folder
    finally:
        shutil.rmtree(folder)


@contextlib.contextmanager
def as_nobody() -> Iterator[None]:
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)


def test_a_file_that_may_only_be_read_can_be_audited_and_not_written() -> None:
    with unprivileged() as folder:
        file = folder / "records.db"
        with Records.open(str(file)) as records:
            fill(records)
            expected = records.audit()
        (folder / "records.db-lock").chmod(0o666)  # the lock is another matter
        file.chmod(0o444)
        folder.chmod(0o555)
        content = file.read_bytes()
        with as_nobody():
            database = audit.open_for_audit(str(file))
            assert audit.audit(database) == expected
            database.close()
            line = refusal(lambda: Records.open(str(file)))
        assert "may not be written" in line or "cannot be opened" in line
        assert file.read_bytes() == content
        folder.chmod(0o755)


@pytest.mark.parametrize("log_is_there", [False, True])
def test_a_file_that_may_only_be_read_takes_no_machine(log_is_there: bool) -> None:
    with unprivileged() as folder:
        file = folder / "records.db"
        with Records.open(str(file)) as records:
            fill(records, 1)
        for name in ("-lock", "-wal", "-shm")[: 3 if log_is_there else 1]:
            file.with_name(f"records.db{name}").touch()
            file.with_name(f"records.db{name}").chmod(0o666)
        file.chmod(0o444)
        folder.chmod(0o777)
        with as_nobody():
            line = refusal(lambda: Records.open_for_machine(str(file)))
        assert "may not be written" in line
        folder.chmod(0o755)


WRITTEN = [
    *(one for one in schema.AUDITED if one not in (account_state, access_token)),
    schema.audit,
]
"""Tables that a recorder writes."""


@pytest.mark.parametrize("table", [one.name for one in WRITTEN])
def test_a_table_that_takes_no_row_is_found_before_a_machine_begins(url: str, table: str) -> None:
    with Records.open(url) as records:
        fill(records, 1)
        before = records.head()
        with records.database.writing() as connection:
            if connection.dialect.name == "sqlite":
                refuse = "BEGIN SELECT RAISE(ABORT, 'no more'); END"
            else:
                connection.exec_driver_sql(
                    "CREATE FUNCTION refuse() RETURNS trigger LANGUAGE plpgsql AS $$ "
                    "BEGIN RAISE check_violation USING MESSAGE = 'no more'; END $$"
                )
                refuse = "FOR EACH ROW EXECUTE FUNCTION refuse()"
            connection.exec_driver_sql(f"CREATE TRIGGER refused BEFORE INSERT ON {table} {refuse}")
        line = refusal(lambda: Records.open_for_machine(url))
        assert "does not take the entry: no more" in line
        with records.database.writing() as connection:
            if connection.dialect.name == "sqlite":
                connection.exec_driver_sql("DROP TRIGGER refused")
            else:
                connection.exec_driver_sql("DROP FUNCTION refuse CASCADE")
        Records.open_for_machine(url).close()
        assert records.head() == before, "what was tried is taken back"
        assert records.audit().broken is None


def test_a_folder_that_may_not_be_written_is_one_line() -> None:
    with unprivileged() as folder:
        folder.chmod(0o555)
        with as_nobody():
            line = refusal(lambda: Records.open(str(folder / "records.db")))
        assert "cannot be made (permission denied)" in line
        folder.chmod(0o755)


def test_an_audit_needs_no_right_to_write(postgresql_url: str) -> None:
    with Records.open(postgresql_url) as records:
        fill(records, 1)
    whole = make_url(postgresql_url)
    in_server(postgresql_url, "CREATE ROLE auditor LOGIN PASSWORD 'auditing'")
    in_server(postgresql_url, "GRANT SELECT ON ALL TABLES IN SCHEMA public TO auditor")
    try:
        url = whole.set(username="auditor", password="auditing")
        database = audit.open_for_audit(url.render_as_string(hide_password=False))
        assert audit.audit(database).broken is None
        database.close()
        with Records.open(url.render_as_string(hide_password=False)) as records:
            assert "the user lacks the right" in refusal(lambda: records.begin_cycle(start()))
        line = refusal(lambda: Records.open_for_machine(url.render_as_string(hide_password=False)))
        assert "the user lacks the right (permission denied for table audit_head)" in line
    finally:
        in_server(postgresql_url, "DROP OWNED BY auditor")
        in_server(postgresql_url, "DROP ROLE auditor")


@on_both
def test_an_audit_cannot_write(url: str) -> None:
    with Records.open(url) as records:
        fill(records, 1)
    database = audit.open_for_audit(url)
    with (
        pytest.raises(RecordsError, match=r"may only be read|may not be written"),
        database.writing() as connection,
    ):
        connection.execute(text("DELETE FROM alarm"))
    database.close()


def test_a_server_that_is_not_there_is_one_line() -> None:
    line = refusal(lambda: Records.open("postgresql://anna:secret@127.0.0.1:1/records"))
    assert line.startswith("postgresql://anna@127.0.0.1:1/records: the server is not there")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"database": "nowhere"}, "the server has no such database; create it with createdb"),
        ({"password": "wrong"}, "the password is wrong or missing"),
        ({"password": None}, "the password is wrong or missing"),
        ({"username": "nobody"}, "the password is wrong or missing"),
    ],
    ids=str,
)
def test_what_a_server_refuses_is_one_line(
    postgresql_url: str, changes: dict[str, Any], words: str
) -> None:
    whole = make_url(postgresql_url)
    parts = {name: getattr(whole, name) for name in ("username", "password", "host", "port")}
    url = URL.create("postgresql", **{**parts, "database": whole.database, **changes})
    line = refusal(lambda: Records.open(url.render_as_string(hide_password=False)))
    assert words in line
    assert str(whole.password) not in line


def test_a_server_without_its_driver_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "psycopg", None)
    line = refusal(lambda: Records.open("postgresql://anna@127.0.0.1:1/records"))
    assert "pip install 'opensuction[postgresql]'" in line


def test_a_server_that_was_started_anew_is_no_failure(postgresql_url: str) -> None:
    with Records.open(postgresql_url) as records, Records.open(postgresql_url) as other:
        cycle = records.begin_cycle(start())
        with other.database.writing() as connection:
            connection.exec_driver_sql(
                "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
                "WHERE pid != pg_backend_pid() AND datname = current_database()"
            )
        records.end_cycle(cycle, COMPLETED)
        assert records.audit().broken is None


def test_a_server_that_goes_away_within_a_request_is_one_line(postgresql_url: str) -> None:
    with Records.open(postgresql_url) as records:
        cycle = records.begin_cycle(start())
        before = records.head()

        @event.listens_for(records.database.engine, "before_cursor_execute")
        def go_away(connection: object, _cursor: object, statement: str, *_: object) -> None:
            if statement.startswith("INSERT INTO alarm"):
                raw = connection.connection.dbapi_connection  # type: ignore[attr-defined]
                raw.execute("SELECT pg_terminate_backend(pg_backend_pid())")

        line = refusal(lambda: records.add_alarm(MACHINE, CLOGGED, cycle, key="k"))
        assert "the server is not there or went away" in line
        event.remove(records.database.engine, "before_cursor_execute", go_away)
        assert records.head() == before
        records.add_alarm(MACHINE, CLOGGED, cycle, key="k")
        assert records.audit().broken is None


def test_a_log_that_a_crash_left_is_read(tmp_path: Path) -> None:
    url = str(tmp_path / "records.db")
    with Records.open(url) as records:
        records.begin_cycle(start(machine="M-9", catheter="C-9"))
    answered = begin_writer(url, "M-1", 5, 40).wait()
    assert (tmp_path / "records.db-wal").stat().st_size > 0
    database = audit.open_for_audit(url)
    assert audit.audit(database).broken is None
    database.close()
    connection = sqlite3.connect(url)
    known = {row[0] for row in connection.execute("SELECT id FROM cycle")}
    connection.close()
    assert answered
    assert set(answered) <= known
