"""Form of modules: docstrings that do not ask, a name of its own in its package.

A docstring's first line names the thing or says what it does: "Access rights", not "Who may do
what"; "True while the tip is inside", not "Whether the tip is inside". So does that of a function
or class of the product and of the tools. Two modules of one name in one package of `opensuction`
would be mistaken for each other.
"""

import ast
import re
import tomllib
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path, PurePosixPath
from typing import TypeAlias

from tools.traceability.matrix import ROOT

PRODUCT = PurePosixPath("src/opensuction")
TOOLS = PurePosixPath("tools")
ROOMS_TO_REWRITE = frozenset(
    {
        "accounts",
        "cli",
        "console",
        "evidence",
        "library",
        "recording",
        "records",
        "report",
        "result",
        "session",
    }
)
"""Rooms of the product whose functions and classes are not looked at yet."""
QUESTION_WORD = re.compile(r"\W*(what|whether|who|whose|whom|how|where|when|which|why)\b", re.I)

_Definition: TypeAlias = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def question_word(source: str) -> str | None:
    """Question word that the docstring of a module opens with; None where it opens otherwise.

    source: of the module. Raises SyntaxError where it is not Python.
    """
    return _question_word(ast.parse(source))


def asking_definitions(source: str) -> list[tuple[int, str, str]]:
    """Functions and classes whose docstring opens with a question word: line, name and word.

    source: of their module. Raises SyntaxError where it is not Python.
    """
    found = [
        (node.lineno, node.name, word)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, _Definition) and (word := _question_word(node)) is not None
    ]
    return sorted(found)


def _question_word(node: ast.Module | _Definition) -> str | None:
    found = QUESTION_WORD.match(ast.get_docstring(node) or "")
    return found[1] if found else None


def read(root: Path = ROOT) -> dict[str, str]:
    """Sources of all modules in the folders that are type-checked, by their path below the root."""
    settings = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    paths = [
        p for folder in settings["tool"]["mypy"]["files"] for p in (root / folder).rglob("*.py")
    ]
    return {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8") for p in sorted(paths)}


def problems(sources: dict[str, str]) -> list[str]:
    """Docstrings that open with a question word, and modules that share a name, a line each."""
    words = {name: question_word(source) for name, source in sources.items()}
    asking = [
        f'{name}: its docstring opens with "{word}"; name the thing, or say what it does'
        for name, word in words.items()
        if word is not None
    ]
    asking += [
        f'{name}:{line}: the docstring of {defined} opens with "{word}"; name the thing, or say '
        "what it does"
        for name, source in sources.items()
        if _is_looked_at(PurePosixPath(name))
        for line, defined, word in asking_definitions(source)
    ]
    return asking + _name_sharing(sources)


def _is_looked_at(path: PurePosixPath) -> bool:
    """True for a module whose functions and classes are held to the form."""
    if path.is_relative_to(PRODUCT):
        return path.relative_to(PRODUCT).parts[0] not in ROOMS_TO_REWRITE
    return path.is_relative_to(TOOLS)


def _name_sharing(names: Iterable[str]) -> list[str]:
    """Modules of the product that have the name of another one in the same package, a line each."""
    alike: dict[tuple[str, str], list[str]] = defaultdict(list)
    for name in names:
        path = PurePosixPath(name)
        if path.is_relative_to(PRODUCT) and not path.stem.startswith("__"):
            package = path.relative_to(PRODUCT).parts[0]
            alike[package, path.stem].append(name)
    return [
        f"{', '.join(paths)}: one name in one package; say in it what each is of"
        for paths in alike.values()
        if len(paths) > 1
    ]
