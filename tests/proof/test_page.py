"""The page says what is proved, no more and no less."""

from pathlib import Path

import pytest

from tests.proof import (  # noqa: F401 - each fills the table
    test_narrowing,
    test_number,
    test_transition,
    test_way_out,
)
from tests.proof.table import PROOFS, Proof

PAGE = Path(__file__).resolve().parents[2] / "docs" / "safety" / "proof.md"
HEAD = "| | proved | run are | numbers |\n|---|---|---|---|\n"


def rows_of(page: str) -> list[str]:
    assert page.count(HEAD) == 1
    table = page.split(HEAD)[1].split("\n\n", maxsplit=1)[0]
    return table.splitlines()


def ordered() -> list[Proof]:
    """The proofs in the order of the claims, whatever ran first."""
    return sorted(
        PROOFS.values(), key=lambda one: ("NFTW".index(one.number[0]), len(one.number), one.number)
    )


def row(proof: Proof) -> str:
    return f"| {proof.number} | {proof.claim} | {proof.of} | {proof.numbers} |"


def test_the_page_shows_the_list_of_proofs() -> None:
    assert rows_of(PAGE.read_text("utf-8")) == [row(proof) for proof in ordered()]


@pytest.mark.parametrize("kind", ["N", "F", "T", "W"])
def test_every_claim_has_its_proofs(kind: str) -> None:
    assert len([number for number in PROOFS if number.startswith(kind)]) > 4
