"""Setting up on the page, before twin and controller in real time."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from opensuction.controller import configuration
from opensuction.ipc.ring import RingReader
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.twin.twin_process import SHOWN
from opensuction.runtime import machine_folder
from opensuction.runtime.machine_folder import CONFIGURATION
from opensuction.session.running import basis
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from tests.browser.conftest import TABLET
from tests.browser.console.test_everybody import SMALL, TOUCH_PX, findings
from tests.console.listening import listening_app
from tests.console.served import PEOPLE, free_port
from tests.console.setup.bed import Bed, bed, until

if TYPE_CHECKING:
    from typing import Literal

    from playwright.sync_api import Browser, BrowserContext, Page

    Scheme = Literal["dark", "light"]

pytestmark = [pytest.mark.real_time, pytest.mark.browser]


@pytest.fixture(scope="module")
def at_bed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bed]:
    port = free_port()
    with (
        bed(Path(tmp_path_factory.mktemp("bed")), port) as made,
        listening_app(made.served.app, port),
    ):
        yield made


@pytest.fixture(scope="module")
def tablet(chromium: "Browser") -> Iterator["BrowserContext"]:
    """A browser whose pages load the files once."""
    context = chromium.new_context(viewport=TABLET)  # type: ignore[arg-type]
    yield context
    context.close()


@pytest.fixture
def page(tablet: "BrowserContext", at_bed: Bed) -> Iterator["Page"]:
    found = tablet.new_page()
    broken: list[str] = []
    found.on("pageerror", lambda error: broken.append(str(error)))
    found.goto(f"{at_bed.served.url}/#/setup")
    found.wait_for_selector(".protocol")
    at_bed.settle()
    yield found
    found.close()
    tablet.clear_cookies()  # nobody is signed in any more
    assert not broken


def sign_in(page: "Page", at_bed: Bed, role: str) -> None:
    page.locator("button.sign").click()
    page.fill("#field-name", PEOPLE[role])
    page.fill("#field-password", at_bed.served.password(role))
    page.keyboard.press("Enter")
    page.wait_for_selector(".dialog", state="detached")
    page.wait_for_selector(".protocol")


def vacuum_mmhg(at_bed: Bed) -> float:
    text = (at_bed.site.folder / CONFIGURATION).read_text(encoding="utf-8")
    return configuration.from_json(text).settings.plan.vacuum_mmhg


def answered(page: "Page") -> None:
    """The planner has said what it thinks of what was typed last."""
    page.wait_for_timeout(300)
    page.wait_for_load_state("networkidle")


@pytest.mark.sweep
@pytest.mark.parametrize("scheme", ["dark", pytest.param("light", marks=pytest.mark.soak)])
def test_setting_up_is_for_everybody(page: "Page", at_bed: Bed, scheme: "Scheme") -> None:
    page.emulate_media(color_scheme=scheme)
    sign_in(page, at_bed, "clinician")
    page.fill("#draft-vacuum_mmhg", "900")
    answered(page)
    found = {"protocol, refused": findings(page) + page.evaluate(SMALL, TOUCH_PX)}
    for part in ("patient", "teaching", "catheter", "identification"):
        page.click(f"#part-{part}")
        page.wait_for_load_state("networkidle")
        page.wait_for_timeout(300)
        found[part] = findings(page) + page.evaluate(SMALL, TOUCH_PX)
    assert found == {name: [] for name in found}


def test_nobody_changes_anything_without_signing_in(page: "Page") -> None:
    assert page.locator("#draft-vacuum_mmhg").get_attribute("readonly") is not None
    assert page.locator("button.set").is_disabled()
    assert page.get_by_text("Sign in to change anything here.").is_visible()


def test_a_clinician_types_a_vacuum_sees_what_it_means_and_sets_it(
    page: "Page", at_bed: Bed
) -> None:
    sign_in(page, at_bed, "clinician")
    page.fill("#draft-vacuum_mmhg", "140")
    wrong = page.locator("#draft-vacuum_mmhg-wrong")
    wrong.get_by_text("at most 100 mmHg").wait_for()
    field = page.locator("#draft-vacuum_mmhg")
    assert "draft-vacuum_mmhg-wrong" in (field.get_attribute("aria-describedby") or "")
    assert field.get_attribute("aria-invalid") == "true"
    assert page.locator("button.set").is_disabled()
    # What was typed stays, whichever part is looked at.
    page.click("#part-catheter")
    page.wait_for_selector(".catheter-clock")
    page.click("#part-protocol")
    assert page.locator("#draft-vacuum_mmhg").input_value() == "140"
    page.fill("#draft-vacuum_mmhg", "70")
    page.get_by_text("70 mmHg, at most 5 s suction").wait_for()
    page.get_by_text("Changes: Vacuum 80 → 70 mmHg").wait_for()
    page.locator("button.set:enabled").click()
    page.get_by_text("The machine goes by this now.").wait_for()
    assert vacuum_mmhg(at_bed) == 70.0
    assert machine_folder.read(at_bed.site.folder).protocol.name == "paediatric, changed"


@pytest.mark.sweep
def test_who_is_late_keeps_what_was_typed_and_compares(page: "Page", at_bed: Bed) -> None:
    sign_in(page, at_bed, "clinician")
    page.fill("#draft-vacuum_mmhg", "66")
    page.locator("button.set:enabled").wait_for()
    other = at_bed.get("/protocol")
    sent = {
        "approach": "travel",
        "protocol": {**other["protocol"], "vacuum_mmhg": 68.0},
        "version": other["version"],
        "key": "somebody-else-1",
    }
    answer = at_bed.client("clinician").put("/api/v1/protocol", json=sent)
    assert answer.status_code == 200, answer.text
    page.locator("button.set").click()
    page.get_by_text("Somebody else has changed the settings meanwhile").wait_for()
    assert page.locator("#draft-vacuum_mmhg").input_value() == "66"
    page.get_by_role("button", name="Keep what I typed").click()
    page.get_by_text("Changes: Vacuum 68 → 66 mmHg").wait_for()
    page.locator("button.set:enabled").click()
    page.get_by_text("The machine goes by this now.").wait_for()
    assert vacuum_mmhg(at_bed) == 66.0


def test_a_limit_takes_an_engineer_and_a_reason(page: "Page", at_bed: Bed) -> None:
    sign_in(page, at_bed, "engineer")
    assert page.locator("#draft-vacuum_mmhg").get_attribute("readonly") is not None
    page.fill("#draft-in_airway_budget_s", "12")
    page.locator("button.set:enabled").click()
    page.locator("#draft-reason-wrong").get_by_text("say why").wait_for()
    page.fill("#draft-reason", "a slower hand")
    answered(page)
    page.locator("button.set:enabled").click()
    page.get_by_text("The machine goes by this now.").wait_for()
    assert basis.read(at_bed.site.folder).protocol.in_airway_budget_s == 12.0
    assert at_bed.actions()[0][2].endswith("reason: a slower hand")


def push(page: "Page", at_bed: Bed) -> None:
    """A hand pushes to the carina."""
    at_bed.settle()
    page.click("[data-step=begin]")
    page.click("[data-step=push]")
    page.locator(".teaching-does", has_text="feels the carina").wait_for(timeout=40_000)


@pytest.mark.sweep
def test_the_travel_length_is_taught_step_by_step(page: "Page", at_bed: Bed) -> None:
    sign_in(page, at_bed, "clinician")
    page.click("#part-teaching")
    page.click("[data-step=prepare]")
    page.get_by_text("Step 2 of 5").wait_for()
    push(page, at_bed)
    page.click("[data-step=confirm]")
    page.get_by_text("Step 4 of 5").wait_for()
    at_bed.settle()
    page.get_by_text("Step 5 of 5").wait_for()
    taught = at_bed.get("/teaching")["taught_mm"]
    assert page.locator("dd.taught").inner_text() == f"{taught:.1f} mm"
    page.click("[data-step=take]")
    page.get_by_text("Taken: the protocol fits").wait_for()
    found = basis.read(at_bed.site.folder)
    assert found.site.carina_mm == taught
    assert not found.is_teaching
    assert found.protocol.travel_mm == pytest.approx(taught - 10.0)


def test_stop_ends_teaching_at_any_step(page: "Page", at_bed: Bed) -> None:
    sign_in(page, at_bed, "clinician")
    page.click("#part-teaching")
    page.click("[data-step=prepare]")
    played = RingReader(at_bed.site.folder / SHOWN)
    played.next = played.newest() + 1
    page.click("[data-step=begin]")
    page.click("[data-step=push]")
    until(lambda: at_bed.room.truth("truth.head_mm") > -40.0 or at_bed.room.phase() == Phase.HALTED)
    page.locator("#stop").click()
    page.get_by_text("It was ended: the drive took the catheter out.").wait_for(timeout=30_000)
    # A hand that nobody stops pushes on to the carina, and teaching ends then, too.
    assert played.drain().rows[:, SHOWN_COLUMNS.index("truth.contact_n")].max() == 0.0
    assert at_bed.room.is_out()
    at_bed.settle()
    page.click("[data-step=leave]")
    page.get_by_text("Step 1 of 5").wait_for()
    assert not basis.read(at_bed.site.folder).is_teaching


@pytest.mark.sweep
def test_a_catheter_is_changed(page: "Page", at_bed: Bed) -> None:
    sign_in(page, at_bed, "clinician")
    page.click("#part-catheter")
    page.get_by_role("button", name="Take out of service").click()
    page.fill("#field-label", "c-1")
    page.get_by_role("button", name="The new catheter is in").click()
    page.locator("#field-label-wrong").get_by_text("used already").wait_for()
    assert page.locator("#field-label").input_value() == "c-1"
    page.fill("#field-label", "C-7001")
    page.get_by_role("button", name="The new catheter is in").click()
    page.get_by_text("Catheter C-7001: its 24 h have begun.").wait_for()
    page.get_by_role("button", name="Hands are off").click()
    until(lambda: at_bed.room.phase() == Phase.PARKED)
    page.get_by_role("button", name="Take out of service").wait_for()
    assert machine_folder.read(at_bed.site.folder).catheter.label == "C-7001"
