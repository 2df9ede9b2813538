"""The notebooks run as they stand: their cells in order, each result shown as a notebook would."""

import ast
import json
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
SHOWN = ("_repr_html_", "_repr_svg_", "__repr__")
"""How a notebook asks what a cell ends with to show itself."""


def cells(notebook: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(notebook.read_text("utf-8"))["cells"]
    return found


def run(source: str, names: dict[str, Any], where: str) -> str:
    """Carry a cell out; what its last expression shows."""
    body = ast.parse(source, where)
    last = body.body.pop() if isinstance(body.body[-1], ast.Expr) else None
    exec(compile(body, where, "exec"), names)  # noqa: S102 - our notebook
    if last is None:
        return ""
    assert isinstance(last, ast.Expr)
    value = eval(compile(ast.Expression(last.value), where, "eval"), names)
    if value is None:
        return ""
    shown = next(getattr(value, name) for name in SHOWN if hasattr(value, name))
    return str(shown())


@pytest.mark.examples
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_every_cell_of_a_notebook_runs(
    notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "docs" / "examples")
    (tmp_path / "notebooks").mkdir()
    monkeypatch.chdir(tmp_path / "notebooks")
    names: dict[str, Any] = {"__name__": "__main__"}
    for place, cell in enumerate(cells(notebook)):
        if cell["cell_type"] == "code":
            shown = run("".join(cell["source"]), names, f"{notebook.name}, cell {place}")
            assert len(shown) < 200_000  # a page, not a dump of numbers


def test_there_are_four_and_each_is_on_the_page() -> None:
    page = (FOLDER / "index.md").read_text("utf-8")
    assert len(NOTEBOOKS) == 4
    for notebook in NOTEBOOKS:
        assert f"]({notebook.name})" in page


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_a_notebook_is_stored_without_what_it_printed(notebook: Path) -> None:
    data = json.loads(notebook.read_text("utf-8"))
    assert (data["nbformat"], data["nbformat_minor"]) == (4, 5)
    ids = [cell["id"] for cell in data["cells"]]
    assert len(set(ids)) == len(ids)
    for cell in data["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            assert cell["execution_count"] is None


def test_a_cell_that_fails_is_found_out_with_its_place() -> None:
    with pytest.raises(ZeroDivisionError) as failed:
        run("1 / 0", {}, "a notebook, cell 3")
    assert str(failed.traceback[-1].path) == "a notebook, cell 3"
