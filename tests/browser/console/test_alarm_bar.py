"""Alarms on the page: seen, heard, answered; and the loss of the machine, which is one itself."""

import numpy as np
import pytest
from playwright.sync_api import expect

from opensuction.accounts.rule.right import Role
from opensuction.safety.alarm import alarm_signal
from opensuction.safety.condition import Condition
from opensuction.safety.handling import Priority
from tests.browser.console.conftest import Bedside
from tests.browser.console.fake_machine import alarm, alarming
from tests.browser.console.waiting import drawn, until

pytestmark = pytest.mark.browser

BY_PRIORITY = {
    Priority.HIGH: Condition.SPO2_LOW,
    Priority.MEDIUM: Condition.CONTACT_STUCK_CLOSED,
    Priority.LOW: Condition.CATHETER_LIFE_ENDING,
}
COLOURS = {"red": (194, 15, 28), "yellow": (255, 212, 0), "cyan": (134, 227, 239)}
INSIDE = {"tip_mm": 62.0, "tip_low_mm": 60.5, "tip_high_mm": 63.5, "is_inside": True}
LOST_MS = 2000
"""Within this time the loss of the connection is shown."""


def test_light_is_that_of_the_priority(bedside: Bedside) -> None:
    for priority in BY_PRIORITY:
        assert_light(bedside, priority)


def assert_light(bedside: Bedside, priority: Priority) -> None:
    page, condition = bedside.page, BY_PRIORITY[priority]
    bedside.machine.show(**alarming(alarm(condition)))
    expect(page.locator(".alarm-bar")).to_have_attribute("data-priority", priority.name.lower())
    expect(page.locator(".alarm-kind")).to_contain_text(priority.name)
    lamp, light = page.locator(".alarm-lamp[data-lit]"), alarm_signal.LIGHTS[priority]
    told = lamp.evaluate(
        """one => [getComputedStyle(one).backgroundColor, ...one.getAnimations().map(
            run => [run.effect.getTiming().duration, run.effect.getKeyframes()[1].offset])]"""
    )
    assert told[0] == "rgb({}, {}, {})".format(*COLOURS[light.colour])
    if light.flash_hz.value > 0.0:
        assert told[1] == [pytest.approx(1e3 / light.flash_hz.value), light.duty_ratio.value]
    else:
        assert told[1:] == []


def test_sound_is_the_machines_own(bedside: Bedside) -> None:
    for priority in Priority:
        assert_sound(bedside, priority)


def assert_sound(bedside: Bedside, priority: Priority) -> None:
    rate_hz = 16_000
    made = bedside.page.evaluate(
        """async ([priority, rate_hz]) => {
            const { burst } = await import('./js/alarm/sound.js');
            const told = await (await fetch('api/v1/alarm-signals')).json();
            return Array.from(burst(told.find(one => one.priority === priority), rate_hz));
        }""",
        [priority.name.lower(), rate_hz],
    )
    wanted = alarm_signal.burst(priority, rate_hz)
    assert abs(len(made) - len(wanted)) <= 1
    shared = min(len(made), len(wanted))
    assert np.allclose(made[:shared], wanted[:shared], atol=1e-5)  # the page's are of 32 bits


def test_what_is_silent_is_remembered_by_a_tone_when_the_machine_says_so(bedside: Bedside) -> None:
    page, machine = bedside.page, bedside.machine
    page.evaluate(
        """() => {
            window.sounded = [];
            const begin = AudioBufferSourceNode.prototype.start;
            AudioBufferSourceNode.prototype.start = function (...when) {
                window.sounded.push(this.buffer.duration);
                return begin.apply(this, when);
            };
        }"""
    )
    page.locator(".phase-word").click()  # a page may sound once it was touched
    silent = {**alarming(alarm(Condition.SPO2_LOW, acknowledged=True)), "audible": "none"}
    for silent_s in (0.1, 12.0, 29.9, 0.02, 1.0):
        machine.show(**{**silent, "silent_s": silent_s})
        drawn(page, machine)
    (lasts_s,) = page.evaluate("window.sounded")
    rate_hz = 22_050
    wanted = len(alarm_signal.burst(Priority.NONE, rate_hz)) / rate_hz
    assert lasts_s == pytest.approx(wanted, abs=0.01)
    machine.show(alarms=[], priority="none", audible="none", silent_s=0.0)
    drawn(page, machine)
    assert len(page.evaluate("window.sounded")) == 1


def test_what_must_be_done_stands_first_and_the_rest_in_a_list(bedside: Bedside) -> None:
    page = bedside.page
    first, second = alarm(Condition.VALVE_STUCK_OPEN), alarm(Condition.CATHETER_LIFE_ENDING)
    bedside.machine.show(**alarming(first, {**second, "acknowledged": True}))
    expect(page.locator(".alarm-first")).to_contain_text("Look at the patient.")
    size = page.locator(".alarm-first").evaluate(
        "one => parseFloat(getComputedStyle(one).fontSize)"
    )
    others = page.locator(".alarm-kind, .alarm-rest").evaluate_all(
        "all => all.map(one => parseFloat(getComputedStyle(one).fontSize))"
    )
    assert size > 1.5 * max(others)
    page.get_by_role("button", name="1 more").click()
    rows = page.locator(".alarm-rows li")
    expect(rows).to_have_count(2)
    expect(rows.nth(0)).to_contain_text("suction valve does not close, or")
    expect(rows.nth(1)).to_contain_text("Acknowledged")


