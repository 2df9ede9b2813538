"""Hashes of passwords: Argon2id. As slow for a name that nobody has as for any other."""

import secrets
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import argon2
from argon2.exceptions import Argon2Error, InvalidHashError, VerifyMismatchError

from opensuction.accounts.refusal import BusyError
from opensuction.accounts.rule import password as password_rule


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
