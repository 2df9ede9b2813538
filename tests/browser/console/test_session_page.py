"""Session of a page that was ended elsewhere, or is now another person's."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import Page, expect

from opensuction.accounts.rule.right import Role
from tests.browser.conftest import TABLET
from tests.browser.console.conftest import Bedside
from tests.browser.console.waiting import until
from tests.console.listening import listening
from tests.console.served import PEOPLE, Served

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Route, WebSocketRoute

pytestmark = pytest.mark.browser

LOOKS_MS = 10_000
"""How often a page looks by itself."""
FOCUS = "dispatchEvent(new Event('focus'))"


def enter(bedside: Bedside, role: Role = Role.CLINICIAN) -> Page:
    """Kim is signed in; nothing is under way."""
    bedside.machine.sign_in(role)
    bedside.page.clock.install()
    bedside.page.reload()
    bedside.page.get_by_role("button", name="kim, ").wait_for()
    return bedside.page


def by_its_timer(bedside: Bedside) -> None:
    bedside.page.clock.fast_forward(LOOKS_MS + 1000)


def by_its_focus(bedside: Bedside) -> None:
    bedside.page.evaluate(FOCUS)


def by_a_refusal(bedside: Bedside) -> None:
    """As of the page that was signed in before: its second secret does not fit any more."""
    bedside.machine.problem = (403, {"detail": "not the page that was signed in"}, {})
    bedside.page.get_by_role("button", name="Patient assessed").click()


WAYS = [by_its_timer, by_its_focus, by_a_refusal]


@pytest.mark.parametrize("looks", WAYS)
def test_another_person_who_signs_in_in_a_second_tab_is_named_in_the_first(
    bedside: Bedside, looks: Callable[[Bedside], None]
) -> None:
    page = enter(bedside)
    bedside.machine.show(passes=1)
    page.get_by_role("button", name="Patient assessed").wait_for()
    bedside.machine.sign_in(Role.CLINICIAN, name="robin")
    looks(bedside)
    expect(page.get_by_role("button", name="robin, clinician")).to_be_visible()
    expect(page.get_by_role("button", name="kim, ")).to_be_hidden()
    bedside.machine.problem = None
    page.get_by_role("button", name="Patient assessed").click()
    until(page, lambda: bool(bedside.machine.headers))
    assert bedside.machine.headers[-1]["x-csrf-token"] == "r" * 16


@pytest.mark.parametrize("looks", WAYS)
def test_a_session_that_was_ended_elsewhere_is_said(
    bedside: Bedside, looks: Callable[[Bedside], None]
) -> None:
    page = enter(bedside)
    bedside.machine.show(passes=1)
    page.get_by_role("button", name="Patient assessed").wait_for()
    bedside.machine.person = None
    looks(bedside)
    expect(page.get_by_role("dialog", name="Sign in")).to_contain_text("Your session has ended")
    expect(page.get_by_role("button", name="kim, ")).to_be_hidden()


def test_no_look_says_that_a_person_has_asked(bedside: Bedside) -> None:
    page, looks = enter(bedside), bedside.machine.unattended
    by_its_timer(bedside)
    until(page, lambda: len(looks) > 2)  # two pages were opened
    by_its_focus(bedside)
    until(page, lambda: len(looks) > 3)
    assert all(looks)


@pytest.mark.sweep
def test_what_one_person_has_begun_to_fill_in_is_not_the_next_ones(bedside: Bedside) -> None:
    page = enter(bedside)
    page.get_by_role("button", name="kim, ").click()
    page.get_by_role("dialog").get_by_label("Present password").fill("of kim alone")
    bedside.machine.sign_in(Role.CLINICIAN, name="robin")
    by_its_focus(bedside)
    expect(page.get_by_role("button", name="robin, ")).to_be_visible()
    expect(page.get_by_role("dialog")).to_be_hidden()


@pytest.mark.sweep
def test_a_slow_look_does_not_undo_a_sign_in(bedside: Bedside) -> None:
    page = bedside.page
    held: list[Route] = []

    def hold(route: "Route") -> None:
        if route.request.method == "GET":
            held.append(route)
        else:
            route.continue_()

    page.route("**/api/v1/session", hold)
    by_its_focus(bedside)
    until(page, lambda: bool(held))
    page.get_by_role("button", name="Sign in").first.click()
    dialog = page.get_by_role("dialog", name="Sign in")
    dialog.get_by_label("Name").fill("clinician")
    dialog.get_by_label("Password").fill("p")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="kim, clinician").wait_for()
    held[0].fulfill(json={"name": None, "rights": []})
    page.unroute("**/api/v1/session")
    seen = len(bedside.machine.unattended)
    by_its_focus(bedside)  # the next look comes when the slow one is done
    until(page, lambda: page.evaluate(FOCUS) or len(bedside.machine.unattended) > seen)
    expect(page.get_by_role("button", name="kim, clinician")).to_be_visible()
    expect(page.get_by_role("dialog")).to_be_hidden()


@pytest.mark.sweep
def test_who_could_not_be_signed_out_is_still_named(bedside: Bedside) -> None:
    page = enter(bedside)
    page.route(
        "**/api/v1/session",
        lambda route: route.abort() if route.request.method == "DELETE" else route.continue_(),
    )
    page.get_by_role("button", name="Sign out").click()
    expect(page.get_by_role("button", name="Sign out")).to_be_enabled()
    expect(page.get_by_role("button", name="kim, clinician")).to_be_visible()


RUNNING = {
    "audit": {"state": "running", "entries": 7, "head": "0" * 64},
    "trends": {"pending": 2, "days": [], "without_recording": 0, "cycles": 2, "cut": False},
}
"""What is asked for again until it is done."""


def sign_in(page: "Page", served: Served, role: str) -> None:
    page.goto(served.url)
    page.get_by_text("Live", exact=True).wait_for()
    page.get_by_role("button", name="Sign in").first.click()
    dialog = page.get_by_role("dialog", name="Sign in")
    dialog.get_by_label("Name").fill(PEOPLE[role])
    dialog.get_by_label("Password").fill(served.password(role))
    page.keyboard.press("Enter")
    page.get_by_role("button", name=f"{PEOPLE[role]}, ").wait_for()


def to_choose_a_password(bedside: Bedside) -> None:
    bedside.page.get_by_role("button", name="kim, ").click()


def to_add_an_account(bedside: Bedside) -> None:
    bedside.page.get_by_role("link", name="People").click()
    bedside.page.get_by_role("button", name="Add an account").click()


def to_revoke_a_token(bedside: Bedside) -> None:
    bedside.page.get_by_role("link", name="People").click()
    bedside.page.get_by_role("button", name="Revoke").click()


DIALOGS = [
    to_choose_a_password,
    pytest.param(to_add_an_account, marks=pytest.mark.sweep),
    pytest.param(to_revoke_a_token, marks=pytest.mark.soak),
]


@pytest.mark.parametrize("opened", DIALOGS)
def test_a_session_that_ends_behind_a_dialog_is_said_and_takes_the_dialog_away(
    bedside: Bedside, opened: Callable[[Bedside], None]
) -> None:
    bedside.machine.sign_in(Role.ENGINEER, administrator=True)
    page = bedside.page
    page.reload()
    page.get_by_role("button", name="kim, ").wait_for()
    opened(bedside)
    page.get_by_role("dialog").wait_for()
    bedside.machine.person = None
    by_its_focus(bedside)
    dialog = page.get_by_role("dialog")
    expect(dialog).to_have_accessible_name("Sign in")
    expect(dialog).to_contain_text("Your session has ended")
    bedside.machine.sign_in(Role.CLINICIAN, name="robin")
    dialog.get_by_role("button", name="Close").click()
    by_its_focus(bedside)
    expect(page.get_by_role("button", name="robin, ")).to_be_visible()
    expect(dialog).to_be_hidden()


@pytest.mark.sweep
def test_who_signs_out_leaves_no_dialog_behind(bedside: Bedside) -> None:
    page = enter(bedside)
    page.get_by_role("button", name="kim, ").click()
    page.get_by_role("dialog").get_by_label("Present password").fill("of kim alone")
    page.get_by_role("button", name="Sign out").click()
    expect(page.get_by_role("button", name="Sign in").first).to_be_visible()
    expect(page.get_by_role("dialog")).to_be_hidden()


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("left_name", "right_name"),
    [
        pytest.param("bed-1", "bed-2", marks=pytest.mark.soak),
        pytest.param("room", "room", id="forwarded-from-two-computers"),
    ],
)
def test_two_machines_of_one_computer_sign_nobody_out_of_each_other(
    chromium: "Browser", tmp_path: Path, left_name: str, right_name: str
) -> None:
    folders = {name: tmp_path / name for name in ("left", "right")}
    for folder in folders.values():
        folder.mkdir()
    context = chromium.new_context(viewport=TABLET)  # type: ignore[arg-type]
    try:
        with (
            listening(folders["left"], name=left_name) as left,
            listening(folders["right"], name=right_name) as right,
        ):
            first, second = context.new_page(), context.new_page()
            sign_in(first, left, "clinician")
            sign_in(second, right, "engineer")
            first.reload()
            expect(first.get_by_role("button", name=f"{PEOPLE['clinician']}, ")).to_be_visible()
            second.get_by_role("button", name="Sign out").click()
            expect(second.get_by_role("button", name="Sign in").first).to_be_visible()
            first.reload()
            expect(first.get_by_role("button", name=f"{PEOPLE['clinician']}, ")).to_be_visible()
    finally:
        context.close()


@pytest.mark.sweep
def test_a_second_tab_of_one_browser_tells_the_first_whose_it_is(
    chromium: "Browser", tmp_path: Path
) -> None:
    context = chromium.new_context(viewport=TABLET)  # type: ignore[arg-type]
    try:
        with listening(tmp_path) as served:
            first, second = context.new_page(), context.new_page()
            sign_in(first, served, "clinician")
            second.goto(served.url)
            second.get_by_role("button", name="Sign out").click()
            expect(second.get_by_role("button", name="Sign in").first).to_be_visible()
            sign_in(second, served, "engineer")
            first.evaluate(FOCUS)
            expect(first.get_by_role("button", name=f"{PEOPLE['engineer']}, ")).to_be_visible()
            expect(first.get_by_role("button", name=f"{PEOPLE['clinician']}, ")).to_be_hidden()
    finally:
        context.close()


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with listening(tmp_path_factory.mktemp("console")) as served:
        yield served


@pytest.fixture
def engineer(chromium: "Browser", console: Served) -> Iterator[Page]:
    """An engineer's page, whose timers wait for the test."""
    context = chromium.new_context(viewport=TABLET)  # type: ignore[arg-type]
    page = context.new_page()
    page.clock.install()
    sign_in(page, console, "engineer")
    yield page
    context.close()


