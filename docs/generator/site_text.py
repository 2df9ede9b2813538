"""Text that the site adds to a file: links of root pages adapted to their place, links of tags."""

import re
from posixpath import dirname, normpath, relpath

ROOT_PAGES = {
    "explanations/architecture": "ARCHITECTURE.md",
    "reference/changelog": "CHANGELOG.md",
    "how-to/contribute": "CONTRIBUTING.md",
}
"""Pages of the site that show a file of the repository's root."""
LINK = re.compile(r"\]\((?!https?:|#)([^)\s#]+)([^)\s]*)\)")
TEST = re.compile(r"`tests/(?:\w+/)*(\w+/\w+\.py)::(?:test_)?(\w+)`")
"""A test as pages name it: ``tests/safety/test_tip_bound.py::test_a_cap_holds``."""
TAG_HEADING = re.compile(r"^### (\S+)$", re.MULTILINE)


def moved(text: str, page: str) -> str:
    """Text of a file of the root as that of a page: its links lead where they did.

    page: place of the page below ``docs``, without ``.md``.
    """
    pages = {name: f"docs/{place}.md" for place, name in ROOT_PAGES.items()}
    folder = dirname(f"docs/{page}")

    def link(found: re.Match[str]) -> str:
        target = pages.get(normpath(found[1]), found[1])
        return f"]({relpath(target, folder)}{found[2]})"

    return LINK.sub(link, text)


def told_tests(text: str) -> str:
    """Names of tests as the sentences that they are, with the file that each is in.

    In a narrow cell of a table a name would not wrap.
    """

    def sentence(found: re.Match[str]) -> str:
        return f"*{found[2].replace('_', ' ')}* (`{found[1]}`)"

    return TEST.sub(sentence, text)


def tags(sources: str) -> list[str]:
    """Tags that the page of sources explains, each under its heading."""
    return TAG_HEADING.findall(sources)


def tag_links(known: list[str], page: str) -> str:
    """Lines that let every tag of a page, as ``[paper]``, lead to where it is explained."""
    target = relpath("sources.md", dirname(page) or ".")
    return "".join(f"[{tag}]: {target}#{tag.lower()}\n" for tag in known)
