"""STOP: there on every view, for everybody, at once; and loud where it was not delivered."""

import random

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


CLICK = "document.getElementById('stop').click()"
"""As a screen reader or a switch does it: no pointer, no key."""


@pytest.mark.parametrize("gesture", ["slid off", "cancelled"])
def test_what_a_finger_began_swallows_no_press_after_it(bedside: Bedside, gesture: str) -> None:
    page, asked = bedside.page, bedside.machine.asked
    place = page.locator("#stop").bounding_box()
    assert place is not None
    page.mouse.move(place["x"] + 20.0, place["y"] + 20.0)
    page.mouse.down()
    until(page, lambda: len(asked) == 1)
    if gesture == "cancelled":
        page.locator("#stop").dispatch_event("pointercancel", {"pointerId": 1, "bubbles": True})
    page.mouse.move(place["x"] - 200.0, place["y"] - 200.0)
    page.mouse.up()
    page.locator("#stop").focus()
    page.keyboard.press("Enter")
    until(page, lambda: len(asked) == 2)
    page.evaluate(CLICK)
    until(page, lambda: len(asked) == 3)
    page.mouse.down()  # beside the button: nothing
    page.mouse.up()
    page.evaluate(CLICK)
    until(page, lambda: len(asked) == 4)


@pytest.mark.sweep
def test_each_press_is_a_stop_whatever_came_before(bedside: Bedside) -> None:
    """A person in haste: drawn sequences of what hands, keys and readers do with the button."""
    page, asked = bedside.page, bedside.machine.asked
    place = page.locator("#stop").bounding_box()
    assert place is not None
    on, off = (place["x"] + 20.0, place["y"] + 20.0), (place["x"] - 200.0, place["y"] - 200.0)
    chance, expected, is_down = random.Random(34), 0, False
    done: list[str] = []
    page.mouse.move(*on)
    is_on = True
    for _ in range(120):
        act = chance.choice(["move", "button", "button", "Enter", " ", "F8", "reader"])
        done.append(act)
        if act == "move":
            is_on = not is_on
            page.mouse.move(*(on if is_on else off))
        elif act == "button":
            (page.mouse.up if is_down else page.mouse.down)()
            is_down = not is_down
            expected += is_down and is_on
        elif act == "reader":
            page.evaluate(CLICK)
            expected += 1
        else:
            page.locator("#stop").focus()
            page.keyboard.press(act)
            expected += 1
        until(page, lambda: len(asked) >= expected)  # noqa: B023
        assert len(asked) == expected, done


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
