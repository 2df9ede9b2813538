"""A tab that nobody sees: a lost connection is told, and sounds, as soon as in one that is seen."""

import time
from typing import TYPE_CHECKING, Any

import pytest

from tests.browser.console.fake_machine import FakeMachine
from tests.browser.console.hidden_tab import EARLY, FREEZES, HiddenTab, open_tab
from tests.conftest import Component

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.real_time, pytest.mark.browser]

WATCH = """(() => {
    const now = () => performance.timeOrigin + performance.now();
    const seen = window.seen = { beats: 0, lost: [], live: [], sounds: [] };
    setInterval(() => { seen.beats += 1; }, 200);
    const note = (name, place, words) => new MutationObserver(() => {
        if (document.querySelector(place).textContent.includes(words)) seen[name].push(now());
    }).observe(document.querySelector(place), { childList: true });
    note("lost", ".alarm-kind", "NO CONNECTION");
    note("live", ".link", "Live");
    const start = AudioBufferSourceNode.prototype.start;
    AudioBufferSourceNode.prototype.start = function (...given) {
        seen.sounds.push(now());
        return start.apply(this, given);
    };
})()"""
"""Notes when what is said changes, when something sounds, and how often a timer of a page acts."""
NOTHING_WRONG = "document.querySelector('.alarm-bar').dataset.priority === 'none'"
WAYS = ("mute", "down")
"""A machine says nothing any more, or is gone."""
LOST_S = 2.0
ONCE_MORE_S = 8.0
LONG_S = 420.0
"""Timers act once a minute from then on, as they do after 5 s by `EARLY`."""
LOOKS_S = 2.5
"""Of the dozen beats of such a time at most one comes."""
A_MINUTE_S = 60.0


def wait(tab: HiddenTab, expression: str, within_s: float) -> None:
    ends_s = time.monotonic() + within_s
    while not tab.evaluate(expression):
        assert time.monotonic() < ends_s, f"not within {within_s:g} s: {expression}"
        time.sleep(0.1)


def seen(tab: HiddenTab) -> dict[str, Any]:
    found: dict[str, Any] = tab.evaluate("window.seen")
    return found


def prove_frozen(tab: HiddenTab, url: str) -> None:
    """Wait until this browser has halted a page that is hidden for no longer."""
    other = tab.open_another(f"{url}icon.svg")
    wait(other, "document.readyState === 'complete'", 30.0)
    other.evaluate("addEventListener('freeze', () => { window.isFrozen = true; }, true)")
    other.hide()
    wait(other, "window.isFrozen === true", A_MINUTE_S)


def prove_throttled(tab: HiddenTab) -> None:
    """Wait until its timers act once a minute."""
    ends_s, beats = time.monotonic() + A_MINUTE_S, -1
    while seen(tab)["beats"] - beats > 1:
        assert time.monotonic() < ends_s, "the browser does not throttle: nothing is shown"
        beats = seen(tab)["beats"]
        time.sleep(LOOKS_S)


def lose(
    chromium: "Browser",
    component: Component,
    url: str,
    machine: FakeMachine,
    *more: str,
    hidden_s: float = 0.0,
) -> None:
    """Check how soon each loss is told, in a tab that has been hidden for so long before."""
    with open_tab(chromium, component, url, *more) as tab:
        wait(tab, "document.querySelector('.link')?.textContent === 'Live'", 30.0)
        machine.show(phase="inserting", moving="in", tip_mm=49.0, is_inside=True)
        wait(tab, NOTHING_WRONG, 5.0)
        tab.evaluate(WATCH)
        tab.hide()
        wait(tab, "document.visibilityState === 'hidden'", 5.0)
        time.sleep(hidden_s)
        if FREEZES in more:
            prove_frozen(tab, url)
        prove_throttled(tab)
        for way in WAYS:
            check(way, lose_once(tab, machine, way))


def lose_once(tab: HiddenTab, machine: FakeMachine, way: str) -> dict[str, list[float]]:
    """How long after the loss something was told, in s, and after its end that it is over."""
    tab.evaluate("Object.assign(window.seen, { lost: [], live: [], sounds: [] })")
    lost_s = time.time()
    setattr(machine, way, True)
    wait(tab, "window.seen.lost.length > 0", A_MINUTE_S + 5.0)
    # That it goes on sounding the first way shows; each takes 5 s.
    sounds = 2 if way == WAYS[0] else 1
    wait(tab, f"window.seen.sounds.length >= {sounds}", A_MINUTE_S + 5.0)
    assert tab.evaluate("document.visibilityState") == "hidden"
    assert tab.evaluate("document.title").startswith("No connection")
    back_s = time.time()
    setattr(machine, way, False)
    wait(tab, "window.seen.live.length > 0", A_MINUTE_S + 5.0)
    # Nothing sounds of this loss where the next one begins.
    wait(tab, NOTHING_WRONG, A_MINUTE_S + 5.0)
    found = seen(tab)
    told = {name: [at_ms / 1e3 - lost_s for at_ms in found[name]] for name in ("lost", "sounds")}
    return {**told, "live": [at_ms / 1e3 - back_s for at_ms in found["live"]]}


def check(way: str, told: dict[str, list[float]]) -> None:
    assert 0.0 < told["lost"][0] < LOST_S, (way, told)
    assert 0.0 < told["sounds"][0] < LOST_S, (way, told)
    assert 0.0 < told["live"][0] < ONCE_MORE_S, (way, told)


@pytest.mark.soak
def test_a_loss_is_told_and_sounds_within_two_seconds_where_nobody_looks(
    chromium: "Browser", component: Component, fake: tuple[FakeMachine, str]
) -> None:
    machine, url = fake
    lose(chromium, component, url, machine, EARLY)


@pytest.mark.soak
def test_a_loss_is_told_within_two_seconds_after_seven_minutes_behind_another_tab(
    chromium: "Browser", component: Component, fake: tuple[FakeMachine, str]
) -> None:
    machine, url = fake
    lose(chromium, component, url, machine, hidden_s=LONG_S)


@pytest.mark.sweep
def test_a_loss_is_told_within_two_seconds_by_a_browser_that_halts_hidden_pages(
    chromium: "Browser", component: Component, fake: tuple[FakeMachine, str]
) -> None:
    """It delays their timers, too, as the others do."""
    machine, url = fake
    lose(chromium, component, url, machine, FREEZES)
