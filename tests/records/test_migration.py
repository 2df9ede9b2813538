"""From every version of the database to the newest: nothing lost, all or nothing, once."""

import os
import sqlite3
import stat
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import CheckConstraint, inspect, text

from opensuction.kernel import private_file
from opensuction.records import audit
from opensuction.records.database import database as database_module
from opensuction.records.database import schema
from opensuction.records.database.database import Database, connect, create_file, find_triggers
from opensuction.records.database.failure import RecordsError
from opensuction.records.migration import upgrade
from opensuction.records.records import Records
from tests.records.example import COMPLETED, fill, start

HERE = Path(__file__).parent
SHIPPED = upgrade.STEPS
NEWEST = "0003"


@pytest.fixture
def url(empty_url: str) -> str:
    return empty_url


def step(monkeypatch: pytest.MonkeyPatch, *folders: str) -> None:
    """As if the program were a later one."""
    monkeypatch.setattr(upgrade, "STEPS", (*SHIPPED, *(HERE / folder for folder in folders)))


def opened(url: str) -> Database:
    where = database_module.parse(url)
    create_file(where)
    database = connect(where, 5.0)
    database.prepare()
    return database


def version(url: str) -> str | None:
    database = opened(url)
    with database.reading() as connection:
        found = MigrationContext.configure(connection).get_current_revision()
    database.close()
    return found


def copies(url: str) -> list[Path]:
    """Copies from before beside a file; of a server's database none."""
    file = database_module.parse(url).file
    return [] if file is None else sorted(file.parent.glob(f"{file.name}.*Z"))


def test_what_migrations_make_is_what_the_program_knows(url: str) -> None:
    with Records.open(url) as records, records.database.reading() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        differences = compare_metadata(context, schema.METADATA)
        assert differences == []
        assert find_triggers(connection) == upgrade.name_triggers(connection.dialect.name)
        seen = inspect(connection)
        for table in schema.METADATA.tables.values():
            known = {
                str(one.name): str(one.sqltext)
                for one in table.constraints
                if isinstance(one, CheckConstraint)
            }
            found = {
                str(one["name"]): one["sqltext"] for one in seen.get_check_constraints(table.name)
            }
            assert found.keys() == known.keys(), table.name
            if connection.dialect.name == "sqlite":  # PostgreSQL writes them in its own way
                assert found == {
                    name: said.replace("True", "TRUE").replace("False", "FALSE")
                    for name, said in known.items()
                }
            assert not [column for column in seen.get_columns(table.name) if column["default"]]


@pytest.mark.parametrize("before", [None, *upgrade.list_versions()])
def test_every_version_becomes_the_newest(url: str, before: str | None) -> None:
    database = opened(url)
    if before is not None:
        with database.writing() as connection:
            upgrade._upgrade(connection, before)
    database.close()
    with Records.open(url) as records:
        fill(records)
        assert records.audit().broken is None
    assert version(url) == upgrade.list_versions()[-1]


