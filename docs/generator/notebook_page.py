"""Notebooks as pages of the site: each cell, and below it what it gives.

``python -m docs.generator.notebook_page NOTEBOOK`` carries one out and writes its page.
"""

import ast
import hashlib
import io
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import chdir, redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "build" / "notebooks"
"""Pages that were made, by the name of all that they come from: no notebook runs twice."""
SHOWN = ("_repr_html_", "_repr_svg_", "__repr__")
"""How a notebook asks what a cell ends with to show itself."""
UNCOMPILED = "NUMBA_DISABLE_JIT"
"""Set where Sphinx reads functions, not their compiled form: no cell would come to its end."""


class Output(NamedTuple):
    """Output of a cell."""

    printed: str
    shown: str
    """What its last expression shows of itself; "" for nothing."""
    is_html: bool


def cells(notebook: Path) -> list[dict[str, Any]]:
    """Cells of a notebook, in order."""
    found: list[dict[str, Any]] = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return found


def run(source: str, names: dict[str, Any], where: str) -> Output:
    """Carry a cell out.

    names: what the cells before left; changed. where: its place, for errors.
    """
    body = ast.parse(source, where)
    value = None
    with redirect_stdout(io.StringIO()) as printed:
        last = body.body.pop()
        if not isinstance(last, ast.Expr):
            body.body.append(last)
        exec(compile(body, where, "exec"), names)  # noqa: S102 - our notebook
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), where, "eval"), names)
    if value is None:
        return Output(printed.getvalue(), "", is_html=False)
    way = next(name for name in SHOWN if hasattr(value, name))
    return Output(printed.getvalue(), str(getattr(value, way)()), way != "__repr__")


def outputs(notebook: Path) -> Iterator[tuple[dict[str, Any], Output | None]]:
    """Each cell with its output, None for text, carried out in a folder of its own."""
    names: dict[str, Any] = {"__name__": "__main__"}
    with tempfile.TemporaryDirectory(prefix="opensuction-") as folder:
        (Path(folder) / "examples").symlink_to(ROOT / "docs" / "examples")
        (Path(folder) / "notebooks").mkdir()
        with chdir(Path(folder) / "notebooks"):
            for place, cell in enumerate(cells(notebook)):
                where = f"{notebook.name}, cell {place}"
                is_code = cell["cell_type"] == "code"
                yield cell, run("".join(cell["source"]), names, where) if is_code else None


def _block(kind: str, text: str) -> str:
    fence = "`" * 7
    return f"{fence}{kind}\n{text.rstrip()}\n{fence}"


def page(notebook: Path) -> str:
    """The page, in Markdown. Raises whatever a cell raises."""
    parts = []
    for cell, output in outputs(notebook):
        source = "".join(cell["source"])
        if output is None:
            parts.append(source)
            continue
        parts.append(_block("python", source))
        if output.printed:
            parts.append(_block("text", output.printed))
        if output.shown:
            parts.append(_block("{raw} html" if output.is_html else "text", output.shown))
    return "\n\n".join(parts) + "\n"


def _name(notebook: Path) -> str:
    """A name that changes with the notebook and with everything it may use."""
    used = (ROOT / "src").rglob("*"), (ROOT / "docs" / "examples").rglob("*")
    found = hashlib.sha256()
    for file in (notebook, Path(__file__), *sorted(one for every in used for one in every)):
        if file.is_file() and file.suffix != ".pyc":
            found.update(hashlib.sha256(file.read_bytes()).digest())
    return f"{notebook.stem}-{found.hexdigest()[:32]}.md"


def kept_page(notebook: Path) -> str:
    """The page as it was made before from the same, or is now, by a process of its own.

    Raises RuntimeError with what was said where a cell fails.
    """
    kept = KEPT / _name(notebook)
    if not kept.exists():
        environment = {name: value for name, value in os.environ.items() if name != UNCOMPILED}
        command = [sys.executable, "-m", "docs.generator.notebook_page", str(notebook)]
        done = subprocess.run(
            command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            raise RuntimeError(f"{notebook.name}: {done.stderr}")
        KEPT.mkdir(parents=True, exist_ok=True)
        aside = kept.with_suffix(f".{os.getpid()}")
        aside.write_text(done.stdout, encoding="utf-8")
        aside.replace(kept)
    return kept.read_text(encoding="utf-8")


if __name__ == "__main__":
    sys.stdout.write(page(Path(sys.argv[1]).resolve()))
