"""Whoever changes the records behind the guards of the database is found."""

import contextlib
import json
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import Column, Connection, make_url, select, text

from opensuction.kernel.errors import InputError
from opensuction.records.database import schema
from opensuction.records.entry import to_hash
from opensuction.records.records import Records
from opensuction.records.trail import chain
from opensuction.records.trail.chain import BEGINNING, to_canonical
from tests.cli.command import opensuction
from tests.records import recorded
from tests.records.conftest import KINDS, NewDatabases, ReusedDatabases, on_both
from tests.records.example import (
    COMPLETED,
    MACHINE,
    Clock,
    EnoughError,
    check_after,
    fill,
    fill_accounts,
    start,
    unguarded,
)

on_sqlite = pytest.mark.parametrize("url", ["sqlite"], indirect=True)
EVERY = (*schema.KEPT, schema.audit_head)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    (folder / recorded.name_of(1)).write_bytes(b"no more than a hash is asked of it")
    return folder


def fill_all(url: str, recordings: Path) -> None:
    with Records.open(url, clock=Clock()) as records:
        fill(records)
        path = recordings / recorded.name_of(1)
        records.bind_recording(MACHINE, recorded.bound(path, 1))
        fill_accounts(records)


@pytest.fixture(scope="module")
def filled_file(
    recordings: Path, sqlite_template: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    file = shutil.copy(sqlite_template, tmp_path_factory.mktemp("filled") / "records.db")
    fill_all(str(file), recordings)
    return Path(file)


@pytest.fixture(scope="module")
def filled_databases(
    recordings: Path, copies: NewDatabases, postgresql_template: str
) -> ReusedDatabases:
    url = copies(postgresql_template)
    fill_all(url, recordings)
    return ReusedDatabases(copies, str(make_url(url).database))


@pytest.fixture(params=KINDS)
def url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Of a database that is filled, a copy for each test."""
    if request.param == "sqlite":
        yield str(shutil.copy(request.getfixturevalue("filled_file"), tmp_path / "records.db"))
        return
    databases: ReusedDatabases = request.getfixturevalue("filled_databases")
    found = databases.take()
    yield found
    databases.give_back(found)


@pytest.fixture
def filled(url: str) -> Iterator[Records]:
    with Records.open(url, clock=Clock()) as records:
        yield records


def run(connection: Connection, statement: str) -> None:
    connection.exec_driver_sql(statement)


def test_an_empty_trail_is_whole(empty_url: str) -> None:
    with Records.open(empty_url) as records:
        report = records.audit()
    assert (report.entries, report.last_hash, report.broken) == (0, BEGINNING, None)


@on_both
def test_what_was_stored_as_meant_is_whole(filled: Records) -> None:
    report = filled.audit()
    assert report.broken is None
    assert (report.entries, report.last_hash) == filled.head()


def test_an_entry_can_be_checked_with_any_other_program(filled: Records) -> None:
    with filled.database.reading() as connection:
        rows = connection.execute(select(schema.audit).order_by(schema.audit.c.sequence)).all()
    previous = "0" * 64
    for row in rows:
        assert to_hash(row.entry) == row.hash
        entry = json.loads(row.entry)
        assert entry["previous"] == previous
        assert entry["at"].endswith("Z")
        previous = row.hash


HANDS: dict[str, tuple[str, str]] = {
    "an entry's text": ("UPDATE audit SET entry = entry || ' ' WHERE sequence = 4", "entry 4 was"),
    "an entry's hash": (
        f"UPDATE audit SET hash = '{'a' * 64}' WHERE sequence = 4",
        "entry 4 was changed",
    ),
    "an entry's predecessor": (
        f"UPDATE audit SET previous = '{'a' * 64}' WHERE sequence = 4",
        "entry 4 does not follow entry 3",
    ),
    "an entry taken out": ("DELETE FROM audit WHERE sequence = 4", "entry 4 is missing"),
    "the first entry taken out": ("DELETE FROM audit WHERE sequence = 1", "entry 1 is missing"),
    "the end cut off": ("DELETE FROM audit WHERE sequence > 9", "the trail ends with entry 9"),
    "all of it": ("DELETE FROM audit", "the trail ends with entry 0"),
    "the head": ("UPDATE audit_head SET sequence = 3", "its head says 3"),
    "the head taken away": ("DELETE FROM audit_head", "cannot be read"),
    "a row's value": (
        "UPDATE cycle_end SET outcome = 'aborted'",
        "was changed: its outcome is not what it was",
    ),
    "a row's time": (
        "UPDATE cycle SET started_at = '2026-11-23 11:00:00' WHERE number = 2",
        "was changed: its started_at is not what it was",
    ),
    "a row's empty value": ("UPDATE cycle_end SET inside_at_end = NULL", "its inside_at_end is"),
    "a row taken out": ("DELETE FROM alarm", "is missing"),
    "a row added": (
        "INSERT INTO patient SELECT 'P-2', known_since FROM patient",
        "'patient' has 2 rows, the trail tells of 1",
    ),
    "a file's content": (
        "UPDATE protocol SET content = 'depth_mm = 99'",
        "its content is not what it was",
    ),
}


@on_sqlite
@pytest.mark.parametrize("hand", HANDS)
def test_what_is_changed_is_named(filled: Records, hand: str) -> None:
    statement, words = HANDS[hand]
    with unguarded(filled) as connection:
        run(connection, statement)
    report = filled.audit()
    assert report.broken is not None
    assert words in report.broken
    assert len(report.broken.splitlines()) == 1


def test_two_entries_in_each_other_s_place_are_found(filled: Records) -> None:
    with unguarded(filled) as connection:
        for before, after in ((4, 1004), (5, 4), (1004, 5)):
            run(connection, f"UPDATE audit SET sequence = {after} WHERE sequence = {before}")
    report = filled.audit()
    assert (report.broken_at, report.entries) == (4, 4)
    assert "entry 4 does not follow entry 3" in str(report.broken)


def test_an_entry_put_in_between_is_found(filled: Records) -> None:
    with unguarded(filled) as connection:
        end = filled.head().sequence
        for number in range(end, 4, -1):
            run(connection, f"UPDATE audit SET sequence = {number + 1} WHERE sequence = {number}")
        third = connection.execute(text("SELECT hash FROM audit WHERE sequence = 4")).scalar_one()
        entry = to_canonical(
            {
                "at": "2026-11-23T12:00:00.000000Z",
                "previous": third,
                "row": {"pseudonym": "P-2", "known_since": "2026-11-23T12:00:00.000000Z"},
                "sequence": 5,
                "table": "patient",
            }
        )
        row = {"sequence": 5, "previous": "b" * 64, "hash": to_hash(entry), "entry": entry}
        connection.execute(schema.audit.insert().values(**row))
    report = filled.audit()
    assert report.broken_at == 5


def cut(records: Records, after: int) -> None:
    """Cut the end off, with its rows, and put the head where it is then."""
    with unguarded(records) as connection:
        gone = connection.execute(
            select(schema.audit.c.entry).where(schema.audit.c.sequence > after)
        ).scalars()
        for entry in map(json.loads, list(gone)):
            table = schema.METADATA.tables[entry["table"]]
            (key,) = table.primary_key.columns
            connection.execute(table.delete().where(key == entry["row"][key.name]))
        run(connection, f"DELETE FROM audit WHERE sequence > {after}")
        run(connection, f"UPDATE audit_head SET sequence = {after}")
        run(
            connection,
            "UPDATE audit_head SET hash = "
            f"(SELECT hash FROM audit WHERE sequence = {after}) WHERE id = 1",
        )


def test_an_end_cut_off_with_its_head_is_found_by_a_head_that_was_noted(filled: Records) -> None:
    noted = filled.head()
    cut(filled, 12)
    assert filled.audit().broken is None, "within the database nothing can tell"
    report = filled.audit(noted.hash)
    assert "no entry has the expected hash" in str(report.broken)


def test_a_head_that_was_noted_is_found_in_a_trail_that_went_on(filled: Records) -> None:
    noted = filled.head()
    filled.end_cycle(filled.begin_cycle(start()), COMPLETED)
    assert filled.audit(noted.hash).broken is None
    assert filled.audit(BEGINNING).broken is None


def test_a_head_that_is_no_hash_is_refused(filled: Records) -> None:
    with pytest.raises(InputError, match="the expected head 'abc' is no SHA-256"):
        filled.audit("abc")


def test_a_guard_that_is_gone_is_found(filled: Records) -> None:
    with filled.database.writing() as connection:
        if connection.dialect.name == "sqlite":
            run(connection, "DROP TRIGGER alarm_no_delete")
        else:
            run(connection, "ALTER TABLE alarm DISABLE TRIGGER alarm_kept")
    assert "the trigger 'alarm_" in str(filled.audit().broken)


FORGED: dict[str, Callable[[dict[str, Any]], str]] = {
    "no JSON": lambda _: "{",
    "no object": lambda _: "[]",
    "deeply nested": lambda _: "[" * 100_000,
    "spaces": lambda entry: json.dumps(entry, sort_keys=True),
    "a key more": lambda entry: to_canonical({**entry, "by": "me"}),
    "another number": lambda entry: to_canonical({**entry, "sequence": 7}),
    "another table": lambda entry: to_canonical({**entry, "table": "audit_head"}),
    "no row": lambda entry: to_canonical({**entry, "row": []}),
    "a column less": lambda entry: to_canonical(
        {**entry, "row": {name: entry["row"][name] for name in entry["row"] if name != "scope"}}
    ),
    "a column more": lambda entry: to_canonical({**entry, "row": {**entry["row"], "by": "me"}}),
    "a row without its key": lambda entry: to_canonical({**entry, "row": {}}),
    "a key that is a list": lambda entry: to_canonical({**entry, "row": {"key": [], "id": {}}}),
    "a number that is none": lambda entry: to_canonical({**entry, "sequence": float("nan")}),
}


def forge(connection: Connection, kind: str) -> None:
    """Put the last entry into another form, with a hash that fits it."""
    last = chain.read_head(connection).sequence
    where = schema.audit.c.sequence == last
    entry = json.loads(connection.execute(select(schema.audit.c.entry).where(where)).scalar_one())
    content = FORGED[kind](entry)
    digest = to_hash(content)
    connection.execute(schema.audit.update().where(where).values(entry=content, hash=digest))
    run(connection, f"UPDATE audit_head SET hash = '{digest}'")


@on_sqlite
@pytest.mark.parametrize("kind", FORGED)
def test_an_entry_in_another_form_is_found(filled: Records, kind: str) -> None:
    with unguarded(filled) as connection:
        forge(connection, kind)
    report = filled.audit()
    assert report.broken is not None
    assert len(report.broken) < 300


@pytest.mark.sweep
@pytest.mark.parametrize("url", ["postgresql"], indirect=True)
def test_the_same_is_found_in_a_server_s_database(filled: Records) -> None:
    for statement, words in HANDS.values():
        assert words in str(check_after(filled, statement)), statement
    for kind in FORGED:
        assert check_after(filled, partial(forge, kind=kind)) is not None, kind
    assert filled.audit().broken is None


def test_what_no_type_holds_is_found(tmp_path: Path) -> None:
    """SQLite keeps any value in any column."""
    with Records.open(str(tmp_path / "records.db")) as records:
        fill(records, 1)
        for statement in (
            "UPDATE cycle SET started_at = 'yesterday'",
            "UPDATE cycle SET started_at = 7",
            "UPDATE cycle SET number = 1.5",
            "UPDATE audit SET entry = x'ff00' WHERE sequence = 1",
            "UPDATE protocol SET content = x'00'",
        ):
            assert check_after(records, statement) is not None, statement
        assert records.audit().broken is None


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    column=st.sampled_from([column for table in EVERY for column in table.columns]),
    which=st.integers(0, 100),
    said=st.one_of(st.text("a\u00e9 0", max_size=5), st.integers(-3, 3), st.booleans(), st.none()),
)
@on_both
def test_any_change_behind_the_triggers_is_found(
    filled: Records, column: Column[Any], which: int, said: str | float | None
) -> None:
    table, name = column.table.name, column.name
    (key,) = column.table.primary_key.columns
    one = f"SELECT {name} FROM {table} WHERE {key.name} = :key"
    with (
        contextlib.suppress(InputError, EnoughError),  # or it is none of the column's type
        unguarded(filled) as connection,
    ):
        keys = connection.execute(select(key).order_by(key)).scalars().all()
        row = {"key": keys[which % len(keys)]}
        before = connection.execute(text(one), row).scalar_one()
        change = f"UPDATE {table} SET {name} = :said WHERE {key.name} = :key"
        connection.execute(text(change), {**row, "said": said})
        after = connection.execute(text(one), row).scalars().all()
        is_same = [(type(value), value) for value in after] == [(type(before), before)]
        report = chain.check(connection, frozenset())
        assert (report.broken is None) == is_same
        raise EnoughError


def test_the_command_audits_a_server_s_database(
    tmp_path: Path, postgresql_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Records.open(postgresql_url) as records:
        fill(records, 1)
    monkeypatch.setenv("OPENSUCTION_DATABASE", postgresql_url)
    ran = opensuction("audit", cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert ": OK: 10 entries" in ran.stdout
    assert "postgresql://tester@" in ran.stdout, "and no password"