def test_alarms_are_answered(clinician: Bedside) -> None:
    page, machine = clinician.page, clinician.machine
    page.get_by_text("kim, clinician").wait_for()
    machine.show(**alarming(alarm(Condition.SPO2_LOW)))
    page.get_by_role("button", name="Acknowledge", exact=True).click()
    page.get_by_role("button", name="Pause sound", exact=True).click()
    until(page, lambda: len(machine.asked) == 2)
    assert [one["ask"] for one in machine.asked] == ["acknowledge", "audio-pause"]
    told = alarming(alarm(Condition.SPO2_LOW, acknowledged=True), pause_left_s=88.0)
    machine.show(**{**told, "audible": "none"})
    expect(page.get_by_role("button", name="Acknowledge", exact=True)).to_be_hidden()
    expect(page.locator(".alarm-kind")).to_contain_text("Acknowledged")
    expect(page.get_by_role("button", name="Sound paused: 1:28")).to_be_visible()


def test_who_has_not_signed_in_is_asked_to(bedside: Bedside) -> None:
    bedside.machine.show(**alarming(alarm(Condition.SPO2_LOW)))
    bedside.page.get_by_role("button", name="Acknowledge", exact=True).click()
    expect(bedside.page.get_by_role("dialog", name="Sign in")).to_be_visible()
    assert bedside.machine.asked == []


def test_an_observer_cannot_answer(bedside: Bedside) -> None:
    bedside.machine.sign_in(Role.OBSERVER)
    bedside.page.reload()
    bedside.page.get_by_text("kim, observer").wait_for()
    bedside.machine.show(**alarming(alarm(Condition.SPO2_LOW)))
    bedside.page.locator(".alarm-kind").get_by_text("HIGH").wait_for()
    expect(bedside.page.get_by_role("button", name="Acknowledge", exact=True)).to_be_hidden()
    expect(bedside.page.locator("#stop")).to_be_enabled()


@pytest.mark.real_time
@pytest.mark.parametrize("way", ["mute", "down"])
def test_a_lost_connection_is_shown_within_two_seconds(bedside: Bedside, way: str) -> None:
    page, machine = bedside.page, bedside.machine
    machine.show(phase="inserting", moving="in", **INSIDE)
    page.locator(".phase-word").get_by_text("Inserting").wait_for()
    setattr(machine, way, True)
    page.locator(".alarm-kind").get_by_text("NO CONNECTION TO THE MACHINE").wait_for(
        timeout=LOST_MS
    )
    expect(page.locator(".alarm-bar")).to_have_attribute("data-priority", "high")
    expect(page.locator(".alarm-first")).to_contain_text("Watch the patient and the machine")
    assert page.locator(".tip .figure").evaluate(
        "one => getComputedStyle(one).textDecorationLine"
    ) == ("line-through")
    expect(page.locator(".stale-note")).to_contain_text("old")
    expect(page.get_by_role("button", name="Silence this page")).to_be_visible()
    expect(page.locator("#start")).to_have_attribute("aria-disabled", "true")
    setattr(machine, way, False)
    page.get_by_text("Live", exact=True).wait_for(timeout=8000)
    expect(page.locator(".alarm-first")).to_have_text("No alarms")
    expect(page.locator(".stale-note")).to_be_empty()


@pytest.mark.real_time
def test_a_control_that_is_silent_is_no_live_value(bedside: Bedside) -> None:
    page, machine = bedside.page, bedside.machine
    machine.show(phase="inserting", moving="in", **INSIDE)
    page.locator(".phase-word").get_by_text("Inserting").wait_for()
    gone = dict.fromkeys(machine.state) | {"connected": False, "age_s": 3.0, "phase": "unknown"}
    machine.state = gone | alarming(alarm(Condition.AUTOMATION_STOPPED))
    page.locator(".alarm-kind").get_by_text("CONTROL DOES NOT ANSWER").wait_for(timeout=LOST_MS)
    expect(page.locator(".alarm-first")).to_contain_text("Look at the patient.")
    expect(page.locator(".bedside")).to_have_attribute("data-stale", "")
    machine.show(age_s=4.0)  # it is served, but nobody writes it any more
    expect(page.locator(".link")).to_contain_text("Control silent, 4 s")


def test_a_refused_sound_is_told_and_allowed_by_a_touch(bedside: Bedside) -> None:
    page = bedside.page
    button = page.get_by_role("button", name="Touch to allow sound")
    expect(button).to_be_visible()
    button.click()
    expect(button).to_be_hidden()


def test_with_less_motion_a_border_flashes(bedside: Bedside) -> None:
    page = bedside.page
    page.emulate_media(reduced_motion="reduce")
    bedside.machine.show(**alarming(alarm(Condition.SPO2_LOW)))
    lamp = page.locator(".alarm-lamp[data-lit]")
    lamp.wait_for(state="attached")
    width, fill, runs = lamp.evaluate(
        """one => { const style = getComputedStyle(one); return [parseFloat(style.borderTopWidth),
            style.backgroundColor, one.getAnimations().length]; }"""
    )
    assert width > 5.0
    assert fill == "rgba(0, 0, 0, 0)"
    assert runs == 1
