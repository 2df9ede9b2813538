"""From the first password to a cycle's report, before the program as a ward runs it.

Nothing here is played: ``opensuction serve`` with its twin, controller, recorder and console. The
judge of the cycles is the records; that of the tip is the twin.
"""

import os
import re
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import httpx
import pytest
from playwright.sync_api import expect

from opensuction.ipc.liveness import holder
from opensuction.ipc.ring import RingReader
from opensuction.machine.twin.twin_process import PLAYS
from opensuction.records.records import Records
from opensuction.runtime import machine_folder
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from tests.browser.conftest import TABLET
from tests.cli.command import Process, begun, wait_for
from tests.console.served import free_port
from tests.runtime.machine_room import wait
from tests.runtime.room import INSIDE_MM

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = [pytest.mark.real_time, pytest.mark.browser]

ADMIN, CLINICIAN = "a ward at the end of the corridor", "seven swans over still water"
LONG_MS, LOST_MS = 90_000, 2500
NOTE_LOSS = """() => {
    const watch = new MutationObserver(() => {
        const said = document.querySelector(".alarm-kind")?.textContent ?? "";
        if (!said.includes("NO CONNECTION")) return;
        window.lost_ms = Date.now();
        watch.disconnect();
    });
    watch.observe(document.body, { subtree: true, childList: true, characterData: true });
}"""
"""The page itself notes when it said so: whoever asks it from outside may come late."""


class Ward(NamedTuple):
    name: str
    folder: Path
    port: int
    password: str
    """The administrator's first one."""
    program: Process

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}/"

    def tip_mm(self) -> float:
        """By the twin itself."""
        newest = RingReader(machine_folder.find(self.name) / "machine.ring").snapshot()
        assert newest is not None
        return float(newest[1][SHOWN_COLUMNS.index("truth.tip_mm")])

    def boundary_mm(self) -> float:
        """Above it the patient begins."""
        told = httpx.get(f"{self.url}api/v1/machine", timeout=10.0).json()
        return float(told["anatomy"]["boundary_mm"])

    def outcomes(self) -> list[str]:
        with Records.open(str(self.folder / "ward.db")) as records:
            found = records.history.list_cycles(self.name, 10)
        return [str(one.outcome) for one in reversed(found)]


@pytest.fixture
def ward(tmp_path: Path) -> Iterator[Ward]:
    """A machine that is served, and whom nobody has signed in to yet."""
    name, port = f"walk-{os.getpid()}", free_port()
    program = begun(
        *("serve", "--patient", "neonate", "--name", name, "--port", str(port)),
        *("--database", "ward.db", "--out", "kept"),
        cwd=tmp_path,
    )
    said = wait_for("Console:", program.stderr)
    found = re.search(r"as admin with the one-time password (\S+),", said)
    try:
        assert found, said
        yield Ward(name, tmp_path, port, found[1], program)
        program.send_signal(signal.SIGTERM)
        assert "ended in order" in program.communicate(timeout=60.0)[1]
    finally:
        program.kill()
        folder = machine_folder.make(name)
        for lock in (
            machine_folder.SUPERVISES,
            machine_folder.CONSOLES,
            machine_folder.RECORDS,
            machine_folder.CONTROLS,
            PLAYS,
        ):
            if (pid := holder(folder / lock)) is not None:
                os.kill(pid, signal.SIGKILL)
        machine_folder.clear(folder)
        folder.rmdir()


@pytest.fixture
def page(chromium: "Browser", ward: Ward) -> Iterator["Page"]:
    context = chromium.new_context(viewport=TABLET)  # type: ignore[arg-type]
    found = context.new_page()
    broken: list[str] = []
    found.on("pageerror", lambda error: broken.append(str(error)))
    found.goto(ward.url)
    found.get_by_text("Live", exact=True).wait_for()
    yield found
    context.close()
    assert broken == []


def sign_in(page: "Page", name: str, once: str, own: str) -> None:
    """For the first time."""
    page.locator("button.sign").click()
    page.fill("#field-name", name)
    page.fill("#field-password", once)
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="Choose a password").wait_for()
    page.fill("#field-wanted", own)
    page.fill("#field-repeat", own)
    page.keyboard.press("Enter")
    page.locator(".dialog").wait_for(state="detached")


