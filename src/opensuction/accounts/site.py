"""The accounts' database, changed by transactions: each change with its entry in the trail."""

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import NamedTuple

from opensuction.accounts.password_hash import PasswordHasher
from opensuction.records import entry_check
from opensuction.records.account_rows import AccountRows
from opensuction.records.database.database import Database
from opensuction.records.entry import Action
from opensuction.records.records import Clock
from opensuction.records.request import Request, act


class AccountChange:
    """One transaction that changes accounts; whoever else writes waits until it has ended."""

    def __init__(self, request: Request) -> None:
        self.request = request
        self.rows = AccountRows(request.connection)
        self.now = request.at

    def note(self, done_by: str, what: str, detail: str = "") -> str:
        """Put on record who did what; returns the action's id."""
        action = Action(done_by, what, detail)
        entry_check.check_action(action)
        return act(self.request, action)


class AccountStore(NamedTuple):
    """The accounts of one database."""

    database: Database
    clock: Clock
    hasher: PasswordHasher

    def now(self) -> datetime:
        """By the computer's clock."""
        return self.clock()

    @contextmanager
    def changing(self) -> Iterator[AccountChange]:
        """A transaction that is stored whole or not at all. Raises RecordsError."""
        with self.database.writing() as connection:
            now = self.clock()
            yield AccountChange(Request(connection, now, now))

    @contextmanager
    def reading(self) -> Iterator[AccountRows]:
        """A transaction that only reads, and waits for nobody. Raises RecordsError."""
        with self.database.reading() as connection:
            yield AccountRows(connection)
