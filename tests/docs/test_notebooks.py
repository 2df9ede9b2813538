"""The notebooks run as they stand: their cells in order, each result shown as a notebook would."""

import json
from pathlib import Path
from typing import Any

import pytest

from docs.generator import notebook_page

FOLDER = notebook_page.ROOT / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
LONGEST = 200_000
"""Letters of a page: not a dump of numbers."""


@pytest.mark.examples
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_every_cell_of_a_notebook_runs(notebook: Path) -> None:
    page = notebook_page.kept_page(notebook)  # raises what a cell raises
    assert len(page) < LONGEST
    for cell in notebook_page.cells(notebook):
        assert "".join(cell["source"]) in page


def test_there_are_six_and_each_is_on_the_page() -> None:
    page = (FOLDER / "index.md").read_text("utf-8")
    assert len(NOTEBOOKS) == 6
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
        notebook_page.run("1 / 0", {}, "a notebook, cell 3")
    assert str(failed.traceback[-1].path) == "a notebook, cell 3"


def written(notebook: Path, *cells: dict[str, Any]) -> Path:
    notebook.write_text(json.dumps({"cells": cells}), "utf-8")
    return notebook


def test_a_page_has_each_cell_and_what_it_gives(tmp_path: Path) -> None:
    drawing = "class Drawing:\n    def _repr_svg_(self):\n        return '<svg></svg>'\n"
    cells = [
        {"cell_type": "markdown", "source": ["# Short"]},
        {"cell_type": "code", "source": ["print('six')\n", "2 * 3"]},
        {"cell_type": "code", "source": [drawing, "Drawing()"]},
        {"cell_type": "code", "source": ["x = 1"]},
    ]
    notebook = written(tmp_path / "short.ipynb", *cells)
    fence = "`" * 7
    assert notebook_page.page(notebook) == "\n\n".join(
        [
            "# Short",
            f"{fence}python\nprint('six')\n2 * 3\n{fence}",
            f"{fence}text\nsix\n{fence}",
            f"{fence}text\n6\n{fence}",
            f"{fence}python\n{drawing}Drawing()\n{fence}",
            f"{fence}{{raw}} html\n<svg></svg>\n{fence}",
            f"{fence}python\nx = 1\n{fence}\n",
        ]
    )


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A notebook of which the page is kept."""
    monkeypatch.setattr(notebook_page, "KEPT", tmp_path / "kept")
    notebook = written(tmp_path / "short.ipynb", {"cell_type": "code", "source": ["2 * 3"]})
    assert "\n6\n" in notebook_page.kept_page(notebook)
    return notebook


def test_a_kept_page_is_not_that_of_a_notebook_that_has_changed(kept: Path) -> None:
    written(kept, {"cell_type": "code", "source": ["2 * 4"]})
    page = notebook_page.kept_page(kept)
    assert "\n8\n" in page
    assert "\n6\n" not in page


def test_a_notebook_that_was_removed_has_no_page(kept: Path) -> None:
    kept.unlink()
    with pytest.raises(RuntimeError, match=kept.name):
        notebook_page.kept_page(kept)
