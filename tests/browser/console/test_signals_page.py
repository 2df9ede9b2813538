"""The view of signals beside a real machine: twin, controller and console as processes."""

import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

from opensuction.runtime import launch
from tests.browser.console.test_everybody import SMALL, TOUCH_PX
from tests.console.load.browser_page import FIGURES, show, signed_in
from tests.console.load.console_machine import CONSOLE, ConsoleMachine, console_machine

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page

pytestmark = [pytest.mark.real_time, pytest.mark.browser]

RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
DIFFERENCE = "B \N{MINUS SIGN} A"
SOON_MS = 60_000.0
"""A busy computer takes its time; nothing here is about how fast it goes."""
LOOKS_MS = 100.0


@pytest.fixture(scope="module")
def machine() -> Iterator[ConsoleMachine]:
    with console_machine() as made:
        yield made


@pytest.fixture(scope="module")
def engineer(chromium: "Browser", machine: ConsoleMachine) -> Iterator["BrowserContext"]:
    with signed_in(chromium, machine, "engineer") as context:
        yield context


@pytest.fixture(scope="module")
def tab(engineer: "BrowserContext", machine: ConsoleMachine) -> "Page":
    """Its views begin anew for each test: a page is loaded once."""
    return show(engineer, machine, "signals")


@pytest.fixture
def page(tab: "Page") -> "Page":
    """The view of signals, as somebody sees it who has just come to it."""
    tab.get_by_role("link", name="Bedside").click()
    tab.locator(".bedside").wait_for()
    tab.evaluate("sessionStorage.clear()")  # the channels that somebody has chosen
    tab.get_by_role("link", name="Signals").click()
    expect(status(tab)).to_contain_text("Live:", timeout=SOON_MS)
    return tab


def status(page: "Page"):  # type: ignore[no-untyped-def]
    return page.locator(".signals-status")


def rows(page: "Page") -> int:
    return int(page.evaluate(FIGURES)["rows"])


def wait_for_rows(page: "Page", more: int) -> None:
    """Until so many more have come."""
    wanted = rows(page) + more
    for _ in range(round(SOON_MS / LOOKS_MS)):
        if rows(page) > wanted:
            return
        page.wait_for_timeout(LOOKS_MS)
    raise AssertionError(f"{rows(page)} rows came, {wanted} were waited for")


NOTE_STATUS = """() => {
    window.told = [];
    const note = () => window.told.push(document.querySelector(".signals-status")?.textContent);
    new MutationObserver(note).observe(document.body, {
        subtree: true, childList: true, characterData: true });
}"""


def test_the_last_seconds_that_come_first_are_not_called_late(page: "Page") -> None:
    page.get_by_role("link", name="Bedside").click()
    page.locator(".bedside").wait_for()
    page.evaluate(NOTE_STATUS)
    page.get_by_role("link", name="Signals").click()
    expect(status(page)).to_contain_text("Live:", timeout=SOON_MS)
    said = {one for one in page.evaluate("window.told") if one}
    assert any("Waiting for the first rows" in one for one in said)
    assert not [one for one in said if "late" in one]


def test_every_tick_comes_and_is_drawn(page: "Page") -> None:
    before = page.evaluate(FIGURES)
    wait_for_rows(page, 1500)
    after = page.evaluate(FIGURES)
    assert after["missed"] == 0
    assert after["frames"] > before["frames"] + 3
    colours = """() => {
        const canvas = document.querySelector(".strip-plot canvas");
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return new Set(new Uint32Array(data.buffer)).size;
    }"""
    assert page.evaluate(colours) > 4


@pytest.mark.soak
def test_a_cycle_leaves_its_phases_and_its_loop(page: "Page", machine: ConsoleMachine) -> None:
    page.get_by_role("button", name="Loop", exact=True).click()
    machine.room.begin_cycle()
    happened = page.locator(".happened-list")
    for phase in ("Checking", "Inserting", "Withdrawing"):
        expect(happened).to_contain_text(phase, timeout=SOON_MS)
    expect(page.locator(".loop-note")).to_contain_text("No sensor tells where the tip is")
    happened.get_by_role("button", name="Inserting").first.click()
    expect(status(page)).to_contain_text("Paused")
    expect(page.locator(".cursor-a")).to_be_visible()


def test_a_picture_that_stands_still_goes_on_collecting(page: "Page") -> None:
    page.get_by_role("button", name="Pause", exact=True).click()
    expect(status(page)).to_contain_text("What you see is not now")
    wait_for_rows(page, 1000)
    page.get_by_role("button", name="Resume", exact=True).click()
    expect(status(page)).to_contain_text("Live:", timeout=SOON_MS)
    assert page.evaluate(FIGURES)["missed"] == 0


