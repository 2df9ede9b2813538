"""One browser for all files of this folder that a process runs one after the other."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.conftest import CHROMIUM_OPTIONS, Component

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Playwright

TABLET = {"width": 1280, "height": 800}
ONE_PROCESS = ("--disable-site-isolation-trials", "--renderer-process-limit=1")
"""The pages of a context share a process: each finds the programs of those before it compiled."""


class LivingBrowser:
    """The system's Chromium, which is started anew where it has gone."""

    def __init__(self, playwright: "Playwright", program: Path) -> None:
        self._playwright, self._program = playwright, program
        self._browser: Browser | None = None
        self._tablet: BrowserContext | None = None

    def browser(self) -> "Browser":
        """One that answers."""
        if self._browser is None or not self._browser.is_connected():
            self._browser = self._playwright.chromium.launch(
                executable_path=self._program, args=[*CHROMIUM_OPTIONS, *ONE_PROCESS]
            )
            self._tablet = None
        return self._browser

    def tablet(self) -> "BrowserContext":
        """A context of the size of a tablet, with an empty page that keeps its process alive."""
        browser = self.browser()
        if self._tablet is None:
            self._tablet = browser.new_context(viewport=TABLET)  # type: ignore[arg-type]
            self._tablet.new_page()
        return self._tablet

    def close(self) -> None:
        """End it; no test is blamed for one that has gone by itself."""
        from playwright.sync_api import Error

        if self._browser is not None:
            with suppress(Error):
                self._browser.close()


@pytest.fixture(scope="package")
def living_browser(component: Component) -> Iterator[LivingBrowser]:
    """It ends before a file of another folder begins: one that is idle may not live to the end."""
    program = component("chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = LivingBrowser(playwright, program)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def chromium(living_browser: LivingBrowser) -> "Browser":
    """The system's Chromium, headless, driven by Playwright."""
    return living_browser.browser()


@pytest.fixture(scope="module")
def tablet(living_browser: LivingBrowser) -> "BrowserContext":
    """What the pages share: the files of the console, which are loaded once."""
    return living_browser.tablet()
