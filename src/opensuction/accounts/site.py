"""The accounts' database, changed by transactions: each change with its entry in the trail.

Hashes of passwords: Argon2id. As slow for a name that nobody has as for any other.

Refusals of the accounts: one plain line each, with nothing in it that helps somebody guess.
"""

import math
import secrets
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import NamedTuple

import argon2
from argon2.exceptions import Argon2Error, InvalidHashError, VerifyMismatchError

from opensuction.accounts.rule import password as password_rule
from opensuction.kernel.errors import InputError
from opensuction.records import entry
from opensuction.records.account_rows import AccountRows
from opensuction.records.database.database import Database
from opensuction.records.entry import Action
from opensuction.records.records import Clock
from opensuction.records.request import Request, act

WRONG = "name or password is wrong"
"""Whichever it is, and where the account was deactivated."""
OVER = (
    "this one-time password is over, for it signs in once, within 24 hours: an administrator makes "
    "another one, on the page or by 'opensuction users reset-password NAME'"
)
"""Said only to who knows it."""


class RefusedError(InputError):
    """A person may not do this, or not now."""


class WrongPasswordError(RefusedError):
    """Signing in failed."""

    def __init__(self, why: str = WRONG) -> None:
        super().__init__(why)


class PasswordOverError(WrongPasswordError):
    """The one-time password is the right one, and has signed in already, or its time is over."""

    def __init__(self) -> None:
        super().__init__(OVER)


class WaitError(RefusedError):
    """Too many sign-ins failed; nothing was looked at."""

    def __init__(self, wait_s: float) -> None:
        self.wait_s = math.ceil(wait_s)
        super().__init__(
            f"too many sign-ins failed: try again in {self.wait_s} s; nobody needs to sign in to "
            "stop the machine"
        )


class BusyError(RefusedError):
    """Too many passwords are being looked at, or there is no memory for it."""


class NotSignedInError(RefusedError):
    """The session is unknown or has ended, or the token is."""


class NotAllowedError(RefusedError):
    """Signed in, but without the right."""


class Cost(NamedTuple):
    """Cost of a password hash."""

    passes: int = 2
    memory_kib: int = 19_456
    """Source: [OWASP-Passwords], the least that is advised: a loop at 1 kHz runs beside it."""
    lanes: int = 1
    """No thread of its own: the loop has a core to itself, and threads may not be had."""


COST = Cost()
AT_ONCE = 2
"""Hashes that are made at the same time; more wait."""
LONGEST_WAIT_S = 10.0


class PasswordHasher:
    """Makes and compares hashes; may be used by several threads."""

    def __init__(self, cost: Cost = COST, longest_wait_s: float = LONGEST_WAIT_S) -> None:
        self._hasher = argon2.PasswordHasher(
            time_cost=cost.passes, memory_cost=cost.memory_kib, parallelism=cost.lanes
        )
        self._longest_wait_s = longest_wait_s
        self._turns = threading.BoundedSemaphore(AT_ONCE)
        self._of_nobody = self._hasher.hash(secrets.token_bytes(16))

    def make(self, password: str) -> str:
        """The hash of a password, with a salt of its own. Raises BusyError."""
        with self._turn():
            return self._hasher.hash(_to_bytes(password))

    def matches(self, password_hash: str | None, password: str) -> bool:
        """True for the right password; a missing hash takes as long to refuse as a wrong password.

        Raises BusyError where that could not be found out.
        """
        with self._turn():
            try:
                self._hasher.verify(password_hash or self._of_nobody, _to_bytes(password))
            except VerifyMismatchError:
                return False
        return password_hash is not None

    def is_outdated(self, password_hash: str) -> bool:
        """True for a hash that was made at another cost than today's."""
        return self._hasher.check_needs_rehash(password_hash)

    @contextmanager
    def _turn(self) -> Iterator[None]:
        if not self._turns.acquire(timeout=self._longest_wait_s):
            raise BusyError("too many people sign in at once; try again")
        try:
            yield
        except (Argon2Error, InvalidHashError, MemoryError) as failed:
            raise BusyError(f"the password could not be looked at ({failed}); try again") from None
        finally:
            self._turns.release()


def _to_bytes(password: str) -> bytes:
    # Half a character, as a wrongly decoded form has, is a wrong password and no failure.
    return password_rule.normalise(password).encode("utf-8", "surrogatepass")


class AccountChange:
    """One transaction that changes accounts; whoever else writes waits until it has ended."""

    def __init__(self, request: Request) -> None:
        self.request = request
        self.rows = AccountRows(request.connection)
        self.now = request.at

    def note(self, done_by: str, what: str, detail: str = "") -> str:
        """Put on record who did what; returns the action's id."""
        action = Action(done_by, what, detail)
        entry.check_action(action)
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
