"""Both kinds of database, each test with a fresh one."""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import uuid4

import psycopg
import pytest
from sqlalchemy import create_engine, make_url, text

from opensuction.records.records import Records
from tests.records import postgresql_cluster

KINDS = ("sqlite", pytest.param("postgresql", marks=pytest.mark.sweep))
on_both = pytest.mark.parametrize("url", ["sqlite", "postgresql"], indirect=True)
"""Where the two kinds differ: locks, triggers, what is made and read. `.ci/run` has all on both."""

SELDOM_ON_BOTH = ("sqlite", pytest.param("postgresql", marks=pytest.mark.soak))
"""Of long tests: the statements are the same, and shorter tests carry them out on both."""
seldom_on_both = pytest.mark.parametrize("url", SELDOM_ON_BOTH, indirect=True)


@pytest.fixture(scope="session")
def server(component: Callable[[str], Path]) -> Iterator[str]:
    """URL of a PostgreSQL server; skips, or fails, where none can be had."""
    given = os.environ.get(postgresql_cluster.VARIABLE)
    if given:
        yield given
        return
    programs = postgresql_cluster.find_programs() or component("postgresql").parent
    with postgresql_cluster.running(programs) as url:
        yield url


def in_server(server: str, command: str) -> None:
    """Carry out a command of the server's keeper."""
    with _keeping(server) as carry_out:
        carry_out(command)


@contextmanager
def _keeping(server: str) -> Iterator[Callable[[str], None]]:
    """Carries out commands of the server's keeper, all by one connection."""
    engine = create_engine(
        make_url(server).set(drivername="postgresql+psycopg"), isolation_level="AUTOCOMMIT"
    )
    with engine.connect() as connection:

        def carry_out(command: str) -> None:
            connection.execute(text(command))

        yield carry_out
    engine.dispose()


@pytest.fixture(scope="session")
def keeper(server: str) -> Iterator[Callable[[str], None]]:
    with _keeping(server) as carry_out:
        yield carry_out


class NewDatabases:
    """Makes databases of a server that vanish with it; each a copy of a template."""

    def __init__(self, server: str, keeper: Callable[[str], None]) -> None:
        self._server, self._keeper = server, keeper
        self._names: list[str] = []

    def __call__(self, template: str = "template0") -> str:
        """The URL of one more."""
        self._names.append(f"records_{uuid4().hex}")
        self._keeper(f"CREATE DATABASE {self._names[-1]} TEMPLATE {template} ENCODING 'UTF8'")
        found = make_url(self._server).set(database=self._names[-1])
        return found.render_as_string(hide_password=False)

    def drop(self) -> None:
        for name in self._names:
            self._keeper(f"DROP DATABASE {name} WITH (FORCE)")


TABLES = (
    "SELECT relname FROM pg_class WHERE relnamespace = 'public'::regnamespace AND relkind = 'r'"
)
CATALOG = """
    SELECT md5(string_agg(line, ',' ORDER BY line)) FROM (
        SELECT concat_ws(' ', relname, relkind, relowner, relacl, reloptions) FROM pg_class
            WHERE relnamespace = 'public'::regnamespace
        UNION ALL SELECT concat_ws(' ', attrelid::regclass, attname, atttypid, attnotnull, attacl)
            FROM pg_attribute JOIN pg_class ON attrelid = pg_class.oid AND relkind = 'r'
            WHERE relnamespace = 'public'::regnamespace AND attnum > 0
        UNION ALL SELECT concat_ws(' ', conname, convalidated, pg_get_constraintdef(oid))
            FROM pg_constraint
        UNION ALL SELECT concat_ws(' ', tgenabled, pg_get_triggerdef(oid)) FROM pg_trigger
        UNION ALL SELECT pg_get_indexdef(indexrelid) FROM pg_index WHERE indrelid > 16383
        UNION ALL SELECT concat_ws(' ', proname, proacl, prosrc) FROM pg_proc WHERE oid > 16383
        UNION ALL SELECT ev_class::regclass || pg_get_ruledef(oid) FROM pg_rewrite
            WHERE oid > 16383
        UNION ALL SELECT concat_ws(' ', nspname, nspacl) FROM pg_namespace
            WHERE nspname !~ '^pg_(temp|toast)'
        UNION ALL SELECT concat_ws(' ', datacl, datconnlimit, setconfig) FROM pg_database
            LEFT JOIN pg_db_role_setting ON setdatabase = oid WHERE datname = current_database()
    ) AS lines (line)
"""
"""What is made in a database, apart from its rows; the system's own begins at 16384."""
ALONE = """
    SELECT pg_terminate_backend(pid) FROM pg_stat_activity
    WHERE datname = current_database() AND pid <> pg_backend_pid()
"""