def test_a_database_with_records_goes_to_a_later_version_and_keeps_them(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Records.open(url) as records:
        fill(records)
        cycle = records.begin_cycle(start(), key="key")
        head = records.head()
    step(monkeypatch, "next_version")
    with Records.open(url) as records:
        assert records.head() == head
        assert records.begin_cycle(start(), key="key") == cycle
        records.end_cycle(cycle, COMPLETED)
        assert records.audit(head.hash).broken is None
    assert version(url) == "9001"
    kept = copies(url)
    assert len(kept) == (1 if database_module.parse(url).file else 0)
    for copy in kept:
        assert f".{NEWEST}-" in copy.name
        monkeypatch.undo()
        with Records.open(str(copy)) as before:
            assert before.head() == head
            assert before.audit().broken is None


def test_the_newest_version_is_left_alone(url: str) -> None:
    for _ in range(2):
        with Records.open(url) as records:
            assert upgrade.bring_up_to_date(records.database) is None
    assert copies(url) == []


def test_a_step_that_fails_leaves_the_database_as_it_was(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Records.open(url) as records:
        fill(records)
        head = records.head()
    step(monkeypatch, "failing_version")
    with pytest.raises(RecordsError, match="nowhere") as refused:
        Records.open(url)
    assert len(str(refused.value).splitlines()) == 1
    monkeypatch.undo()
    assert version(url) == NEWEST
    with Records.open(url) as records:
        assert records.head() == head
        assert records.audit().broken is None
        with records.database.reading() as connection:
            assert not inspect(connection).has_table("site")
            assert "site" not in {one["name"] for one in inspect(connection).get_columns("machine")}


def test_a_file_that_cannot_be_copied_is_not_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = str(tmp_path / "records.db")
    with Records.open(url) as records:
        fill(records)
    step(monkeypatch, "next_version")
    monkeypatch.setattr(
        private_file, "create", lambda *_: (_ for _ in ()).throw(OSError(28, "full"))
    )
    with pytest.raises(RecordsError, match=r"cannot be copied \(full\); nothing"):
        Records.open(url)
    monkeypatch.undo()
    assert version(url) == NEWEST
    assert {file.name for file in tmp_path.iterdir()} <= {
        "records.db",
        "records.db-lock",
        "records.db-wal",
        "records.db-shm",
    }


@pytest.fixture
def newer(url: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """A database of a newer program, which is none any more."""
    step(monkeypatch, "next_version")
    with Records.open(url) as records:
        fill(records)
    monkeypatch.undo()
    return url


def test_a_database_of_a_newer_program_is_refused_and_left_alone(newer: str) -> None:
    words = r"is of a newer opensuction \(version 9001 of the database; this one knows 0001"
    with pytest.raises(RecordsError, match=words) as refused:
        Records.open(newer)
    assert len(str(refused.value).splitlines()) == 1
    database = audit.open_for_audit(newer)
    with pytest.raises(RecordsError, match=words):
        audit.audit(database)
    database.close()
    assert version(newer) == "9001"


def test_an_older_database_is_not_changed_by_an_audit(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Records.open(url) as records:
        fill(records)
    step(monkeypatch, "next_version")
    database = audit.open_for_audit(url)
    with pytest.raises(RecordsError, match=rf"is of an older opensuction \(version {NEWEST}"):
        audit.audit(database)
    database.close()
    assert version(url) == NEWEST


@pytest.mark.parametrize(
    "statements",
    [
        ["CREATE TABLE patients (name TEXT)"],
        ["CREATE TABLE alembic_version (version_num TEXT)"],
        [
            "CREATE TABLE alembic_version (version_num TEXT)",
            "INSERT INTO alembic_version VALUES ('0001')",
        ],
        [
            "CREATE TABLE alembic_version (version_num TEXT)",
            "INSERT INTO alembic_version VALUES ('0001'), ('0002')",
        ],
    ],
    ids=["tables", "no version", "a version of something else", "two versions"],
)
def test_a_database_of_something_else_is_refused_and_left_alone(
    url: str, statements: list[str]
) -> None:
    where = database_module.parse(url)
    create_file(where)
    database = connect(where, 5.0)
    with database.writing() as connection:
        for statement in statements:
            connection.execute(text(statement))
    before = where.file and where.file.read_bytes()
    with pytest.raises(RecordsError, match="holds something else"):
        Records.open(url)
    assert (where.file and where.file.read_bytes()) == before
    with database.reading() as connection:
        assert not inspect(connection).has_table("audit")
    database.close()


def test_a_server_s_database_must_hold_all_letters(server: str) -> None:
    from sqlalchemy import make_url

    from tests.records.conftest import in_server

    in_server(
        server,
        "CREATE DATABASE narrow TEMPLATE template0 ENCODING 'LATIN1' LC_COLLATE 'C' LC_CTYPE 'C'",
    )
    url = make_url(server).set(database="narrow").render_as_string(hide_password=False)
    try:
        with pytest.raises(RecordsError, match="holds text as LATIN1"):
            Records.open(url)
    finally:
        in_server(server, "DROP DATABASE narrow WITH (FORCE)")


@pytest.mark.parametrize("umask", [0o000, 0o077], ids=oct)
def test_records_are_their_user_s_alone_whatever_the_umask(tmp_path: Path, umask: int) -> None:
    file = tmp_path / "kept" / "records.db"
    before = os.umask(umask)
    try:
        with Records.open(str(file)) as records:
            fill(records, 1)
            made = {one.name: stat.S_IMODE(one.stat().st_mode) for one in file.parent.iterdir()}
    finally:
        os.umask(before)
    assert set(made) >= {"records.db", "records.db-wal", "records.db-shm", "records.db-lock"}
    assert set(made.values()) == {0o600}, made
    assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700


def test_a_link_that_leads_nowhere_makes_no_file_there(tmp_path: Path) -> None:
    (tmp_path / "records.db").symlink_to(tmp_path / "theirs")
    with pytest.raises(RecordsError, match="cannot be made"):
        Records.open(str(tmp_path / "records.db"))
    assert not (tmp_path / "theirs").exists()


def test_a_folder_with_any_letters_in_its_name_will_do(tmp_path: Path) -> None:
    file = tmp_path / "50 % of it?#&é" / "records.db"
    with Records.open(str(file)) as records:
        fill(records, 1)
    connection = sqlite3.connect(file)
    assert connection.execute("SELECT count(*) FROM cycle").fetchone() == (1,)
    connection.close()
    assert file.stat().st_mode & 0o077 == 0, "nobody else may read it"


def test_versions_are_in_the_order_in_which_alembic_takes_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    step(monkeypatch, "next_version")
    scripts = ScriptDirectory.from_config(upgrade._configure(upgrade.STEPS))
    assert upgrade.list_versions() == [one.revision for one in scripts.walk_revisions()][::-1]
