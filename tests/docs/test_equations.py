"""Code and tests that `docs/reference/equations.md` names for an equation exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "opensuction"
PAGE = ROOT / "docs" / "reference" / "equations.md"


def rows() -> list[list[str]]:
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    cells = [line.strip("| ").split(" | ") for line in lines if line.startswith("| ")]
    return [row for row in cells if len(row) == 4 and row[2] != "code"]


def module_of(words: list[str]) -> tuple[Path, list[str]] | None:
    """The module that a dotted name begins with, and what is left of the name."""
    for length in range(len(words), 0, -1):
        place = PACKAGE.joinpath(*words[:length])
        if place.with_suffix(".py").is_file():
            return place.with_suffix(".py"), words[length:]
    return None


def is_defined(module: Path, name: str) -> bool:
    text = module.read_text(encoding="utf-8")
    return re.search(rf"^(?:def |class )?{name}\b", text, re.MULTILINE) is not None


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0][:40])
def test_every_function_named_for_an_equation_is_there(row: list[str]) -> None:
    module = None
    for name in re.findall(r"`([\w.]+)`", row[2]):
        found = module_of(name.split("."))
        if found is not None:
            module, rest = found
        else:
            assert module is not None, name
            rest = name.split(".")
        assert not rest or is_defined(module, rest[0]), f"{name} in {module}"
    assert module is not None
