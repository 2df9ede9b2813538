"""Hazards, requirements and the tests that cite them, read without importing any of them.

A test cites a requirement by ``@pytest.mark.requirement("OS-R01")``; a module by ``pytestmark``.
"""

import ast
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
EVIDENCE = ROOT / "src" / "opensuction" / "evidence" / "safety_case"
HAZARDS = EVIDENCE / "hazard.toml"
REQUIREMENTS = EVIDENCE / "requirement.toml"
TESTS = ROOT / "tests"


class Mark(NamedTuple):
    """A test that says which requirement it verifies."""

    test: str
    """File and function, as pytest names them."""
    requirement: str


class Matrix(NamedTuple):
    """Claims, and the tests that show them."""

    hazards: tuple[dict[str, Any], ...]
    requirements: dict[str, Any]
    """Sentence by identifier."""
    marks: tuple[Mark, ...]


def _is_requirement(call: ast.expr) -> bool:
    """True where an expression is a call of ``pytest.mark.requirement``."""
    return (
        isinstance(call, ast.Call)
        and isinstance(call.func, ast.Attribute)
        and call.func.attr == "requirement"
        and isinstance(call.func.value, ast.Attribute)
        and call.func.value.attr == "mark"
    )


def _cited(expressions: list[ast.expr], where: str) -> Iterator[Mark]:
    """Marks among decorators, or in what is assigned to ``pytestmark``."""
    for expression in expressions:
        if isinstance(expression, ast.List | ast.Tuple):
            yield from _cited(expression.elts, where)
        elif _is_requirement(expression):
            assert isinstance(expression, ast.Call)
            for argument in expression.args:
                # What is not written out cannot be traced: it shows up as unknown.
                yield Mark(where, str(ast.literal_eval(argument)))


def marks_of(source: str, name: str) -> list[Mark]:
    """Marks in the source of one file of tests.

    name: of the file, for the names of its tests. Raises SyntaxError where it is not Python,
    ValueError where an identifier is not written out.
    """
    found: list[Mark] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found += _cited(node.decorator_list, f"{name}::{node.name}")
        elif isinstance(node, ast.Assign) and any(
            isinstance(target, ast.Name) and target.id == "pytestmark" for target in node.targets
        ):
            found += _cited([node.value], name)
    return found


def read(hazards: Path = HAZARDS, requirements: Path = REQUIREMENTS, tests: Path = TESTS) -> Matrix:
    """Everything from its files."""
    table = tomllib.loads(hazards.read_text(encoding="utf-8"))
    sentences = tomllib.loads(requirements.read_text(encoding="utf-8"))
    marks: list[Mark] = []
    for path in sorted(tests.rglob("test_*.py")):
        name = path.relative_to(tests.parent).as_posix()
        marks += marks_of(path.read_text(encoding="utf-8"), name)
    return Matrix(tuple(table.get("hazard", ())), sentences, tuple(marks))


def gaps(found: Matrix) -> list[str]:
    """Gaps in the evidence, a line each."""
    known = set(found.requirements)
    verified = {mark.requirement for mark in found.marks}
    problems = [f"requirement {name}: no test cites it" for name in sorted(known - verified)]
    problems += [
        f"{mark.test}: cites unknown requirement {mark.requirement}"
        for mark in found.marks
        if mark.requirement not in known
    ]
    for number, hazard in enumerate(found.hazards, start=1):
        name = str(hazard.get("id", f"number {number}"))
        if not hazard.get("fault"):
            problems.append(f"hazard {name}: no fault shows it")
        cited = hazard.get("requirements", [])
        if not cited:
            problems.append(f"hazard {name}: no requirement answers it")
        problems += [
            f"hazard {name}: unknown requirement {each}" for each in cited if each not in known
        ]
    names = [hazard.get("id") for hazard in found.hazards]
    problems += [
        f"hazard {name}: more than one of this identifier"
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]
    return problems
