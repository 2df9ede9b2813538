"""Signing in, and people: who may do what is the machine's to say, the page tells it."""

import pytest
from playwright.sync_api import expect

from opensuction.accounts.rule.right import Role
from tests.browser.console.conftest import Bedside

pytestmark = [pytest.mark.browser, pytest.mark.sweep]


def sign_in(bedside: Bedside, name: str, password: str = "p") -> None:
    page = bedside.page
    page.get_by_role("button", name="Sign in").first.click()
    dialog = page.get_by_role("dialog", name="Sign in")
    dialog.get_by_label("Name").fill(name)
    dialog.get_by_label("Password").fill(password)
    page.keyboard.press("Enter")


def test_somebody_signs_in_and_out(bedside: Bedside) -> None:
    page = bedside.page
    expect(page.locator(".start-why")).to_contain_text("sign in first")
    sign_in(bedside, "clinician")
    expect(page.get_by_role("button", name="kim, clinician")).to_be_visible()
    expect(page.locator(".start-why")).to_be_hidden()
    page.get_by_role("button", name="Sign out").click()
    expect(page.locator(".start-why")).to_contain_text("sign in first")


def test_a_one_time_password_must_be_replaced(bedside: Bedside) -> None:
    page = bedside.page
    sign_in(bedside, "clinician", "one-time")
    dialog = page.get_by_role("dialog", name="Choose a password")
    expect(dialog).to_contain_text("must be replaced by one of your own")
    expect(page.locator(".start-why")).to_contain_text("choose a password of your own first")
    dialog.get_by_label("New password", exact=True).fill("one thing and another")
    dialog.get_by_label("New password again").fill("something else")
    dialog.get_by_role("button", name="Change it").click()
    expect(dialog).to_contain_text("The two are not the same")
    dialog.get_by_label("New password again").fill("one thing and another")
    dialog.get_by_role("button", name="Change it").click()
    expect(dialog).to_be_hidden()
    expect(page.locator(".start-why")).to_be_hidden()


def test_a_wait_after_failures_counts_down(bedside: Bedside) -> None:
    detail = "too many sign-ins failed: try again in 30 s"
    bedside.machine.problem = (429, {"detail": detail}, {"Retry-After": "30"})
    sign_in(bedside, "clinician")
    dialog = bedside.page.get_by_role("dialog", name="Sign in")
    expect(dialog).to_contain_text("too many sign-ins failed")
    expect(dialog.get_by_role("button", name="Wait 30 s")).to_be_disabled()
    expect(dialog.get_by_role("button", name="Wait 28 s")).to_be_disabled()


def test_a_session_that_has_ended_is_said(bedside: Bedside) -> None:
    page = bedside.page
    sign_in(bedside, "clinician")
    page.get_by_role("button", name="kim, clinician").wait_for()
    bedside.machine.show(passes=1)
    bedside.machine.person = None
    bedside.machine.problem = (401, {"detail": "sign in first"}, {})
    page.get_by_role("button", name="Patient assessed").click()
    expect(page.get_by_role("dialog", name="Sign in")).to_contain_text("Your session has ended")
    expect(page.get_by_role("button", name="kim, clinician")).to_be_hidden()


@pytest.mark.parametrize(
    "role", [Role.OBSERVER, pytest.param(Role.ENGINEER, marks=pytest.mark.soak)]
)
def test_who_may_not_start_is_told_so(bedside: Bedside, role: Role) -> None:
    sign_in(bedside, str(role))
    expect(bedside.page.locator(".start-why")).to_contain_text("only a clinician starts")


def test_views_that_need_a_right_say_so(bedside: Bedside) -> None:
    bedside.page.get_by_role("link", name="History").click()
    expect(bedside.page.locator(".view")).to_contain_text("Sign in to see History")
    expect(bedside.page.locator("#stop")).to_be_visible()
    expect(bedside.page.locator(".now")).to_contain_text("Parked")


def test_an_administrator_manages_people(bedside: Bedside) -> None:
    page = bedside.page
    sign_in(bedside, "engineer")
    page.get_by_role("link", name="People").click()
    expect(page.get_by_role("row", name="ada")).to_contain_text("clinician")
    expect(page.get_by_role("row", name="ben")).to_contain_text("one-time password")
    expect(page.get_by_role("row", name="ward list")).to_contain_text("see-history")
    start = page.get_by_role("row", name="Start a cycle").get_by_role("cell")
    expect(start).to_have_text(["\u2013no", "\u2013no", "✓yes", "\u2013no", "\u2013no"])
    page.get_by_role("button", name="Add an account").click()
    dialog = page.get_by_role("dialog", name="Add an account")
    dialog.get_by_label("Name").fill("cleo")
    dialog.get_by_role("button", name="Add", exact=True).click()
    expect(page.get_by_role("dialog", name="One-time password of cleo")).to_contain_text("k7-h2-m9")


def test_others_see_no_accounts(bedside: Bedside) -> None:
    sign_in(bedside, "clinician")
    bedside.page.get_by_role("link", name="People").click()
    expect(bedside.page.get_by_role("row", name="Start a cycle")).to_be_visible()
    expect(bedside.page.get_by_role("heading", name="Accounts")).to_be_hidden()
