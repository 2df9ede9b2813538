"""Links of the files at the root, which are no pages of the site, lead somewhere."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\((?!https?:|#)([^)\s#]+)")
DATED = ("evidence", "decisions")
FILE = re.compile(r"`([a-z_]+(?:/[a-z0-9_]+)+\.(?:py|toml))`")
NAMED = re.compile(r"(?<![\w/])docs/[\w./-]+\.(?:md|toml|csv|py|svg|png)\b")


@pytest.mark.parametrize("page", sorted(ROOT.glob("*.md")), ids=lambda page: page.name)
def test_every_link_of_a_root_page_leads_to_a_file(page: Path) -> None:
    links = LINK.findall(page.read_text(encoding="utf-8"))
    assert not [link for link in links if not (ROOT / link).exists()]


def test_every_file_that_a_page_names_is_there() -> None:
    """As `room/module.py`; dated evidence and decisions keep the names of their day."""
    docs = ROOT / "docs"
    pages = [
        path for path in docs.rglob("*.md") if path.parent.name not in ("evidence", "decisions")
    ]
    named = {
        (path.relative_to(docs), name)
        for path in pages
        for name in FILE.findall(path.read_text(encoding="utf-8"))
    }
    assert len(named) > 20
    places = (ROOT / "src" / "opensuction", ROOT / "tests", ROOT)
    assert not [one for one in named if not any((place / one[1]).exists() for place in places)]


def test_every_page_that_code_names_is_there() -> None:
    files = (
        path
        for folder in ("src", "tests", "docs", "tools")
        for path in (ROOT / folder).rglob("*.*")
        if path.suffix in (".py", ".toml")
    )
    named = {
        (path.relative_to(ROOT), name)
        for path in files
        for name in NAMED.findall(path.read_text(encoding="utf-8"))
    }
    assert named
    assert not [(path, name) for path, name in named if not (ROOT / name).exists()]
