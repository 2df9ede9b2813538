"""One clock on the page, the machine's: the device in front of a person may show any time."""

import re
from datetime import timedelta
from typing import TYPE_CHECKING, Any

import pytest
from playwright.sync_api import expect

from tests.browser.console.conftest import Bedside

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = pytest.mark.browser

SHOWS = """ahead_ms => {
    const at = (more_ms) => new Date(Date.now() + ahead_ms + more_ms).toLocaleTimeString(
        [], { hour: "2-digit", minute: "2-digit", second: "2-digit", hour12: false });
    const shown = document.querySelector(".clock").textContent;
    return [-2000, -1000, 0, 1000, 2000].some((more_ms) => at(more_ms) === shown);
}"""
"""The header shows the time of a clock so far ahead of the browser's, within two seconds."""

UNTOLD = re.compile("^(Connecting|No connection)$")
"""The state of a page that nobody has told anything: it waits, and soon it has waited too long."""

SECONDS = """() => new Promise((then) => {
    let seen = 0;
    new MutationObserver(() => { seen += 1; if (seen === 5) then(); })
        .observe(document.querySelector(".clock"), { childList: true });
})"""
"""So many are shown that a difference would have been told."""


@pytest.mark.parametrize(
    ("ahead", "said"),
    [
        (timedelta(hours=3), "This device's clock is 3 h behind the machine's."),
        pytest.param(
            -timedelta(minutes=61),
            "This device's clock is 61 min ahead of the machine's.",
            marks=pytest.mark.soak,
        ),
        pytest.param(
            timedelta(seconds=7.2),
            "This device's clock is 7 s behind the machine's.",
            marks=pytest.mark.sweep,
        ),
        (timedelta(seconds=2.5), ""),
    ],
)
def test_the_header_shows_the_machines_time_and_says_that_the_devices_is_another(
    bedside: Bedside, ahead: timedelta, said: str
) -> None:
    page = bedside.page
    bedside.machine.ahead = ahead
    page.reload()
    page.wait_for_function(SHOWS, arg=ahead / timedelta(milliseconds=1))
    told = page.locator(".clock-apart")
    if said:
        expect(told).to_contain_text(said)
        expect(told).to_contain_text("Times here are the machine's.")
        return
    page.evaluate(SECONDS)
    expect(told).to_be_empty()


def test_a_difference_that_is_mended_is_not_said_any_more(bedside: Bedside) -> None:
    page, machine = bedside.page, bedside.machine
    machine.ahead = timedelta(hours=1)
    page.reload()
    expect(page.locator(".clock-apart")).to_contain_text("60 min behind")
    machine.ahead = timedelta()
    machine.show(tick=0)  # another controller, begun by a clock that is right
    expect(page.locator(".clock-apart")).to_be_empty()
    page.wait_for_function(SHOWS, arg=0)


def test_before_the_machine_has_told_the_time_none_is_shown(bedside: Bedside) -> None:
    bedside.machine.mute = True
    bedside.page.reload()
    bedside.page.get_by_text(UNTOLD).first.wait_for()
    expect(bedside.page.locator(".clock")).to_have_text("\u2013")


def hear(modules: "Page", script: str) -> Any:
    """What a script gives that has a clock to itself."""
    return modules.evaluate(
        f"""async () => {{
        const {{ hearTime, machineNow }} = await import(`/js/clock.js?${{performance.now()}}`);
        const told = (tick, utc_ms, now_ms, age_s = 0, connected = true) => hearTime(
            {{ tick, utc: new Date(utc_ms).toISOString(), age_s, connected }}, now_ms);
        {script} }}"""
    )


def test_messages_that_come_late_turn_no_clock_back(modules: "Page") -> None:
    found = hear(
        modules,
        """
        told(1, 100000, 1000);
        const shown = [];
        for (let now = 1050; now < 9000; now += 50) {
            const late = now > 3000 && now < 6000 ? 0.9 * (now - 3000) : (now % 7) * 10;
            told(now, 99000 + now - late, now);
            shown.push(machineNow(now) - now);
        }
        return [Math.min(...shown), Math.max(...shown)];
        """,
    )
    assert found == [99000, 99000]


def test_the_age_of_what_is_told_is_no_time_of_the_machine(modules: "Page") -> None:
    found = hear(
        modules,
        """
        told(1, 100000, 1000, 0.4);
        const first = machineNow(1000);
        told(2, 100000, 1100, 900, false); // nobody controls: the console tells its own time
        return [first, machineNow(1100)];
        """,
    )
    assert found == [100400, 100500]


def test_a_clock_that_goes_another_way_is_followed(modules: "Page") -> None:
    found = hear(
        modules,
        """
        told(500, 100000, 1000);
        told(0, 40000, 2000);
        const restarted = machineNow(2000);
        for (let now = 3000; now < 60000; now += 1000) told(now, 30000 + now, now);
        const drifted = machineNow(60000);
        hearTime({ tick: 60000, utc: "nonsense", age_s: 0, connected: true }, 60100);
        return [restarted, drifted, machineNow(60100)];
        """,
    )
    assert found == [40000, 90000, 90100]
