"""What every test can use: components of the system, a browser, Hypothesis without surprises."""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import Phase, settings

if TYPE_CHECKING:
    from playwright.sync_api import Browser

Component = Callable[[str], Path]

COMPONENTS = {"chromium": ("chromium", "chromium-browser", "google-chrome")}
"""Programs outside the lock that some tests need: by which names each may be found."""

REQUIRED = "OPENSUCTION_REQUIRE_COMPONENTS"
"""Set to 1, a missing component fails its tests instead of skipping them."""

# No deadline: the first example of a test may compile the core for seconds. The same examples
# every time: a test that fails for one person fails for all; the long run draws new ones.
settings.register_profile("suite", deadline=None, derandomize=True, database=None)
settings.register_profile("soak", deadline=None, max_examples=5000, print_blob=True)
# A mutant only has to be noticed: the failing example need not be made small first.
settings.register_profile(
    "mutation",
    deadline=None,
    derandomize=True,
    database=None,
    max_examples=50,
    phases=(Phase.explicit, Phase.generate),
)
settings.load_profile(os.environ.get("OPENSUCTION_HYPOTHESIS", "suite"))


@pytest.fixture(scope="session")
def component() -> Component:
    """Path of a program by the name of its component; skips, or fails, where it is missing."""

    def find(name: str) -> Path:
        for program in COMPONENTS[name]:
            found = shutil.which(program)
            if found is not None:
                return Path(found)
        missing = f"{name} is not installed; for example: apt-get install {name}"
        if os.environ.get(REQUIRED) == "1":
            pytest.fail(f"{missing} ({REQUIRED}=1 forbids to skip)")
        pytest.skip(missing)

    return find


@pytest.fixture(scope="session")
def chromium(component: Component) -> Iterator["Browser"]:
    """The system's Chromium, headless, driven by Playwright."""
    program = component("chromium")
    from playwright.sync_api import sync_playwright

    # Chromium's sandbox refuses root, and /dev/shm is 64 MB in containers. Only local pages here.
    arguments = ["--no-sandbox", "--disable-dev-shm-usage"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=arguments)
        yield browser
        browser.close()
