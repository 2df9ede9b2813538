"""The list of proofs: what the page `docs/safety/proof.md` shows, row by row."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

Test = TypeVar("Test", bound=Callable[..., Any])


class Proof(NamedTuple):
    """A row."""

    number: str
    claim: str
    of: str
    """Functions whose source is run."""
    numbers: str
    """How numbers are taken, and which of them are free."""


PROOFS: dict[str, Proof] = {}


def proves(number: str, claim: str, of: str, numbers: str) -> Callable[[Test], Test]:
    """Mark a test as the proof of a claim. Raises ValueError for a number that another has."""
    row = Proof(number, claim, of, numbers)
    if PROOFS.setdefault(number, row) != row:
        raise ValueError(f"{number} is proved twice")

    def keep(test: Test) -> Test:
        return test

    return keep