def employ(page: "Page", name: str, role: str) -> str:
    """Make an account; its one-time password."""
    page.get_by_role("link", name="People").click()
    page.get_by_role("button", name="Add an account").click()
    page.fill("#field-name", name)
    page.locator("#field-role").select_option(role)
    page.get_by_role("button", name="Add", exact=True).click()
    page.get_by_role("heading", name=f"One-time password of {name}").wait_for()
    once = re.search(r"\b[a-z0-9]{5}(-[a-z0-9]{5}){3}\b", page.locator(".dialog").inner_text())
    assert once
    page.get_by_role("button", name="Close").last.click()
    return once[0]


def start(page: "Page") -> None:
    """Give oxygen, hold START, and see the machine begin."""
    page.locator(".rest .figure").get_by_text("none", exact=True).wait_for(timeout=4 * LONG_MS)
    given = page.get_by_role("button", name="Oxygen given")
    if given.is_visible():
        given.click()
        page.get_by_text("On record: oxygen given").wait_for()
    place = page.locator("#start").bounding_box()
    assert place is not None
    page.mouse.move(place["x"] + 30.0, place["y"] + 30.0)
    page.mouse.down()
    page.wait_for_timeout(1300)
    page.mouse.up()
    page.locator(".bedside:not([data-phase=parked])").wait_for()


def rest(page: "Page") -> str:
    """The phase in which the machine comes to rest."""
    page.locator(".bedside:is([data-phase=parked], [data-phase=halted])").wait_for(timeout=LONG_MS)
    return page.locator(".bedside").get_attribute("data-phase") or ""


def reset(page: "Page") -> None:
    """From halted to parked."""
    page.get_by_role("button", name="Reset").click()
    page.locator(".bedside[data-phase=parked]").wait_for()


def go_inside(page: "Page", ward: Ward) -> None:
    """Start, until the tip is in the patient."""
    start(page)
    assert wait(lambda: ward.tip_mm() > INSIDE_MM, 30.0)


def come_to_the_bed(page: "Page", ward: Ward) -> None:
    """Of a clinician, on a machine to which nobody has signed in before."""
    sign_in(page, "admin", ward.password, ADMIN)
    once = employ(page, "kim", "clinician")
    page.locator("button.sign").click()
    sign_in(page, "kim", once, CLINICIAN)
    page.get_by_role("link", name="Bedside").click()


@pytest.mark.sweep
def test_a_cycle_from_the_first_password_to_its_report(page: "Page", ward: Ward) -> None:
    """Watched to its end; in the middle of it the console hangs, dies and comes back by itself."""
    come_to_the_bed(page, ward)
    go_inside(page, ward)
    console = holder(machine_folder.find(ward.name) / machine_folder.CONSOLES)
    assert console is not None
    page.evaluate(NOTE_LOSS)
    hung_ms = 1e3 * time.time()
    # It hangs before it dies: a successor may be there before the page has to miss anything.
    os.kill(console, signal.SIGSTOP)
    page.locator(".alarm-kind").get_by_text("NO CONNECTION").wait_for()
    expect(page.locator(".bedside")).to_have_attribute("data-stale", "")
    assert page.evaluate("() => window.lost_ms") - hung_ms < LOST_MS
    os.kill(console, signal.SIGKILL)
    page.get_by_text("Live", exact=True).wait_for(timeout=LONG_MS)
    assert rest(page) == "parked"
    expect(page.locator(".tip .figure")).to_have_text("OUT")
    expect(page.locator(".last .figure")).to_have_text("Completed", timeout=20_000)
    assert ward.outcomes()[-1] == "completed"

    page.get_by_role("link", name="History").click()
    completed = page.locator("tbody tr").filter(has_text="completed").first
    expect(completed).to_contain_text("kim")
    completed.locator("a").click()
    page.get_by_role("link", name="Report").or_(page.get_by_role("button", name="Report")).click()
    report = page.frame_locator("iframe")
    report.get_by_text("not a medical device").first.wait_for(timeout=LONG_MS)
    expect(page.locator("#stop")).to_be_visible()


@pytest.mark.soak
def test_stopped_with_the_tip_inside_it_comes_out_and_waits_for_a_person(
    page: "Page", ward: Ward
) -> None:
    come_to_the_bed(page, ward)
    go_inside(page, ward)
    page.locator("#stop").click()
    expect(page.locator(".stop-status")).to_contain_text("Stop received")
    assert rest(page) == "halted"
    assert ward.tip_mm() < ward.boundary_mm()
    expect(page.locator(".last")).to_contain_text("Aborted", timeout=20_000)
    expect(page.locator(".last")).to_contain_text("a person asked for it")
    assert ward.outcomes()[-1] == "aborted"
    reset(page)
