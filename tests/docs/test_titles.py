"""Titles of pages name their subject, as the first lines of modules do."""

from pathlib import Path

import pytest

from tools.traceability.module_form import QUESTION_WORD

DOCS = Path(__file__).resolve().parents[2] / "docs"


def title(page: str) -> str:
    """Text of the first heading of a page."""
    return next(line[2:] for line in page.splitlines() if line.startswith("# "))


def opens_with_question(page: str) -> bool:
    words = title(page).split(". ", 1)[-1]
    return QUESTION_WORD.match(words) is not None and not words.startswith("How-to ")


def test_no_title_of_a_page_is_a_question() -> None:
    pages = sorted(DOCS.rglob("*.md"))
    assert len(pages) > 100
    assert [page.name for page in pages if opens_with_question(page.read_text("utf-8"))] == []


@pytest.mark.parametrize(
    ("page", "expected"),
    [
        ("# Who may do what\n\ntext\n", True),
        ("# 18. Where the head is, is voted on\n", True),
        ("(anchor)=\n\n# How alarms are decided\n", True),
        ("# Accounts and access rights\n\n## What is counted\n", False),
        ("# 36. Gap and offset; what the mouth tells\n", False),
        ("# Whole cycles\n", False),
        ("# How-to guides\n", False),
        ("# How to suction\n", True),
    ],
)
def test_a_question_is_seen_behind_the_number_of_a_decision(page: str, expected: bool) -> None:
    assert opens_with_question(page) is expected
