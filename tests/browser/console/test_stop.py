"""STOP: there on every view, for everybody, at once; and loud where it was not delivered."""

import pytest
from playwright.sync_api import expect

from opensuction.accounts.rule.right import Role
from tests.browser.console.conftest import Bedside
from tests.browser.console.waiting import until

pytestmark = [pytest.mark.real_time, pytest.mark.browser]

VIEWS = ("bedside", "setup", "signals", "history", "people")
FEEDBACK_MS = 100.0
INSERTING = {"phase": "inserting", "moving": "in", "is_inside": True, "tip_mm": 62.0}


def test_stop_is_at_the_same_place_on_every_view(bedside: Bedside) -> None:
    page = bedside.page
    bedside.machine.show(**INSERTING)
    places = set()
    for name in VIEWS:
        page.get_by_role("navigation").get_by_role("link", name=name.capitalize()).click()
        expect(page.locator(f"#console[data-view={name}]")).to_be_visible()
        box = page.locator("#stop").bounding_box()
        assert box is not None
        places.add((box["x"], box["y"], box["width"], box["height"]))
        page.locator("#stop").click()
    assert len(places) == 1
    until(page, lambda: len(bedside.machine.asked) == len(VIEWS))
    assert {one["ask"] for one in bedside.machine.asked} == {"abort"}


def test_stop_says_at_once_that_it_was_pressed(bedside: Bedside) -> None:
    bedside.machine.show(**INSERTING)
    bedside.machine.deaf = True
    took_ms = bedside.page.evaluate(
        """() => new Promise(done => {
            const button = document.getElementById('stop');
            const begun = performance.now();
            new MutationObserver(() => requestAnimationFrame(() => done(performance.now() - begun)))
                .observe(button, { attributes: true });
            button.dispatchEvent(new PointerEvent('pointerdown', { bubbles: true }));
        })"""
    )
    assert took_ms < FEEDBACK_MS
    expect(bedside.page.locator("#stop")).to_have_attribute("data-state", "sending")


def test_stop_needs_no_sign_in_and_nothing_keeps_it_out(bedside: Bedside) -> None:
    page, machine = bedside.page, bedside.machine
    machine.show(**INSERTING)
    page.get_by_role("button", name="Sign in").click()
    page.get_by_role("dialog").wait_for()
    page.locator("#stop").click()
    expect(page.locator(".stop-status")).to_contain_text("Stop received: Inserting")
    page.keyboard.press("F8")  # while somebody types a password
    until(page, lambda: [one["ask"] for one in machine.asked] == ["abort", "abort"])
    page.locator("#stop").focus()
    page.keyboard.press("Enter")
    until(page, lambda: len(machine.asked) == 3)
    machine.sign_in(Role.OBSERVER)
    page.reload()
    page.locator("#stop").click()
    until(page, lambda: len(machine.asked) == 4)


def test_one_press_is_one_stop(bedside: Bedside) -> None:
    bedside.page.locator("#stop").click()
    expect(bedside.page.locator(".stop-status")).to_contain_text("Nothing was under way")
    bedside.page.wait_for_load_state("networkidle")
    assert len(bedside.machine.asked) == 1


@pytest.mark.parametrize("how", ["deaf", "refused", "not pressed"])
def test_a_stop_that_was_not_delivered_is_said_loudly(bedside: Bedside, how: str) -> None:
    page, machine = bedside.page, bedside.machine
    machine.show(**INSERTING)
    if how == "deaf":
        machine.deaf = True
    elif how == "refused":
        detail = "NOBODY HEARS THE STOP (the controller does not answer)"
        machine.problem = (503, {"detail": detail}, {})
    else:
        machine.answer = {"verdict": "too many", "refusal": None}
    page.locator("#stop").click()
    said = page.locator(".not-stopped")
    said.wait_for(timeout=1500)
    expect(said).to_contain_text("NOT STOPPED")
    expect(said).to_contain_text("red button on the machine")
    expect(said).to_contain_text("draw the catheter out by the handle")
    size = said.locator(".not-stopped-word").evaluate(
        "one => parseFloat(getComputedStyle(one).fontSize)"
    )
    assert size > 60.0
    machine.deaf, machine.problem = False, None
    machine.answer = {"verdict": "pressed", "refusal": None}
    expect(said).to_be_hidden(timeout=6000)  # it was tried again by itself
    expect(page.locator(".stop-status")).to_contain_text("Stop received")
