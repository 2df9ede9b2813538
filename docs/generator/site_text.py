"""Text that the site adds to a file: links of root pages adapted to their place, links of tags.

Beside each page the tree of all pages, as Sphinx and the theme would have it.
"""

import re
from posixpath import dirname, normpath, relpath
from typing import Any

from bs4 import BeautifulSoup, Tag
from bs4.element import AttributeValueList

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


class Navigation:
    """The tree of all pages, made once for all of them.

    Sphinx would resolve and write it anew for each page, and the theme read and write it again.
    """

    def __init__(self, tree: str) -> None:
        """tree: as the theme has it at the root, beside a page that is not in it."""
        self._tree = BeautifulSoup(tree, "html.parser")
        self._links = {str(link["href"]): link for link in self._tree.select("a.internal")}

    def beside(self, address: str) -> str:
        """The tree beside a page: the way to it unfolded, links from its place.

        address: the page's, below the root, as ``how-to/calibrate.html``.
        """
        folder = dirname(address) or "."
        for target, link in self._links.items():
            link["href"] = "#" if target == address else relpath(target, folder)
        here = self._links.get(address)
        changed = [] if here is None else _unfold(here)
        text = str(self._tree)
        for tag, before in changed:
            tag.attrs = before
        return text


def _unfold(link: Tag) -> list[tuple[Tag, dict[str, Any]]]:
    """Mark the way to a page; returns what was changed, with its attributes before."""
    changed = [(link, dict(link.attrs))]
    link["class"] = AttributeValueList(["current", *link["class"]])
    innermost = True
    for tag in link.parents:
        if tag.name not in ("ul", "li"):
            continue
        changed.append((tag, dict(tag.attrs)))
        level, *others = tag.get_attribute_list("class") if tag.name == "li" else [None]
        words = [level, "current", *others, "current-page" if innermost else None]
        tag["class"] = AttributeValueList(word for word in words if word)
        innermost = False
        fold = tag.find("input", recursive=False)
        if isinstance(fold, Tag):
            changed.append((fold, dict(fold.attrs)))
            fold["checked"] = ""
    return changed
