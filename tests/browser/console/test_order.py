"""Two buttons, one after the other: they are sent in that order; STOP goes at once."""

import pytest
from playwright.sync_api import Locator, Route, expect

from opensuction.accounts.rule.right import Role
from opensuction.safety.condition import Condition
from tests.browser.console.conftest import Bedside
from tests.browser.console.fake_machine import alarm, alarming

pytestmark = [pytest.mark.real_time, pytest.mark.browser]
WAIT_MS = 5000
"""So long a button waits on the page."""


@pytest.fixture
def buttons(bedside: Bedside) -> tuple[Locator, Locator]:
    """Acknowledge, which the machine does not answer yet, and the audio pause."""
    page, machine = bedside.page, bedside.machine
    machine.sign_in(Role.CLINICIAN)
    machine.show(**alarming(alarm(Condition.SPO2_LOW)))
    page.reload()
    machine.held.add("acknowledge")
    bar = page.locator(".alarm-buttons")
    return bar.get_by_role("button", name="Acknowledge", exact=True), bar.get_by_role(
        "button", name="Pause"
    )


def let_others_be_faster(bedside: Bedside) -> None:
    """Return once whatever the page was free to send has come: what it asks later has an answer."""
    bedside.page.evaluate("async () => (await fetch('api/v1/machine')).json()")


def wait_arrived(bedside: Bedside, *asks: str) -> None:
    for _ in range(400):
        if bedside.machine.arrived == list(asks):
            return
        bedside.page.wait_for_timeout(25)
    assert bedside.machine.arrived == list(asks)


def test_a_button_is_sent_once_the_one_before_it_is_answered(
    bedside: Bedside, buttons: tuple[Locator, Locator]
) -> None:
    for one in buttons:
        one.click()
    wait_arrived(bedside, "acknowledge")
    let_others_be_faster(bedside)
    assert bedside.machine.arrived == ["acknowledge"]
    bedside.machine.held.clear()
    wait_arrived(bedside, "acknowledge", "audio-pause")


def test_a_button_that_fails_lets_the_next_go_on(
    bedside: Bedside, buttons: tuple[Locator, Locator]
) -> None:
    first: list[Route] = []

    def keep(one: Route) -> None:
        first.append(one)

    bedside.page.route("**/api/v1/requests", keep, times=1)
    for one in buttons:
        one.click()
    let_others_be_faster(bedside)
    assert bedside.machine.arrived == []
    first[0].abort()  # its connection is cut
    wait_arrived(bedside, "audio-pause")


def test_stop_goes_at_once_and_what_waits_is_not_sent_after_it(
    bedside: Bedside, buttons: tuple[Locator, Locator]
) -> None:
    for one in buttons:
        one.click()
    wait_arrived(bedside, "acknowledge")
    bedside.page.locator("#stop").click()
    wait_arrived(bedside, "acknowledge", "abort")
    expect(bedside.page.locator(".alarm-answer")).to_contain_text("Stop was pressed")
    bedside.machine.held.clear()
    buttons[1].click()
    wait_arrived(bedside, "acknowledge", "abort", "audio-pause")
    let_others_be_faster(bedside)
    assert bedside.machine.arrived == ["acknowledge", "abort", "audio-pause"]


def test_a_button_that_waits_too_long_is_not_sent_any_more(
    bedside: Bedside, buttons: tuple[Locator, Locator]
) -> None:
    """What was meant five seconds ago may mean another machine."""
    page = bedside.page
    page.clock.install()
    page.reload()
    for one in buttons:
        one.click()
    wait_arrived(bedside, "acknowledge")
    page.clock.fast_forward(WAIT_MS)
    expect(page.locator(".alarm-answer")).to_contain_text("no answer yet")
    bedside.machine.held.clear()
    buttons[1].click()
    wait_arrived(bedside, "acknowledge", "audio-pause")


@pytest.fixture
def unknown(bedside: Bedside, buttons: tuple[Locator, Locator]) -> list[Route]:
    """A page that does not know yet whose session it is; what tells it so is kept here."""
    bedside.machine.held.clear()
    waiting: list[Route] = []

    def keep(one: Route) -> None:
        waiting.append(one)

    bedside.page.route("**/api/v1/session", keep)
    bedside.page.reload()
    buttons[0].wait_for()
    return waiting


def tell_who(bedside: Bedside, waiting: list[Route]) -> None:
    for one in waiting:
        one.continue_()
    bedside.page.unroute("**/api/v1/session")


def test_what_is_pressed_before_a_page_knows_its_session_is_sent_once_it_does(
    bedside: Bedside, buttons: tuple[Locator, Locator], unknown: list[Route]
) -> None:
    """It was taken for a stranger's: the page asked for a name, and the press was lost."""
    for one in buttons:
        one.click()
    assert bedside.page.locator(".dialog").count() == 0
    assert bedside.machine.arrived == []
    tell_who(bedside, unknown)
    wait_arrived(bedside, "acknowledge", "audio-pause")
    assert bedside.page.locator(".dialog").count() == 0


def test_stop_drops_what_was_pressed_before_a_page_knows_its_session(
    bedside: Bedside, buttons: tuple[Locator, Locator], unknown: list[Route]
) -> None:
    buttons[0].click()
    bedside.page.locator("#stop").click()
    wait_arrived(bedside, "abort")
    expect(bedside.page.locator(".alarm-answer")).to_contain_text("Stop was pressed")
    tell_who(bedside, unknown)
    let_others_be_faster(bedside)
    assert bedside.machine.arrived == ["abort"]


def test_a_stranger_s_press_asks_who_it_is(
    bedside: Bedside, buttons: tuple[Locator, Locator], unknown: list[Route]
) -> None:
    bedside.machine.person = None
    buttons[0].click()
    tell_who(bedside, unknown)
    bedside.page.locator(".dialog").wait_for()
    assert bedside.machine.arrived == []
