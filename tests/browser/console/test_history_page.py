"""History in a real browser: the real application, a real recording, its report within the page."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from playwright.sync_api import expect

from opensuction.session.choice import CycleChoice, RigChoice
from tests.browser.console.test_everybody import SMALL, TOUCH_PX, findings
from tests.console.history.past import Past, fill, remember, work_here
from tests.console.listening import listening
from tests.console.served import Served
from tests.session.recorded import played

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext, Page

pytestmark = pytest.mark.browser

WORK_MS = 120_000


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    choice = CycleChoice(rig=RigChoice(machine="bench"), compensation="none")
    cycle = played.play(folder / "whole.mcap", choice)
    return played.without_truth(cycle.path, folder / "real.mcap")


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with listening(tmp_path_factory.mktemp("console")) as made:
        yield made


@pytest.fixture(scope="module")
def past(console: Served, recording: Path) -> Past:
    """For all tests: they look at it."""
    return remember(console, recording)


@pytest.fixture(autouse=True)
def _work_here(monkeypatch: pytest.MonkeyPatch) -> None:
    work_here(monkeypatch)


class Tab:
    """A page that somebody of a role has open, and what it complained of."""

    def __init__(self, context: "BrowserContext", console: Served, role: str | None) -> None:
        context.clear_cookies()
        for name, value in console.cookies(role).items():
            context.add_cookies([{"name": name, "value": value, "url": console.url}])
        self.url, self.complaints = console.url, list[str]()
        self.page: Page = context.new_page()
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("dialog", lambda dialog: self.complaints.append(dialog.message))

    def open(self, place: str) -> "Page":
        self.page.goto(f"{self.url}/#/history{place}")
        return self.page


def test_from_the_list_to_a_cycle_and_its_report(
    tablet: "BrowserContext", console: Served, past: Past
) -> None:
    tab = Tab(tablet, console, "observer")
    page = tab.open("")
    page.get_by_role("link", name="1", exact=True).click()
    page.get_by_role("heading", name="Cycle 1").wait_for()
    assert "completed" in page.inner_text(".cycle-head")
    page.get_by_role("link", name="Report").click()
    frame = page.frame_locator("iframe.report-frame")
    frame.locator("#depth canvas").wait_for(timeout=WORK_MS)
    assert "Completed" in frame.locator("#outcome").inner_text()
    assert frame.locator(".u-legend").first.is_visible()
    assert page.get_by_role("button", name="STOP").is_visible(), "STOP stays in reach"
    assert tab.complaints == []
    page.go_back()
    page.get_by_role("heading", name="Cycle 1").wait_for()
    page.close()
    assert past.completed


@pytest.mark.sweep
def test_a_recording_is_taken_and_played_again_by_keyboard(
    tablet: "BrowserContext", tmp_path: Path, recording: Path
) -> None:
    with listening(tmp_path) as console:  # of its own: one that was played again says so
        past = remember(console, recording)
        _take_and_play_again(Tab(tablet, console, "clinician"), past, recording)


def _take_and_play_again(tab: Tab, past: Past, recording: Path) -> None:
    page = tab.open(f"/cycle/{past.completed}")
    with page.expect_download() as download:
        page.get_by_role("link", name="Take the recording").focus()
        page.keyboard.press("Enter")
    assert Path(download.value.path()).read_bytes() == recording.read_bytes()
    page.get_by_role("button", name="Play it again").focus()
    page.keyboard.press("Enter")
    page.get_by_text("Identical: every output").wait_for(timeout=WORK_MS)
    assert tab.complaints == []
    page.close()


def test_a_list_is_narrowed_and_says_when_nothing_is_left(
    tablet: "BrowserContext", console: Served, past: Past
) -> None:
    tab = Tab(tablet, console, "observer")
    page = tab.open("")
    rows = page.locator(".history-list tbody tr")
    rows.nth(2).wait_for()
    page.get_by_label("Outcome").select_option("aborted")
    expect(rows).to_have_count(1)
    assert "tripped </script>" in rows.first.inner_text(), "as text"
    page.get_by_label("Words").fill("nobody of this name")
    page.keyboard.press("Enter")
    page.get_by_text("No cycle is like that").wait_for()
    page.get_by_role("button", name="Show all").click()
    rows.nth(2).wait_for()
    assert tab.complaints == []
    page.close()
    assert past.lost


@pytest.mark.sweep
def test_older_ones_follow_on_demand(tablet: "BrowserContext", tmp_path: Path) -> None:
    with listening(tmp_path) as console:
        fill(console, 60)
        _look_at_older_ones(Tab(tablet, console, "observer").open(""))


def _look_at_older_ones(page: "Page") -> None:
    rows = page.locator(".history-list tbody tr")
    rows.nth(49).wait_for()
    assert rows.count() == 50
    page.get_by_role("button", name="Older ones").click()
    rows.nth(59).wait_for()
    page.get_by_text("That is all.").wait_for()
    numbers = [int(text) for text in page.locator(".history-list tbody th").all_inner_texts()]
    assert numbers == list(range(60, 0, -1))
    page.close()


def test_alarms_trends_and_the_trail(tablet: "BrowserContext", console: Served, past: Past) -> None:
    tab = Tab(tablet, console, "engineer")
    page = tab.open("/alarms")
    page.locator(".priority.high").wait_for()
    page.get_by_role("link", name="Trends").click()
    page.get_by_label("Days shown").select_option("365")
    page.locator(".trend-plot canvas").first.wait_for()
    page.get_by_role("link", name="Who did what").click()
    page.get_by_role("button", name="Read the whole trail").click()
    page.get_by_text("nothing changed, removed or added. Read").wait_for(timeout=WORK_MS)
    assert tab.complaints == []
    page.close()
    assert past.running


@pytest.mark.sweep
def test_what_is_refused_is_said_and_can_be_tried_again(
    tablet: "BrowserContext", console: Served, past: Past
) -> None:
    page = Tab(tablet, console, "observer").open("/cycle/nobody")
    page.get_by_text("no such cycle is on record").wait_for()
    page.route("**/api/v1/cycles?*", lambda route: route.abort())
    page.goto(f"{console.url}/#/history/cycles")
    again = page.get_by_role("button", name="Try again")
    again.wait_for()
    page.unroute("**/api/v1/cycles?*")
    again.click()
    page.locator(".history-list tbody tr").first.wait_for()
    page.close()
    assert past.completed


@pytest.mark.sweep
def test_each_role_sees_what_it_may(tablet: "BrowserContext", console: Served, past: Past) -> None:
    page = Tab(tablet, console, "clinician").open("")
    page.locator(".history-list tbody tr").first.wait_for()
    assert page.get_by_role("link", name="Who did what").count() == 0
    page.close()
    page = Tab(tablet, console, None).open("")
    page.get_by_text("Sign in to see History").wait_for()
    page.close()
    assert past.completed


@pytest.mark.parametrize(
    "scheme",
    [
        pytest.param("dark", marks=pytest.mark.sweep),
        pytest.param("light", marks=pytest.mark.soak),
    ],
)
def test_the_history_is_for_everybody(
    tablet: "BrowserContext", console: Served, past: Past, scheme: Any
) -> None:
    tab = Tab(tablet, console, "engineer")
    tab.page.emulate_media(color_scheme=scheme)
    found = {}
    for place, shown in (
        ("/cycles", ".history-list tbody tr"),
        (f"/cycle/{past.completed}", "text=Play it again"),
        (f"/cycle/{past.lost}", ".priority.high"),
        ("/alarms", ".priority.high"),
        ("/trends", ".history-note, .trend-plot"),
        ("/audit", ".audit-head"),
    ):
        page = tab.open(place)
        page.locator(shown).first.wait_for()
        found[place] = findings(page) + page.evaluate(SMALL, TOUCH_PX)
    page = tab.open("/trends")
    page.get_by_label("Days shown").select_option("365")
    page.locator(".trend-plot canvas").first.wait_for()
    page.get_by_text("The same as a table").click()
    found["plots"] = findings(page) + page.evaluate(SMALL, TOUCH_PX)
    assert found == {name: [] for name in found}
    page.close()