@pytest.mark.sweep
@pytest.mark.parametrize("part", RUNNING)
def test_what_a_page_of_history_asks_for_again_keeps_no_session_alive(
    engineer: Page, part: str
) -> None:
    asked: list[bool] = []

    def answer(route: "Route") -> None:
        asked.append("x-unattended" in route.request.headers)
        route.fulfill(json=RUNNING[part])

    engineer.route(re.compile(f"/api/v1/{part}"), answer)
    engineer.get_by_role("link", name="History").click()
    engineer.locator(f"a[href='#/history/{part}']").click()
    for number in (1, 2, 3):
        until(engineer, lambda number=number: len(asked) >= number)  # type: ignore[misc]
        engineer.clock.fast_forward(LOOKS_MS)
    assert asked[:3] == [False, True, True]


@pytest.mark.sweep
def test_a_stream_of_signals_comes_back_as_one_that_nobody_asked_for(engineer: Page) -> None:
    asked: list[str] = []

    def cut(socket: "WebSocketRoute") -> None:
        asked.append(socket.url)
        socket.close(code=1011)

    engineer.route_web_socket("**/api/v1/signals*", cut)
    engineer.get_by_role("link", name="Signals").click()
    until(engineer, lambda: len(asked) > 2)
    assert ["unattended" in url for url in asked[:3]] == [False, True, True]


@pytest.mark.sweep
def test_a_stream_that_is_refused_has_the_page_look_at_its_session(
    engineer: Page, console: Served
) -> None:
    def refuse(socket: "WebSocketRoute") -> None:
        kept = {one["name"]: one["value"] for one in engineer.context.cookies()}
        console.site.accounts.sign_out(kept[console.session_cookie])
        socket.close(code=1008, reason="sign in first")

    engineer.route_web_socket("**/api/v1/signals*", refuse)
    engineer.get_by_role("link", name="Signals").click()
    expect(engineer.get_by_role("dialog", name="Sign in")).to_contain_text("Your session has ended")
