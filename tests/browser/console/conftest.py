"""A page of the console in the system's Chromium, beside a machine that plays states."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import pytest

from tests.browser.console.fake_machine import FakeMachine, serve

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

TABLET = {"width": 1280, "height": 800}


class Bedside(NamedTuple):
    """A page, the machine that it shows, and what the browser complained of."""

    page: "Page"
    machine: FakeMachine
    url: str
    complaints: list[str]


@pytest.fixture
def fake() -> Iterator[tuple[FakeMachine, str]]:
    machine = FakeMachine()
    with serve(machine) as url:
        yield machine, url


@pytest.fixture
def bedside(chromium: "Browser", fake: tuple[FakeMachine, str]) -> Iterator[Bedside]:
    """The bedside view of somebody who has not signed in."""
    machine, url = fake
    context = chromium.new_context(viewport=TABLET)  # type: ignore[arg-type]
    page = context.new_page()
    shown = Bedside(page, machine, url, [])
    page.on("console", lambda said: shown.complaints.append(said.text))
    page.on("pageerror", lambda error: shown.complaints.append(str(error)))
    page.goto(url)
    page.get_by_text("Live", exact=True).wait_for()
    page.locator(".live-anatomy").wait_for()
    yield shown
    context.close()
