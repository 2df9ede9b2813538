"""The report of an identification in a real browser: it draws, it is silent, it fits."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from opensuction.report.identification import identification_page
from opensuction.result.identification_result import WorkbenchResult
from tests.browser.opened import INKED, SCHEMES, Opened, opened
from tests.report import identification_example as example

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext

pytestmark = pytest.mark.browser

PLOTS = ("loop", "hysteresis", "output", "residual", "autocorrelation")

HAS_COLOUR = """([id, name]) => {
    const probe = document.createElement("i");
    probe.style.color = `var(--${name})`;
    document.body.append(probe);
    const [r, g, b] = getComputedStyle(probe).color.match(/[0-9]+/g).map(Number);
    const canvas = document.querySelector(`#${id} canvas`);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const sought = [r, g, b, 255];
    for (let i = 0; i < data.length; i += 4)
        if (sought.every((part, k) => data[i + k] === part)) return true;
    return false;
}"""
"""Whether a plot holds pixels in a colour of the style sheet."""


def _open(context: "BrowserContext", folder: Path, html: str, **window: Any) -> Opened:
    return opened(context, folder, html, "autocorrelation", **window)


@pytest.fixture(scope="module")
def compared(
    tablet: "BrowserContext", tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Opened]:
    """Of several models, for all tests that look at it."""
    html = identification_page.render(example.compared(), example.curves())
    report = _open(tablet, tmp_path_factory.mktemp("compared"), html)
    yield report
    report.page.close()


def test_every_plot_is_drawn_without_network_or_complaints(compared: Opened) -> None:
    for plot in PLOTS:
        width, height, colours = compared.page.evaluate(INKED, plot)
        assert width > 300
        assert height > 150
        assert colours > 5
    assert compared.complaints == []
    assert compared.elsewhere() == []


def test_a_chosen_model_appears_in_every_plot_and_goes_again(compared: Opened) -> None:
    second = compared.page.locator("#chips button").nth(1)
    for pressed in ("true", "false"):
        second.click()
        assert second.get_attribute("aria-pressed") == pressed
        for plot in PLOTS:
            drawn = compared.page.evaluate(HAS_COLOUR, [plot, "head"])
            assert drawn is (pressed == "true"), plot
    assert compared.complaints == []


def test_cursor_reads_output_and_residual_together(compared: Opened) -> None:
    output = compared.page.locator("#output .u-over")
    output.scroll_into_view_if_needed()
    output.hover()
    compared.page.wait_for_function(
        "document.querySelector('#residual .u-legend').innerText.includes('mm')"
    )
    assert "mm" in compared.page.inner_text("#output .u-legend")


@pytest.mark.parametrize("alone", [True, False])
def test_phone_shows_everything_without_sideways_scrolling(
    tablet: "BrowserContext", tmp_path: Path, alone: bool
) -> None:
    result: WorkbenchResult = example.identified() if alone else example.compared()
    html = identification_page.render(result, example.curves(example.MODELS[: 1 if alone else 3]))
    report = _open(tablet, tmp_path, html, size=(390, 844), scheme="dark")
    for scheme in reversed(SCHEMES):
        report.page.emulate_media(color_scheme=scheme)
        assert report.page.evaluate("document.documentElement.scrollWidth") <= 390, scheme
        assert "error 0.3 %" in report.page.inner_text("#outcome")
        assert report.complaints == []
    report.page.close()


def test_ranking_is_no_wider_than_the_page(compared: Opened) -> None:
    for width in (760, 1100, 1400):
        compared.page.set_viewport_size({"width": width, "height": 900})
        wide, room = compared.page.evaluate(
            "(() => { const table = document.querySelector('.ranking');"
            " return [table.scrollWidth, table.parentElement.clientWidth]; })()"
        )
        assert wide <= room, width


def test_dark_page_prints_on_white(tablet: "BrowserContext", tmp_path: Path) -> None:
    html = identification_page.render(example.compared(), example.curves())
    report = _open(tablet, tmp_path, html, scheme="dark")
    paper = "getComputedStyle(document.body).backgroundColor"
    assert report.page.evaluate(paper) != "rgb(255, 255, 255)"
    report.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert report.page.evaluate(paper) == "rgb(255, 255, 255)"
    assert report.complaints == []
    report.page.close()
