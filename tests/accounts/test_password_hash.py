"""Hashes of passwords, as whoever signs in depends on them."""

import threading
import time
from collections.abc import Callable

import argon2
import pytest
from argon2.exceptions import HashingError

from opensuction.accounts.site import COST, BusyError, Cost, PasswordHasher
from tests.accounts.example import CHEAP

PASSWORD = "velvet tractor hums quietly"


def test_a_password_matches_its_hash_and_no_other_does() -> None:
    made = CHEAP.make(PASSWORD)
    assert CHEAP.matches(made, PASSWORD)
    for wrong in ("", PASSWORD[:-1], f"{PASSWORD} ", PASSWORD.upper(), "\ud800", "\0" * 2000):
        assert not CHEAP.matches(made, wrong)
    assert CHEAP.make(PASSWORD) != made, "each has a salt of its own"


def test_it_is_argon2id_at_the_cost_that_is_stated() -> None:
    made = PasswordHasher().make(PASSWORD)
    assert made.startswith(f"$argon2id$v=19$m={COST.memory_kib},t={COST.passes},p=1$")
    argon2.PasswordHasher().verify(made, PASSWORD)
    assert not PasswordHasher().is_outdated(made)
    assert PasswordHasher().is_outdated(CHEAP.make(PASSWORD))


def test_a_password_that_nobody_has_is_compared_like_any_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen = []
    hasher = PasswordHasher(Cost(1, 64, 1))
    verify = argon2.PasswordHasher.verify

    def watch(one: argon2.PasswordHasher, made: str, tried: bytes) -> bool:
        seen.append(argon2.extract_parameters(made))
        return verify(one, made, tried)

    monkeypatch.setattr(argon2.PasswordHasher, "verify", watch)
    made = hasher.make(PASSWORD)
    assert not hasher.matches(None, PASSWORD)
    assert not hasher.matches(made, "wrong")
    assert len(seen) == 2
    assert seen[0] == seen[1], "at the same cost"


def raising(error: BaseException) -> Callable[..., bool]:
    def fail(*_: object) -> bool:
        raise error

    return fail


@pytest.mark.parametrize("error", [HashingError("no memory"), MemoryError()])
def test_a_failure_within_is_no_wrong_password(
    monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    hasher = PasswordHasher(Cost(1, 8, 1))
    made = hasher.make(PASSWORD)
    monkeypatch.setattr(argon2.PasswordHasher, "verify", raising(error))
    with pytest.raises(BusyError, match="could not be looked at"):
        hasher.matches(made, PASSWORD)
    monkeypatch.undo()
    assert hasher.matches(made, PASSWORD), "and the turn was given back"


def test_a_damaged_hash_is_a_failure() -> None:
    with pytest.raises(BusyError, match="could not be looked at"):
        CHEAP.matches("$argon2id$damaged", PASSWORD)


def test_more_than_two_at_once_wait_and_then_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    hasher = PasswordHasher(Cost(1, 8, 1), longest_wait_s=0.01)
    made = hasher.make(PASSWORD)
    inside, go_on = threading.Semaphore(0), threading.Event()

    def wait(*_: object) -> bool:
        inside.release()
        return go_on.wait(60.0)

    monkeypatch.setattr(argon2.PasswordHasher, "verify", wait)
    threads = [threading.Thread(target=hasher.matches, args=(made, PASSWORD)) for _ in range(2)]
    for thread in threads:
        thread.start()
        assert inside.acquire(timeout=60.0)
    begun = time.monotonic()
    with pytest.raises(BusyError, match="too many people sign in at once"):
        hasher.matches(made, PASSWORD)
    assert time.monotonic() - begun < 30.0
    go_on.set()
    for thread in threads:
        thread.join()
    monkeypatch.undo()
    assert hasher.matches(made, PASSWORD)
