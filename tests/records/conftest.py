"""Both kinds of database, each test with a fresh one."""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

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


@pytest.fixture
def new_postgresql_url(new_databases: NewDatabases, postgresql_template: str) -> Callable[[], str]:
    """Makes databases, as the program makes them, that vanish after the test."""
    return lambda: new_databases(postgresql_template)


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
