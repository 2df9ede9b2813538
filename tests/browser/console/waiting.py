"""Waiting beside a page: what a test asks of the machine comes over a network."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tests.browser.console.fake_machine import FakeMachine

LOOKS_MS = 20.0
TWO_FRAMES = "() => new Promise((then) => requestAnimationFrame(() => requestAnimationFrame(then)))"


def until(page: "Page", holds: Callable[[], bool], within_s: float = 30.0) -> None:
    """Let the page work until something holds. Raises AssertionError where it never does."""
    ends_s = time.monotonic() + within_s
    while not holds():
        assert time.monotonic() < ends_s, f"not within {within_s:g} s"
        page.wait_for_timeout(LOOKS_MS)


def drawn(page: "Page", machine: "FakeMachine") -> None:
    """Wait until the page has been sent what the machine shows now, and has drawn it."""
    before = machine.told
    until(page, lambda: machine.told > before + 1)
    page.evaluate(TWO_FRAMES)
