"""The page beside the real server: accounts, rights, alarms, what the machine is really asked."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest
from playwright.sync_api import expect

from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.safety.condition import Condition
from tests.browser.conftest import TABLET
from tests.browser.console.waiting import until
from tests.console.listening import listening
from tests.console.served import PEOPLE, Served

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = [pytest.mark.browser, pytest.mark.sweep]

SAID_MS = 4000
"""For so long a page says what came of a button."""


class Beside(NamedTuple):
    page: "Page"
    served: Served


@pytest.fixture
def beside(chromium: "Browser", tmp_path: Path) -> Iterator[Beside]:
    with listening(tmp_path) as served:
        context = chromium.new_context(viewport=TABLET)  # type: ignore[arg-type]
        page = context.new_page()
        page.goto(served.url)
        page.get_by_text("Live", exact=True).wait_for()
        page.locator(".live-anatomy").wait_for()
        yield Beside(page, served)
        context.close()


def sign_in(beside: Beside, role: str) -> None:
    page, name = beside.page, PEOPLE[role]
    page.get_by_role("button", name="Sign in").click()
    dialog = page.get_by_role("dialog", name="Sign in")
    dialog.get_by_label("Name").fill(name)
    dialog.get_by_label("Password").fill(beside.served.password(role))
    page.keyboard.press("Enter")
    page.get_by_role("button", name=f"{name}, ").wait_for()


def hold_start(page: "Page") -> None:
    page.locator("#start").focus()
    page.keyboard.down("Enter")
    page.wait_for_timeout(1300)
    page.keyboard.up("Enter")


@pytest.mark.real_time
def test_a_clinician_starts_and_a_start_that_is_refused_says_why(beside: Beside) -> None:
    page, machine = beside.page, beside.served.machine
    sign_in(beside, "clinician")
    page.clock.install()
    hold_start(page)
    expect(page.locator(".start-why")).to_contain_text("Started")
    assert machine.pressed == [("start", PEOPLE["clinician"])]
    page.clock.fast_forward(SAID_MS)
    expect(page.locator(".start-why")).not_to_contain_text("Started")
    expect(page.locator(".bedside[data-stale]")).to_have_count(0)
    machine.refusal = int(Refusal.NOT_TAUGHT)
    hold_start(page)
    expect(page.locator(".start-why")).to_contain_text("no travel length has been set")


@pytest.mark.real_time
def test_anybody_stops(beside: Beside) -> None:
    page, machine = beside.page, beside.served.machine
    machine.set({"outputs.phase": float(Phase.INSERTING)})
    page.locator(".phase-word").get_by_text("Inserting").wait_for()
    page.locator("#stop").click()
    expect(page.locator(".stop-status")).to_contain_text("Stop received: Inserting")
    assert [ask for ask, _ in machine.pressed] == ["abort"]
    machine.answers = False
    page.keyboard.press("F8")
    page.locator(".not-stopped").wait_for(timeout=2000)
    expect(page.locator(".not-stopped")).to_contain_text("NOBODY HEARS THE STOP")
    machine.answers = True
    expect(page.locator(".not-stopped")).to_be_hidden(timeout=5000)


def test_an_alarm_is_shown_and_acknowledged(beside: Beside) -> None:
    page, machine = beside.page, beside.served.machine
    sign_in(beside, "engineer")
    machine.raise_alarm(Condition.SPO2_LOW, Condition.CATHETER_LIFE_ENDING)
    expect(page.locator(".alarm-bar")).to_have_attribute("data-priority", "high")
    expect(page.locator(".alarm-first")).to_have_text("Look at the patient. Give oxygen.")
    page.get_by_role("button", name="Acknowledge", exact=True).click()
    page.get_by_role("button", name="Pause sound", exact=True).click()
    until(page, lambda: len(machine.pressed) == 2)
    assert [ask for ask, _ in machine.pressed] == ["acknowledge", "audio_pause"]


@pytest.mark.parametrize("role", ["observer", "engineer"])
def test_who_may_not_start_does_not(beside: Beside, role: str) -> None:
    page = beside.page
    sign_in(beside, role)
    expect(page.locator(".start-why")).to_contain_text("only a clinician starts")
    hold_start(page)
    told = page.evaluate(
        """async () => {
            const csrf = (await (await fetch('api/v1/session')).json()).csrf;
            const answer = await fetch('api/v1/requests', { method: 'POST', headers: {
                'Content-Type': 'application/json', 'X-CSRF-Token': csrf },
                body: JSON.stringify({ ask: 'start', key: '0123456789abcdef' }) });
            return answer.status;
        }"""
    )
    assert told == 403
    assert beside.served.machine.pressed == []


def test_a_catheter_that_is_left_inside_is_drawn_and_told(beside: Beside) -> None:
    page, machine = beside.page, beside.served.machine
    machine.place(30.0)
    machine.set({"outputs.phase": float(Phase.HALTED)})
    machine.raise_alarm(Condition.WITHDRAWAL_BLOCKED)
    expect(page.locator(".alarm-first")).to_contain_text("CATHETER IS STILL IN THE AIRWAY, 30 mm")
    expect(page.locator(".tip .figure")).to_have_text("30")


@pytest.mark.real_time
def test_a_machine_that_dies_is_told_within_two_seconds(beside: Beside) -> None:
    page = beside.page
    beside.served.machine.stop()
    page.locator(".alarm-kind").get_by_text("CONTROL DOES NOT ANSWER").wait_for(timeout=2000)
    expect(page.locator(".bedside")).to_have_attribute("data-stale", "")


def test_an_administrator_adds_somebody_who_signs_in(beside: Beside) -> None:
    page = beside.page
    sign_in(beside, "administrator")
    page.get_by_role("link", name="People").click()
    page.get_by_role("button", name="Add an account").click()
    dialog = page.get_by_role("dialog", name="Add an account")
    dialog.get_by_label("Name").fill("Not A Name")
    dialog.get_by_role("button", name="Add", exact=True).click()
    expect(dialog.locator(".field-wrong").first).to_contain_text("2 to 32 small letters")
    dialog.get_by_label("Name").fill("dora")
    dialog.get_by_role("button", name="Add", exact=True).click()
    secret = page.locator(".secret").inner_text()
    page.get_by_role("button", name="Close").click()
    page.get_by_role("row", name="dora").wait_for()
    page.get_by_role("button", name="Change role: dora").click()
    dialog = page.get_by_role("dialog", name="Role of dora")
    dialog.get_by_label("Role").select_option("observer")
    dialog.get_by_label("Reason").fill("dora only looks after the ward list")
    dialog.get_by_role("button", name="Save").click()
    expect(page.get_by_role("row", name="dora")).to_contain_text("observer")
    page.get_by_role("button", name="Issue a token").click()
    dialog = page.get_by_role("dialog", name="Issue a token")
    dialog.get_by_label("What it is for").fill("ward list")
    dialog.get_by_role("button", name="Issue", exact=True).click()
    page.get_by_role("dialog", name="Token ward list").wait_for()
    page.get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Revoke: ward list").click()
    page.get_by_role("dialog").get_by_role("button", name="Revoke").click()
    expect(page.get_by_role("row", name="ward list")).to_be_hidden()
    page.get_by_role("button", name="Deactivate: dora").wait_for()
    page.locator(".sign").click()
    page.locator(".sign").get_by_text("Sign in").click()
    dialog = page.get_by_role("dialog", name="Sign in")
    dialog.get_by_label("Name").fill("dora")
    dialog.get_by_label("Password").fill("wrong")
    page.keyboard.press("Enter")
    expect(dialog).to_contain_text("name or password is wrong")
    dialog.get_by_label("Password").fill(secret)
    page.keyboard.press("Enter")
    dialog = page.get_by_role("dialog", name="Choose a password")
    dialog.get_by_label("New password", exact=True).fill("short")
    dialog.get_by_label("New password again").fill("short")
    dialog.get_by_role("button", name="Change it").click()
    expect(dialog).to_contain_text("15 to 128 are taken")
    for label in ("New password", "New password again"):
        dialog.get_by_label(label, exact=True).fill("seven herons in a green boat")
    dialog.get_by_role("button", name="Change it").click()
    expect(page.get_by_role("button", name="dora, observer")).to_be_visible()
    expect(dialog).to_be_hidden()
