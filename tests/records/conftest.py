"""Both kinds of database, each test with a fresh one."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from uuid import uuid4

import pytest
from sqlalchemy import create_engine, make_url, text

from tests.records import postgresql_cluster

KINDS = ("sqlite", "postgresql")


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
    engine = create_engine(
        make_url(server).set(drivername="postgresql+psycopg"), isolation_level="AUTOCOMMIT"
    )
    with engine.connect() as connection:
        connection.execute(text(command))
    engine.dispose()


@pytest.fixture
def new_postgresql_url(server: str) -> Iterator[Callable[[], str]]:
    """Makes databases that vanish after the test."""
    names = []

    def make() -> str:
        names.append(f"records_{uuid4().hex}")
        in_server(server, f"CREATE DATABASE {names[-1]} TEMPLATE template0 ENCODING 'UTF8'")
        return make_url(server).set(database=names[-1]).render_as_string(hide_password=False)

    yield make
    for name in names:
        in_server(server, f"DROP DATABASE {name} WITH (FORCE)")


@pytest.fixture
def postgresql_url(new_postgresql_url: Callable[[], str]) -> str:
    return new_postgresql_url()


@pytest.fixture(params=KINDS)
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Of a database that is empty."""
    if request.param == "sqlite":
        return str(tmp_path / "records.db")
    found: str = request.getfixturevalue("postgresql_url")
    return found
