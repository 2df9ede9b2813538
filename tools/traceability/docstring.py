"""Form of module docstrings: the first word is no question word.

A docstring's first line names the thing or says what it does: "Access rights", not "Who may do
what".
"""

import ast
import re
import tomllib
from pathlib import Path

from tools.traceability.matrix import ROOT

QUESTION_WORD = re.compile(r"\W*(what|whether|who|whose|whom|how|where|when|which|why)\b", re.I)


def question_word(source: str) -> str | None:
    """Question word that the docstring of a module opens with; None where it opens otherwise.

    source: of the module. Raises SyntaxError where it is not Python.
    """
    found = QUESTION_WORD.match(ast.get_docstring(ast.parse(source)) or "")
    return found[1] if found else None


def read(root: Path = ROOT) -> dict[str, str]:
    """Sources of all modules in the folders that are type-checked, by their path below the root."""
    settings = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    paths = [
        p for folder in settings["tool"]["mypy"]["files"] for p in (root / folder).rglob("*.py")
    ]
    return {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8") for p in sorted(paths)}


def problems(sources: dict[str, str]) -> list[str]:
    """Modules whose docstring opens with a question word, a line each."""
    words = {name: question_word(source) for name, source in sources.items()}
    return [
        f'{name}: its docstring opens with "{word}"; name the thing, or say what it does'
        for name, word in words.items()
        if word is not None
    ]
