"""Generated parts of the documentation agree with the code; `make docs` renews them."""

from pathlib import Path

import pytest

from docs.generator import document
from docs.generator.catalogue import DOCS, generated
from opensuction.kernel.errors import InputError

GENERATED = generated()


@pytest.mark.parametrize("path", GENERATED, ids=lambda path: str(path.relative_to(DOCS)))
def test_the_committed_file_is_the_generated_one(path: Path) -> None:
    assert path.read_text(encoding="utf-8") == GENERATED[path]()


def test_every_page_with_marks_is_generated() -> None:
    marked = {path for path in DOCS.rglob("*.md") if document.BEGIN in path.read_text("utf-8")}
    assert marked <= GENERATED.keys()


def test_only_what_stands_between_the_marks_is_replaced() -> None:
    page = f"before\n{document.BEGIN}old\n{document.END}after\n"
    expected = f"before\n{document.BEGIN}new\n{document.END}after\n"
    assert document.spliced(page, "new\n") == expected


@pytest.mark.parametrize("mark", [document.BEGIN, document.END])
def test_a_page_without_a_mark_is_refused(mark: str) -> None:
    page = (document.BEGIN + document.END).replace(mark, "")
    with pytest.raises(InputError, match="lacks the line"):
        document.spliced(page, "new")
