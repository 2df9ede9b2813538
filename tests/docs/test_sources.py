"""Citations of code and documentation: each is in `docs/sources.md`, and each entry is cited."""

import re
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "docs" / "sources.md"
CITING = ("src", "docs")
TEXTS = (".md", ".toml", ".j2")
HEADING = re.compile(r"^### (\S+)$", re.MULTILINE)
TAG = re.compile(r"(?<![\w\])])\[([A-Za-z][A-Za-z0-9-]*)\](?![(\[])")
SECTIONS = {"catheter", "conduit", "controller", "file", "hazard", "servo", "twin", "deg", "mm"}
"""Words in square brackets that are sections of TOML files or units: no tags."""
NOT_HERE = re.compile(r"\b(?:DESIGN|FACTS)\b|\bSTYLE\.md|\bpaper\.txt|\.\./shared|/shared/")
"""Texts that whoever reads this repository does not have."""
IN_STRINGS = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", -1)}


def files(*folders: str) -> Iterator[Path]:
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", *TEXTS) and path != Path(__file__):
                yield path


@cache
def prose(path: Path) -> str:
    """Comments and strings of a module, the text of a page without its code."""
    if path.suffix == ".py":
        with tokenize.open(path) as lines:
            tokens = tokenize.generate_tokens(lines.readline)
            return "\n".join(token.string for token in tokens if token.type in IN_STRINGS)
    code = r"^\[.*" if path.suffix == ".toml" else r"```.*?```|`[^`\n]*`"
    text = path.read_text(encoding="utf-8")
    return re.sub(code, "", text, flags=re.MULTILINE if path.suffix == ".toml" else re.DOTALL)


@cache
def cited(path: Path) -> set[str]:
    return set(TAG.findall(prose(path))) - SECTIONS


def known() -> list[str]:
    return HEADING.findall(SOURCES.read_text(encoding="utf-8"))


def test_every_tag_is_explained() -> None:
    unknown = {
        f"{path.relative_to(ROOT)}: [{tag}]"
        for path in files(*CITING)
        for tag in cited(path) - set(known())
    }
    assert not unknown


def test_every_source_named_in_a_docstring_has_a_tag() -> None:
    untagged = {
        f"{path.relative_to(ROOT)}: {source}"
        for path in files("src")
        for source in re.findall(r"Source: (.+)", prose(path))
        if "[" not in source and "``" not in source
    }
    assert not untagged


def test_every_source_is_cited_by_code_or_documentation() -> None:
    used = set().union(*(cited(path) for path in files(*CITING, "tests")))
    assert set(known()) <= used


def test_every_tag_is_explained_once() -> None:
    assert len(known()) == len(set(known()))


def test_nothing_cites_a_text_that_is_not_here() -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in files(*CITING, "tests")}
    assert not [path for path, text in texts.items() if NOT_HERE.search(text)]


@pytest.mark.parametrize(
    ("text", "tags"),
    [
        ("Source: [paper] eq. (3).", {"paper"}),
        ("[K] 6 to 8", {"K"}),
        ("([AARC-2022])", {"AARC-2022"}),
        ("a [link](page.md), a list[int], `[code]`, [twin]", {"twin"}),
    ],
)
def test_tags_are_told_from_links_and_code(text: str, tags: set[str], tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    assert cited(page) == tags - SECTIONS
