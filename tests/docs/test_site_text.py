import pytest
from furo.navigation import get_navigation_tree

from docs.generator import site_text
from docs.generator.catalogue import DOCS


@pytest.mark.parametrize(
    ("link", "expected"),
    [
        ("docs/sources.md", "../sources.md"),
        ("docs/explanations/twin.md#machines", "../explanations/twin.md#machines"),
        ("docs/how-to/index.md", "index.md"),
        ("ARCHITECTURE.md", "../explanations/architecture.md"),
        ("LICENSE", "../../LICENSE"),
        ("https://example.org/a#b", "https://example.org/a#b"),
        ("#here", "#here"),
    ],
)
def test_links_of_a_root_page_lead_where_they_did(link: str, expected: str) -> None:
    assert site_text.moved(f"a [b]({link}) c", "how-to/contribute") == f"a [b]({expected}) c"


def test_every_root_page_and_its_stand_in_exist() -> None:
    for place, name in site_text.ROOT_PAGES.items():
        assert (DOCS / f"{place}.md").is_file()
        assert (DOCS.parent / name).is_file()


def test_a_tag_leads_to_its_heading() -> None:
    known = site_text.tags("# Sources\n\n## Kinds\n\n### K\n\ntext\n\n### AARC-2010\n")
    assert known == ["K", "AARC-2010"]
    lines = site_text.tag_links(known, "reference/alarms").splitlines()
    assert lines == ["[K]: ../sources.md#k", "[AARC-2010]: ../sources.md#aarc-2010"]
    assert site_text.tag_links(["K"], "index") == "[K]: sources.md#k\n"


def test_a_test_is_told_as_the_sentence_that_it_is() -> None:
    page = "no `tests/a.py`, but `tests/twin/machine/test_valve.py::test_the_seal_holds`, `a::b`"
    told = "no `tests/a.py`, but *the seal holds* (`machine/test_valve.py`), `a::b`"
    assert site_text.told_tests(page) == told


ROOT_TREE = """\
<p class="caption" role="heading"><span class="caption-text">Guides</span></p>
<ul>
<li class="toctree-l1"><a class="reference internal" href="a/index.html">A</a><ul>
<li class="toctree-l2"><a class="reference internal" href="a/b/x.html">X</a></li>
<li class="toctree-l2"><a class="reference internal" href="a/y.html">Y &amp; z</a></li>
<li class="toctree-l2"><a class="reference external" href="https://e.org/">https://e.org/</a></li>
</ul>
</li>
<li class="toctree-l1"><a class="reference internal" href="c.html">C</a></li>
</ul>
"""
"""As Sphinx 9 writes it beside a page that is not in it; the others differ from it as here."""
OWN = '<a class="current reference internal" href="#">'
TREES = {
    "search.html": {},
    "c.html": {
        '<ul>\n<li class="toctree-l1">': '<ul class="current">\n<li class="toctree-l1">',
        '<li class="toctree-l1"><a class="reference internal" href="c.html">': (
            '<li class="toctree-l1 current">' + OWN
        ),
    },
    "a/index.html": {
        '<ul>\n<li class="toctree-l1"><a class="reference internal" href="a/index.html">': (
            '<ul class="current">\n<li class="toctree-l1 current">' + OWN
        ),
        '"a/': '"',
        '"c.html': '"../c.html',
    },
    "a/b/x.html": {
        '<ul>\n<li class="toctree-l1">': '<ul class="current">\n<li class="toctree-l1 current">',
        '<ul>\n<li class="toctree-l2"><a class="reference internal" href="a/b/x.html">': (
            '<ul class="current">\n<li class="toctree-l2 current">' + OWN
        ),
        '"a/': '"../',
        '"c.html': '"../../c.html',
    },
}
"""What Sphinx writes differently beside each page."""


@pytest.mark.parametrize("address", TREES)
def test_the_tree_beside_a_page_is_what_the_theme_makes_of_sphinx_s(address: str) -> None:
    theirs = ROOT_TREE
    for old, new in TREES[address].items():
        assert old in theirs
        theirs = theirs.replace(old, new)
    navigation = site_text.Navigation(get_navigation_tree(ROOT_TREE))
    navigation.beside("a/y.html")  # nothing of it remains
    assert navigation.beside(address) == get_navigation_tree(theirs)
