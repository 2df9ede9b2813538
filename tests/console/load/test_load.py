"""Load of many pages: accounts, and figures of minutes.

Speed depends on the computer, too, so the short run asserts on no time. Results:
docs/evidence/2026-11-23-console-load.md.
"""

import os
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.console.load import load_run
from tests.console.load.browser_page import Drawn, blank, drawn, opened
from tests.console.load.console_machine import ConsoleMachine, console_machine, cpu_s
from tests.console.load.load_run import CHANNELS, NOBODY

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.real_time

FOLDER = Path("runs") / "soak"
LIVE, SIGNALS = 20, 5
"""Pages that look at the bedside; how many of them look at signals, too."""


@pytest.mark.soak
def test_every_row_comes_to_every_page_and_every_press_to_the_loop() -> None:
    with console_machine() as machine:
        with load_run.pages(machine, live=4, signals=3) as end:
            pressed = load_run.stops(machine, count=5)
            looked = load_run.stretch(machine, 2.0)
            came = end()
        assert pressed.lost == 0
        assert looked.ticks > 0
        assert came.gaps == 0
        assert came.frames > 3
        assert came.rows + came.missed >= 3 * looked.ticks
        assert came.states > 4


@contextmanager
def twenty(machine: ConsoleMachine, browser: "Browser | None") -> Iterator[None]:
    """Twenty pages; with a browser two of them are in Chromium."""
    with ExitStack() as stack:
        if browser is not None:
            stack.enter_context(opened(browser, machine, "signals", "engineer"))
            stack.enter_context(opened(browser, machine, "bedside", "clinician"))
        others = 0 if browser is None else 2
        stack.enter_context(load_run.pages(machine, LIVE - others, SIGNALS - others // 2))
        yield


def one_page(machine: ConsoleMachine, browser: "Browser", seconds: float) -> tuple[Drawn, float]:
    """What one page of eight signals draws, and the cores that the console takes for it."""
    granted = blank(browser)
    with opened(browser, machine, "signals", "engineer") as page:
        page.wait_for_timeout(12_000.0)
        begun_s, used_s = time.monotonic(), cpu_s(machine.console.pid)
        found = drawn(page, seconds, granted)
        return found, (cpu_s(machine.console.pid) - used_s) / (time.monotonic() - begun_s)


@pytest.mark.soak
@pytest.mark.browser
def test_figures_of_a_console_with_twenty_pages(chromium: "Browser") -> None:
    with console_machine() as machine:
        loads = [os.getloadavg()[0]]
        alone = load_run.stretch(machine, 10.0)
        one = [one_page(machine, chromium, 15.0) for _ in range(3)]
        loads.append(os.getloadavg()[0])
        kinds = {
            "nobody": NOBODY,
            "twenty": lambda: twenty(machine, None),
            "twenty, two of them in Chromium": lambda: twenty(machine, chromium),
        }
        found = load_run.alternate(machine, kinds, rounds=6, seconds=12.0)
        loads.append(os.getloadavg()[0])
        with twenty(machine, None):
            time.sleep(load_run.SETTLES_S)
            pressed = load_run.stops(machine, count=300)
        with load_run.pages(machine, LIVE, SIGNALS) as end:
            time.sleep(20.0)
            came = end()
        figures = {
            "channels": list(CHANNELS),
            "console_alone_cores": alone.console_cores,
            "one_page": [{**seen._asdict(), "console_cores": cores} for seen, cores in one],
            "load_of_the_last_minute": [*loads, os.getloadavg()[0]],
            "stretches": {name: [one._asdict() for one in of] for name, of in found.items()},
            "stop": pressed._asdict(),
            "twenty_pages_got": came._asdict(),
        }
        load_run.write(FOLDER, figures)
    assert sum(seen.missed for seen, _ in one) == 0
    # The best of three: of a busy computer a browser gets what is left.
    assert max(seen.pictures_per_s for seen, _ in one) >= 30.0
    assert max(cores for _, cores in one) < 0.15
    assert came.gaps == 0
    assert pressed.lost == 0
    assert pressed.p99_ms < 100.0
