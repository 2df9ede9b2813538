import pytest

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
