"""A sheet in a real browser: every plot has ink, nothing complains, nothing is fetched."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import pytest

from opensuction.report import sheet
from opensuction.report.sheet import Cell, Section, Table
from tests.browser.opened import INKED, opened
from tests.report import sheet_example

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext

pytestmark = pytest.mark.browser

PLOTS = ("plot-1-1", "plot-1-2", "plot-1-3")
BLANK = 20
"""Fewer colours than this are an empty frame: curves and their smoothed edges have more."""


@pytest.mark.parametrize(
    ("width", "scheme"),
    [
        (1400, "light"),
        (390, "dark"),
        pytest.param(1400, "dark", marks=pytest.mark.sweep),
        pytest.param(390, "light", marks=pytest.mark.sweep),
    ],
)
def test_sheet_draws_and_fits(
    tablet: "BrowserContext", tmp_path: Path, width: int, scheme: Literal["light", "dark"]
) -> None:
    sheet_page = opened(
        tablet,
        tmp_path,
        sheet.render(sheet_example.sheet()),
        PLOTS[-1],
        (width, 900),
        scheme,
    )
    for name in PLOTS:
        wide, high, colours = sheet_page.page.evaluate(INKED, name)
        assert wide > 0.7 * min(width, 600), name
        assert high > 100, name
        assert colours > BLANK, name
    assert sheet_page.page.evaluate("document.documentElement.scrollWidth") <= width
    assert sheet_page.complaints == []
    assert sheet_page.elsewhere() == []
    sheet_page.page.close()


def test_what_is_folded_opens_by_its_link_and_is_drawn_then(
    tablet: "BrowserContext", tmp_path: Path
) -> None:
    example = sheet_example.sheet()
    first = example.sections[0]
    linked = Table("Where to", ("section",), ((Cell("details", href="#more"),),))
    overview = Section("Overview", (), (linked,), first.plots[:1])
    folded = example._replace(sections=(overview, first._replace(anchor="more")))
    page = opened(tablet, tmp_path, sheet.render(folded), PLOTS[0]).page
    assert not page.evaluate("document.getElementById('more').open")
    page.get_by_role("link", name="details").click()
    page.wait_for_selector("#plot-2-1 canvas")
    assert page.evaluate("document.getElementById('more').open")
    wide, high, colours = page.evaluate(INKED, "plot-2-1")
    assert min(wide, high) > 100
    assert colours > BLANK
    page.close()
