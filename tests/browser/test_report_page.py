"""The report in a real browser: it draws, it is silent, it fits."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from opensuction.report.cycle import page
from opensuction.result.cycle_result import CycleResult
from tests.browser.opened import INKED, SCHEMES, Opened
from tests.browser.opened import opened as open_page
from tests.report import example

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext

pytestmark = pytest.mark.browser

PLOTS = ("depth", "error", "suction", "secretion", "loop")
PATIENT_PLOTS = (*PLOTS, "contact", "airway", "lung", "saturation", "heart")


MARKED = """() => {
    const canvas = document.querySelector("#error canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const bad = getComputedStyle(document.documentElement).getPropertyValue("--bad").trim();
    const [red, green, blue] = [1, 3, 5].map((i) => parseInt(bad.slice(i, i + 2), 16));
    let found = 0;
    for (let i = 0; i < data.length; i += 4)
        found += data[i] === red && data[i + 1] === green && data[i + 2] === blue;
    return found;
}"""
"""Pixels of the colour of an alarm in a plot that has no other use for it."""


def _open(context: "BrowserContext", folder: Path, result: CycleResult, **window: Any) -> Opened:
    trace = example.breathing_trace() if result.patient else example.trace()
    return open_page(context, folder, page.render(result, trace), "loop", **window)


@pytest.fixture(scope="module")
def opened(tablet: "BrowserContext", tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    """Of one cycle, for all tests that look at it."""
    report = _open(tablet, tmp_path_factory.mktemp("bench"), example.summary())
    yield report
    report.page.close()


def test_page_opens_from_disk_without_network_or_complaints(opened: Opened) -> None:
    assert opened.complaints == []
    assert opened.elsewhere() == []


def test_every_plot_is_drawn(opened: Opened) -> None:
    for plot in PLOTS:
        width, height, colours = opened.page.evaluate(INKED, plot)
        assert width > 300, plot
        assert height > 150, plot
        assert colours > 5, plot  # blank is 1; lines, grid, text and their soft edges are many


def test_outcome_and_depth_can_be_read(opened: Opened) -> None:
    assert "Completed" in opened.page.inner_text("#outcome")
    assert "90.7 mm" in opened.page.inner_text("main")
    assert "not a medical device" in opened.page.inner_text(".disclaimer")


def test_cursor_reads_all_time_plots_and_rings_the_loop(opened: Opened) -> None:
    depth = opened.page.locator("#depth .u-over")
    depth.scroll_into_view_if_needed()
    depth.hover()
    opened.page.wait_for_function(
        "document.querySelector('#suction .u-legend').innerText.includes('mmHg')"
    )
    assert "mm" in opened.page.inner_text("#depth .u-legend")
    assert opened.page.locator("#loop .ring-mark").is_visible()


def test_plots_follow_the_window(opened: Opened) -> None:
    opened.page.set_viewport_size({"width": 800, "height": 900})
    opened.page.wait_for_function(
        "document.querySelector('#depth canvas').getBoundingClientRect().width < 800"
    )
    assert opened.complaints == []
    opened.page.set_viewport_size({"width": 1400, "height": 900})


@pytest.fixture(scope="module")
def on_patient(
    tablet: "BrowserContext", tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Opened]:
    """Of one cycle on a patient, for all tests that look at it."""
    report = _open(tablet, tmp_path_factory.mktemp("patient"), example.on_patient())
    yield report
    report.page.close()


def test_patient_and_contact_have_their_plots(on_patient: Opened) -> None:
    for plot in PATIENT_PLOTS:
        width, height, colours = on_patient.page.evaluate(INKED, plot)
        assert width > 300
        assert height > 150
        assert colours > 5
    assert on_patient.complaints == []


def test_bench_without_contact_shows_neither(opened: Opened) -> None:
    assert opened.page.locator("#saturation").count() == 0
    assert opened.page.locator("#contact").is_hidden()


def test_moment_on_a_plot_of_the_patient_is_the_same_moment_of_the_machine(
    on_patient: Opened,
) -> None:
    saturation = on_patient.page.locator("#saturation .u-over")
    saturation.scroll_into_view_if_needed()
    box = saturation.bounding_box()
    assert box is not None
    saturation.hover(position={"x": 0.15 * box["width"], "y": 0.5 * box["height"]})  # near 18 s
    on_patient.page.wait_for_function(
        "document.querySelector('#depth .u-legend').innerText.includes(' s')"
    )
    read = "id => parseFloat(document.querySelector(`#${id} tr:first-child .u-value`).innerText)"
    here, there = (on_patient.page.evaluate(read, plot) for plot in ("saturation", "depth"))
    assert here == pytest.approx(18.2, abs=0.5)
    assert there == pytest.approx(here, abs=0.3)  # rows of both are thinned
    assert on_patient.page.locator("#loop .ring-mark").is_visible()


@pytest.mark.parametrize(
    "summary",
    [example.aborted(), example.on_patient(outcome="aborted", alarms=[example.ALARM])],
)
def test_phone_shows_everything_without_sideways_scrolling(
    tablet: "BrowserContext", tmp_path: Path, summary: CycleResult
) -> None:
    opened = _open(tablet, tmp_path, summary, size=(390, 844))
    for scheme in SCHEMES:
        opened.page.emulate_media(color_scheme=scheme)
        width = opened.page.evaluate("document.documentElement.scrollWidth")
        assert width <= 390, scheme
        assert "High alarm" in opened.page.inner_text("#outcome")
        assert opened.complaints == []
    opened.page.close()


def test_dark_page_prints_on_white(tablet: "BrowserContext", tmp_path: Path) -> None:
    opened = _open(tablet, tmp_path, example.summary(), scheme="dark")
    paper = "getComputedStyle(document.body).backgroundColor"
    assert opened.page.evaluate(paper) != "rgb(255, 255, 255)"
    opened.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert opened.page.evaluate(paper) == "rgb(255, 255, 255)"
    opened.page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert opened.page.evaluate(paper) != "rgb(255, 255, 255)"
    assert opened.complaints == []
    opened.page.close()


def test_an_alarm_is_marked_from_top_to_bottom(tablet: "BrowserContext", tmp_path: Path) -> None:
    pixels = []
    for summary in (example.aborted(), example.aborted(alarms=[])):
        report = _open(tablet, tmp_path, summary)
        pixels.append(report.page.evaluate(MARKED))
        report.page.close()
    assert pixels[0] > 100
    assert pixels[1] == 0


def test_plots_show_the_whole_record_and_on_request_the_cycle_alone(on_patient: Opened) -> None:
    page = on_patient.page
    ends = []
    for button in ("#whole", "#focus", "#whole"):
        page.click(button)
        assert page.get_attribute(button, "aria-pressed") == "true"
        plot = page.locator("#depth .u-over")
        plot.scroll_into_view_if_needed()
        box = plot.bounding_box()
        assert box is not None
        plot.hover(position={"x": box["width"] - 3.0, "y": 0.5 * box["height"]})
        page.wait_for_function(
            "document.querySelector('#depth .u-legend').innerText.includes(' s')"
        )
        shown = page.inner_text("#depth tr:first-child .u-value")
        ends.append(float(shown.removesuffix(" s")))
    assert ends[0] > 119.0  # of 121.5 s
    assert 32.0 < ends[1] < 34.0  # of 31.5 s, and 2 s
    assert ends[2] == ends[0]