class ReusedDatabases:
    """Copies of a template, emptied after a test for the next one.

    To make one takes the server ten times as long, and a thousand files. One in which a test
    changed more than rows is not used again.
    """

    def __init__(self, make: NewDatabases, template: str) -> None:
        self._make, self._template = make, template
        self._free: list[str] = []
        self._catalog: object = None
        self._rows: dict[str, list[bytes]] = {}

    def take(self) -> str:
        """The URL of one that is as the template."""
        if self._free:
            return self._free.pop()
        url = self._make(self._template)
        if self._catalog is None:
            with _transaction(url) as cursor:
                self._catalog = cursor.execute(CATALOG).fetchone()
                for (table,) in cursor.execute(TABLES).fetchall():
                    with cursor.copy(f"COPY {table} TO STDOUT") as rows:
                        self._rows[table] = [bytes(row) for row in rows]
        return url

    def give_back(self, url: str) -> None:
        """Make one that was taken as the template again, if only rows differ."""
        with _transaction(url) as cursor:
            cursor.execute(ALONE)
            if cursor.execute(CATALOG).fetchone() != self._catalog:
                return
            cursor.execute("SET LOCAL session_replication_role = replica")  # no triggers
            for table, rows in self._rows.items():
                cursor.execute(f"DELETE FROM {table}")  # TRUNCATE makes each table's files anew
                if rows:
                    with cursor.copy(f"COPY {table} FROM STDIN") as copy:
                        for row in rows:
                            copy.write(row)
        self._free.append(url)


@contextmanager
def _transaction(url: str) -> Iterator[psycopg.Cursor[Any]]:
    """Statements in a database, by the server's keeper."""
    with psycopg.connect(url) as connection, connection.cursor() as cursor:
        yield cursor


@pytest.fixture(scope="session")
def postgresql_template(server: str, keeper: Callable[[str], None]) -> Iterator[str]:
    """Name of a database as the program makes one: a copy takes a third of the time."""
    databases = NewDatabases(server, keeper)
    url = databases()
    Records.open(url).close()
    yield str(make_url(url).database)
    databases.drop()


@pytest.fixture(scope="module")
def copies(server: str, keeper: Callable[[str], None]) -> Iterator[NewDatabases]:
    """For databases of which the tests of a file take copies."""
    databases = NewDatabases(server, keeper)
    yield databases
    databases.drop()


@pytest.fixture
def new_databases(server: str, keeper: Callable[[str], None]) -> Iterator[NewDatabases]:
    databases = NewDatabases(server, keeper)
    yield databases
    databases.drop()


@pytest.fixture(scope="session")
def reused_databases(
    server: str, keeper: Callable[[str], None], postgresql_template: str
) -> Iterator[ReusedDatabases]:
    databases = NewDatabases(server, keeper)
    yield ReusedDatabases(databases, postgresql_template)
    databases.drop()


@pytest.fixture
def new_postgresql_url(reused_databases: ReusedDatabases) -> Iterator[Callable[[], str]]:
    """Gives databases as the program makes them, which are the test's alone."""
    taken: list[str] = []

    def take() -> str:
        taken.append(reused_databases.take())
        return taken[-1]

    yield take
    for url in taken:
        reused_databases.give_back(url)


@pytest.fixture
def postgresql_url(new_postgresql_url: Callable[[], str]) -> str:
    return new_postgresql_url()


@pytest.fixture(scope="session")
def sqlite_template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database as the program makes one."""
    file = tmp_path_factory.mktemp("template") / "records.db"
    Records.open(str(file)).close()
    return file


@pytest.fixture(params=KINDS)
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Of a database as the program makes one."""
    if request.param == "sqlite":
        made = shutil.copy(request.getfixturevalue("sqlite_template"), tmp_path / "records.db")
        return str(made)
    found: str = request.getfixturevalue("postgresql_url")
    return found


@pytest.fixture(params=("sqlite", "postgresql"))
def empty_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Of a database that is empty."""
    if request.param == "sqlite":
        return str(tmp_path / "records.db")
    found: str = request.getfixturevalue("new_databases")()
    return found
