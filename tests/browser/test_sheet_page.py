"""A sheet in a real browser: every plot has ink, nothing complains, nothing is fetched."""

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from opensuction.report import sheet
from tests.browser.test_report_page import INKED
from tests.report import sheet_example

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.browser

PLOTS = ("plot-1-1", "plot-1-2")
BLANK = 20
"""Fewer colours than this are an empty frame: curves and their smoothed edges have more."""


@pytest.mark.parametrize("width", [1400, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_sheet_draws_and_fits(chromium: "Browser", tmp_path: Path, width: int, scheme: str) -> None:
    file = tmp_path / "report.html"
    file.write_text(sheet.render(sheet_example.sheet()), encoding="utf-8")
    context = chromium.new_context(
        viewport={"width": width, "height": 900},
        color_scheme="dark" if scheme == "dark" else "light",
    )
    tab = context.new_page()
    complaints: list[str] = []
    requests: list[str] = []
    tab.on("console", lambda message: complaints.append(message.text))
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.on("request", lambda request: requests.append(request.url))
    tab.goto(file.as_uri())
    tab.wait_for_selector("#plot-1-2 canvas")
    for name in PLOTS:
        wide, high, colours = tab.evaluate(INKED, name)
        assert wide > 0.7 * min(width, 600), name
        assert high > 100, name
        assert colours > BLANK, name
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert complaints == []
    assert [url for url in requests if not url.startswith(("file:", "data:"))] == []
    context.close()
