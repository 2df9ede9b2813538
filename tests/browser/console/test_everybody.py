"""Accessibility of the page: axe-core's rules of WCAG 2.2, level AA, in each state."""

from typing import TYPE_CHECKING, Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

from opensuction.accounts.rule.right import Role
from opensuction.safety.condition import Condition
from tests.browser.console.conftest import Bedside
from tests.browser.console.fake_machine import alarm, alarming
from tests.browser.console.waiting import drawn

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = pytest.mark.browser

RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
SCHEMES = ("dark", pytest.param("light", marks=pytest.mark.sweep))
"""Colours, dark as the console is at first."""
INSIDE = {"tip_mm": 49.0, "is_inside": True}
STATES: dict[str, dict[str, Any]] = {
    "parked": {"passes": 1},
    "suctioning": {**INSIDE, "phase": "suctioning", "valve_open": True, "vacuum_mmhg": 98.0},
    "high": {**INSIDE, "phase": "halted", **alarming(alarm(Condition.WITHDRAWAL_BLOCKED))},
    "medium": alarming(alarm(Condition.CONTACT_STUCK_CLOSED), alarm(Condition.LINE_LEAKING)),
    "low": alarming(alarm(Condition.CATHETER_LIFE_ENDING)),
    "out of limits": {"monitor": {"connected": True, "spo2_percent": 80.0}},
}


def findings(page: "Page") -> list[str]:
    """What axe-core finds, each with the first place where it does."""
    found = Axe().run(page, options={"runOnly": RULES, "resultTypes": ["violations"]})
    return [
        f"{one['id']} ({one['impact']}): {one['nodes'][0]['html'][:160]}"
        for one in found.response["violations"]
    ]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_bedside_view_is_for_everybody(clinician: Bedside, scheme: Any) -> None:
    page, machine = clinician.page, clinician.machine
    page.emulate_media(color_scheme=scheme)
    found = {}
    for name, state in STATES.items():
        machine.show(**state)
        drawn(page, machine)
        found[name] = findings(page)
    machine.mute = True
    page.locator(".alarm-kind").get_by_text("NO CONNECTION").wait_for()
    found["lost"] = findings(page)
    assert found == {name: [] for name in found}


@pytest.mark.parametrize("scheme", ["dark", pytest.param("light", marks=pytest.mark.soak)])
def test_people_and_dialogs_are_for_everybody(bedside: Bedside, scheme: Any) -> None:
    page, machine = bedside.page, bedside.machine
    page.emulate_media(color_scheme=scheme)
    page.get_by_role("button", name="Sign in").first.click()
    found = [findings(page)]
    machine.sign_in(Role.ENGINEER, administrator=True)
    page.goto(f"{bedside.url}#/people")
    page.reload()
    page.get_by_role("row", name="Start a cycle").wait_for()
    found.append(findings(page))
    page.get_by_role("button", name="Issue a token").click()
    page.get_by_role("dialog").wait_for()
    found.append(findings(page))
    assert found == [[], [], []]


SMALL = """least => [...document.querySelectorAll(
        "button, a[href], input, select, textarea, summary, [role=tab]")]
    .filter(one => one.checkVisibility({ visibilityProperty: true }) && !one.closest("[inert]"))
    .map(one => [one.labels?.[0] && /checkbox|radio/.test(one.type) ? one.labels[0] : one, one])
    .map(([place, one]) => [place.getBoundingClientRect(), one.outerHTML.slice(0, 100)])
    .filter(([box]) => box.width > 1 && Math.min(box.width, box.height) < least)
    .map(([box, html]) => `${Math.round(box.width)} x ${Math.round(box.height)}: ${html}`)"""
"""What may be touched and is smaller than this."""
TOUCH_PX = 12.0 * 96.0 / 25.4
"""12 mm, as a browser counts them."""


def test_what_is_touched_is_as_large_as_a_finger_in_a_glove(bedside: Bedside) -> None:
    page, machine = bedside.page, bedside.machine
    machine.sign_in(Role.ENGINEER, administrator=True)
    page.reload()
    page.locator(".live-anatomy").wait_for()
    machine.show(
        phase="halted",
        **alarming(alarm(Condition.CONTACT_STUCK_CLOSED), alarm(Condition.LINE_LEAKING)),
    )
    page.get_by_role("button", name="1 more").click()
    found = {"bedside": page.evaluate(SMALL, TOUCH_PX)}
    page.goto(f"{bedside.url}#/people")
    page.get_by_role("row", name="Start a cycle").wait_for()
    found["people"] = page.evaluate(SMALL, TOUCH_PX)
    page.get_by_role("button", name="Add an account").click()
    page.get_by_role("dialog").wait_for()
    found["dialog"] = page.evaluate(SMALL, TOUCH_PX)
    assert found == {name: [] for name in found}


def test_a_keyboard_reaches_everything(clinician: Bedside) -> None:
    page, machine = clinician.page, clinician.machine
    machine.show(phase="halted", **alarming(alarm(Condition.CONTACT_STUCK_CLOSED)))
    page.get_by_role("button", name="Reset").wait_for()
    reached = []
    for _ in range(24):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.textContent.trim().slice(0, 14)"))
    for wanted in ("Acknowledge", "Pause sound", "Sign out", "Bedside", "People", "STOPor key F8"):
        assert wanted in reached, (wanted, reached)
    assert any(one.startswith("START") for one in reached)
    assert any(one.startswith("Reset") for one in reached)


def test_esc_closes_a_dialog_and_gives_the_focus_back(bedside: Bedside) -> None:
    page = bedside.page
    button = page.get_by_role("button", name="Sign in")
    button.click()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_be_hidden()
    expect(button).to_be_focused()
    assert bedside.machine.asked == []


def test_nothing_is_fetched_from_elsewhere_and_the_policy_holds(bedside: Bedside) -> None:
    asked: list[str] = []
    bedside.page.on("request", lambda request: asked.append(request.url))
    bedside.page.reload()
    bedside.page.locator(".live-anatomy").wait_for()
    for name in ("People", "Bedside"):
        bedside.page.get_by_role("link", name=name).click()
    bedside.page.wait_for_load_state("networkidle")
    assert [url for url in asked if not url.startswith(bedside.url)] == []
    assert bedside.complaints == []


def test_the_page_fits(bedside: Bedside) -> None:
    for wide, high in ((1280, 800), (1920, 1080), (768, 1024), (390, 844)):
        assert_fits(bedside.page, wide, high)


def assert_fits(page: "Page", wide: int, high: int) -> None:
    page.set_viewport_size({"width": wide, "height": high})
    page.wait_for_function("wide => document.documentElement.scrollWidth <= wide", arg=wide)
    expect(page.locator("#stop")).to_be_in_viewport(ratio=0.99)
    if wide >= 1280:
        for place in (".phase-word", ".tip .figure", ".vacuum .big", ".last", "#start"):
            expect(page.locator(place)).to_be_in_viewport(ratio=0.99)
