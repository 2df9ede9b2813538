"""No test of the first stage waits for the clock of the wall, by itself or by what it imports."""

import ast
import re
from functools import cache
from pathlib import Path

TESTS = Path(__file__).parents[1]
ALLOWED = ("real_time", "soak")
"""A test that sleeps has one of these marks: it runs by itself, or in `make soak`."""


IMPORT = re.compile(r"^ *from (tests[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
"""As the formatter of this repository leaves it; to walk every tree takes seconds."""


@cache
def text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(text(path))


def sleeps(path: Path) -> bool:
    """It calls ``time.sleep``, by whichever name."""
    if "sleep" not in text(path):
        return False
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Attribute) and ast.unparse(node) == "time.sleep":
            return True
        if isinstance(node, ast.ImportFrom) and node.module == "time":
            return any(one.name == "sleep" for one in node.names)
    return False


@cache
def imported(path: Path) -> set[Path]:
    """Modules of the tests that it uses, and the conftest files that are put before it."""
    found = {
        folder / "conftest.py" for folder in path.parents if TESTS in (folder, *folder.parents)
    }
    for module, names in IMPORT.findall(text(path)):
        base = TESTS.parent / module.replace(".", "/")
        found.add(base.with_suffix(".py"))
        found |= {base / f"{name}.py" for name in re.findall(r"\w+", names)}
    return {one for one in found if one.exists()} - {path}


@cache
def sleeper(path: Path) -> Path | None:
    """The module by which it sleeps; None: by none."""
    seen, open_ = {path}, [path]
    while open_:
        here = open_.pop()
        if sleeps(here):
            return here
        open_.extend(found := imported(here) - seen)
        seen |= found
    return None


def unmarked(path: Path) -> list[str]:
    """Its tests that the first stage runs."""
    marks = [
        ast.unparse(node.value)
        for node in tree(path).body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "pytestmark"
    ]
    if any(name in mark for mark in marks for name in ALLOWED):
        return []
    return [
        node.name
        for node in tree(path).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
        if not any(name in ast.unparse(one) for one in node.decorator_list for name in ALLOWED)
    ]


def test_no_test_of_the_first_stage_sleeps() -> None:
    found = {
        str(path.relative_to(TESTS)): (str(by.relative_to(TESTS)), names)
        for path in sorted(TESTS.rglob("test_*.py"))
        if (by := sleeper(path)) is not None and (names := unmarked(path))
    }
    assert found == {}


def test_a_sleep_behind_two_imports_is_found(tmp_path: Path) -> None:
    assert sleeper(TESTS / "runtime" / "test_kills.py") is not None
    assert sleeper(TESTS / "kernel" / "test_compiled.py") is None
    bare = tmp_path / "test_bare.py"
    bare.write_text("from time import sleep\n\ndef test_it(): sleep(1)\n")
    assert sleeps(bare)
    assert unmarked(bare) == ["test_it"]
