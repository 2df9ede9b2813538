"""A page of the console in the system's Chromium, beside a machine that plays states."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import pytest

from opensuction.accounts.rule.right import Role
from tests.browser.console.fake_machine import FakeMachine, FakeServer, serve

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext, Page


class Bedside(NamedTuple):
    """A page, the machine that it shows, and what the browser complained of."""

    page: "Page"
    machine: FakeMachine
    url: str
    complaints: list[str]


@pytest.fixture(scope="package")
def fake_server() -> Iterator[FakeServer]:
    with serve() as server:
        yield server


@pytest.fixture
def fake(fake_server: FakeServer) -> Iterator[tuple[FakeMachine, str]]:
    with fake_server.playing() as machine:
        yield machine, fake_server.url


@pytest.fixture
def bedside(tablet: "BrowserContext", fake: tuple[FakeMachine, str]) -> Iterator[Bedside]:
    """The bedside view of somebody who has not signed in."""
    yield from _shown(tablet, *fake)


@pytest.fixture
def clinician(tablet: "BrowserContext", fake: tuple[FakeMachine, str]) -> Iterator[Bedside]:
    """The bedside view of a clinician who has signed in."""
    fake[0].sign_in(Role.CLINICIAN)
    yield from _shown(tablet, *fake)


@pytest.fixture(scope="module")
def modules(tablet: "BrowserContext", fake_server: FakeServer) -> Iterator["Page"]:
    """A page for the console's modules alone: it shows nothing, and asks for nothing."""
    page = tablet.new_page()
    page.goto(f"{fake_server.url}js/clock.js")  # as text
    yield page
    page.close()


def _shown(context: "BrowserContext", machine: FakeMachine, url: str) -> Iterator[Bedside]:
    page = context.new_page()
    shown = Bedside(page, machine, url, [])
    page.on("console", lambda said: shown.complaints.append(said.text))
    page.on("pageerror", lambda error: shown.complaints.append(str(error)))
    page.goto(url)
    page.get_by_text("Live", exact=True).wait_for()
    page.locator(".live-anatomy").wait_for()
    yield shown
    page.evaluate("localStorage.clear()")  # what is kept for longer than a page: its colours
    page.close()
    context.clear_permissions()
