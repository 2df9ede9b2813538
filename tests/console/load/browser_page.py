"""Pages in a real Chromium, and what they draw."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from tests.console.load.console_machine import ConsoleMachine

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page

TABLET = {"width": 1280, "height": 800}
FIGURES = "({...document.querySelector('.signals').figures})"


BLANK = """() => new Promise((done) => {
    const begun = performance.now();
    let count = 0;
    const turn = () => {
        count += 1;
        const lasted = (performance.now() - begun) / 1000;
        if (lasted > 5) done(count / lasted); else requestAnimationFrame(turn);
    };
    requestAnimationFrame(turn);
})"""
"""Turns a second of a page on which there is nothing to draw."""


class Drawn(NamedTuple):
    """By the page's own count, which it makes where it draws and where it takes rows."""

    seconds: float
    pictures_per_s: float
    rows_per_s: float
    missed: int
    blank_per_s: float
    """Turns that a blank page of the same browser gets, just before: what the computer grants."""


def blank(browser: "Browser") -> float:
    """See `Drawn`."""
    context = browser.new_context()
    try:
        return float(context.new_page().evaluate(BLANK))
    finally:
        context.close()


@contextmanager
def signed_in(browser: "Browser", machine: ConsoleMachine, role: str) -> Iterator["BrowserContext"]:
    """A browser in which somebody of a role has signed in; its pages load the files once."""
    context = browser.new_context(viewport=TABLET)  # type: ignore[arg-type]
    try:
        context.add_cookies(machine.browser_cookies(role))  # type: ignore[arg-type]
        yield context
    finally:
        context.close()


def show(context: "BrowserContext", machine: ConsoleMachine, view: str) -> "Page":
    """A page of it with a view of the console."""
    page = context.new_page()
    page.goto(f"{machine.url}/#/{view}")
    page.locator(f".{view}").wait_for()
    return page


@contextmanager
def opened(browser: "Browser", machine: ConsoleMachine, view: str, role: str) -> Iterator["Page"]:
    """A view of the console, as somebody of a role sees it."""
    with signed_in(browser, machine, role) as context:
        yield show(context, machine, view)


def drawn(page: "Page", seconds: float, blank_per_s: float) -> Drawn:
    """What a view of signals draws for so long. blank_per_s: measured beside."""
    before, begun_s = page.evaluate(FIGURES), time.monotonic()
    page.wait_for_timeout(1000.0 * seconds)
    after, lasted_s = page.evaluate(FIGURES), time.monotonic() - begun_s
    return Drawn(
        seconds=lasted_s,
        pictures_per_s=(after["frames"] - before["frames"]) / lasted_s,
        rows_per_s=(after["rows"] - before["rows"]) / lasted_s,
        missed=after["missed"] - before["missed"],
        blank_per_s=blank_per_s,
    )
