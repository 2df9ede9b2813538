"""The page of the hazard analysis is what the data say, and the walk leaves nothing out."""

from pathlib import Path

from opensuction.evidence import hazard_page
from opensuction.evidence.safety_case import hazard
from opensuction.report.document import spliced

PAGE = Path(__file__).resolve().parents[2] / "docs" / "hazard-analysis.md"


def test_the_page_is_what_make_docs_would_write() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert spliced(page, hazard_page.markdown()) == page


def test_every_part_answers_every_guide_word_and_nothing_else() -> None:
    for part in hazard_page.walk():
        assert set(part) == {"name", *hazard_page.GUIDE_WORDS}, part["name"]


def test_the_walk_names_known_hazards_and_every_one_of_them() -> None:
    known = {one.row.id for one in hazard.load()}
    named = {
        name
        for part in hazard_page.walk()
        for key in hazard_page.GUIDE_WORDS
        if isinstance(part[key], list)
        for name in part[key]
    }
    assert named == known
