"""Accounts in a fresh database of either kind, with passwords that cost little."""

from collections.abc import Iterator

import pytest

from opensuction.accounts.accounts import Accounts
from opensuction.records.records import Records
from tests.accounts.example import CHEAP, Clock
from tests.records.conftest import (
    keeper,
    new_databases,
    new_postgresql_url,
    postgresql_template,
    postgresql_url,
    reused_databases,
    server,
    sqlite_template,
    url,
)

__all__ = [
    "keeper",
    "new_databases",
    "new_postgresql_url",
    "postgresql_template",
    "postgresql_url",
    "reused_databases",
    "server",
    "sqlite_template",
    "url",
]


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def records(url: str, clock: Clock) -> Iterator[Records]:
    with Records.open(url, clock=clock) as opened:
        yield opened


@pytest.fixture
def accounts(records: Records, clock: Clock) -> Accounts:
    return Accounts(records.database, clock, CHEAP)