def test_two_cursors_tell_their_difference(page: "Page") -> None:
    area = page.locator(".strips-area")
    area.click(position={"x": 300, "y": 90})
    area.click(position={"x": 400, "y": 90})
    expect(page.locator(".cursors-between")).to_contain_text(f"{DIFFERENCE}:")
    first = page.locator(".line-cursors").first
    expect(first).to_contain_text("A ")
    expect(first).to_contain_text(DIFFERENCE)
    before = page.locator(".cursors-between").inner_text()
    page.keyboard.press("Shift+ArrowRight")
    expect(page.locator(".cursors-between")).not_to_have_text(before)


def test_keys_do_what_fingers_do(page: "Page") -> None:
    page.locator(".strips-area").focus()
    page.keyboard.press("Space")
    expect(status(page)).to_contain_text("Paused")
    for key in ("+", "ArrowLeft", "a", "ArrowRight", "b", "-"):
        page.keyboard.press(key)
    expect(page.locator(".cursor-a")).to_be_visible()
    page.keyboard.press("Escape")
    expect(status(page)).to_contain_text("Live:", timeout=SOON_MS)
    expect(page.locator(".cursor-a")).to_be_hidden()


def test_what_is_seen_is_saved_with_units_and_every_tick(page: "Page", tmp_path: Path) -> None:
    page.get_by_role("button", name="5 s", exact=True).click()
    wait_for_rows(page, 200)
    page.get_by_role("button", name="Pause", exact=True).click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save CSV").click()
    file = tmp_path / "seen.csv"
    download.value.save_as(file)
    lines = file.read_text(encoding="utf-8").splitlines()
    about = [line for line in lines if line.startswith("#")]
    assert any("not a medical device" in line for line in about)
    assert any("(estimated, mm)" in line for line in about)
    header, *table = lines[len(about) :]
    assert header.startswith("utc,time_s [s],tick,")
    assert "inputs.readings.carriage_mm [mm]" in header
    fields = [line.split(",") for line in table]
    assert {len(one) for one in fields} == {len(header.split(","))}
    ticks = [int(one[2]) for one in fields]
    assert all(after == before + 1 for before, after in pairwise(ticks))
    # Ticks that the loop has missed are no rows: of a busy computer some may be.
    lasted_s = float(fields[-1][1]) - float(fields[0][1])
    assert lasted_s == pytest.approx(5.0, abs=0.1)


@pytest.mark.sweep
def test_channels_are_chosen_and_no_more_than_may_be(page: "Page") -> None:
    page.get_by_label("Show").select_option("suction")
    expect(page.locator(".strips")).to_contain_text("Vacuum setpoint")
    page.get_by_role("button", name="Channels").click()
    page.get_by_label("Find by name or unit").fill("plays_mm")
    boxes = page.locator(".chooser-row:visible input")
    assert boxes.count() == 16
    for place in range(5):
        boxes.nth(place).check()
    expect(page.locator(".chooser-count")).to_contain_text("13 chosen: 12 at most")
    expect(page.get_by_role("button", name="Show these")).to_be_disabled()
    boxes.nth(0).uncheck()
    page.get_by_role("button", name="Show these").click()
    expect(page.locator(".strips")).to_contain_text("state.compensation.plays_mm.4")
    expect(status(page)).to_contain_text("Live:", timeout=SOON_MS)


@pytest.mark.sweep
@pytest.mark.parametrize("scheme", ["dark", pytest.param("light", marks=pytest.mark.soak)])
def test_everybody_can_use_it(page: "Page", scheme: str) -> None:
    page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
    for button in ("Loop", "Pause", "Channels"):
        page.get_by_role("button", name=button, exact=button == "Pause").click()
        found = Axe().run(page, options={"runOnly": RULES, "resultTypes": ["violations"]})
        said = [
            f"{one['id']}: {one['nodes'][0]['html'][:120]}" for one in found.response["violations"]
        ]
        said += page.evaluate(SMALL, TOUCH_PX)
        assert not said, json.dumps(said, indent=1)


@pytest.mark.sweep
def test_a_control_process_that_is_replaced_is_told(page: "Page", machine: ConsoleMachine) -> None:
    machine.room.stop()
    expect(status(page)).to_contain_text("the control process writes nothing", timeout=SOON_MS)
    machine.room.begin()
    expect(status(page)).to_contain_text("Live:", timeout=SOON_MS)
    expect(page.locator(".happened-list")).to_contain_text("The control process was replaced")


@pytest.mark.sweep
def test_it_comes_back_by_itself(page: "Page", machine: ConsoleMachine) -> None:
    before = page.evaluate("document.querySelector('.signals').figures.rows")
    machine.console.terminate()
    machine.console.wait(10.0)
    expect(status(page)).to_contain_text("No connection", timeout=SOON_MS)
    again = launch.spawn(machine.room.folder, CONSOLE)
    try:
        expect(status(page)).to_contain_text("Live:", timeout=SOON_MS)
        assert rows(page) > before
    finally:
        again.terminate()
        again.wait(10.0)
