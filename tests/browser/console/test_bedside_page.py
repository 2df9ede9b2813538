"""The bedside view: what is shown in each state, and what a person may press in it."""

import re
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect

from opensuction.safety.condition import Condition
from tests.browser.console.conftest import Bedside
from tests.browser.console.fake_machine import PARKED, alarm, alarming

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

pytestmark = pytest.mark.browser

TIP = {"tip_mm": 62.0, "tip_low_mm": 60.5, "tip_high_mm": 63.5, "is_inside": True}
INSERTING = {"phase": "inserting", "phase_left_s": 3.2, "moving": "in", **TIP}
SUCTIONING = {
    "phase": "suctioning",
    "phase_left_s": 6.3,
    **TIP,
    "vacuum_mmhg": 98.0,
    "vacuum_setpoint_mmhg": 100.0,
    "valve_open": True,
    "cam_rad": 1.6,
}
AT_TWO_METRES_PX = 48.0 / 0.72
"""Of a font whose capitals are 48 px high: 8 mm on a tablet of 10 inches with 1280 x 800 px."""


def tile(page: "Page", name: str) -> "Locator":
    return page.get_by_role("region", name=name, exact=True)


def test_secretions_that_come_are_drawn_and_told(bedside: Bedside) -> None:
    page = bedside.page
    drops, flow = page.locator("[data-part=secretions]"), page.locator("[data-part=flow]")
    bedside.machine.show(**SUCTIONING, secretions="coming")
    expect(page.locator(".phase-meaning")).to_contain_text("Secretions come.")
    expect(drops).to_be_visible()
    expect(flow).to_have_attribute("d", re.compile("^M .* V "))
    tip = page.locator("[data-part=tip]").bounding_box()
    around = drops.bounding_box()
    assert tip is not None
    assert around is not None
    assert around["y"] < tip["y"] + tip["height"] < around["y"] + around["height"]
    bedside.machine.show(**SUCTIONING, secretions="nothing-comes")
    expect(page.locator(".phase-meaning")).to_contain_text("Nothing comes.")
    expect(drops).to_be_hidden()
    expect(flow).to_have_attribute("d", "")
    assert page.evaluate("document.getAnimations().length") == 0, "nothing is drawn for nobody"


def test_nothing_flows_on_a_picture_that_is_not_live(bedside: Bedside) -> None:
    bedside.machine.show(**SUCTIONING, secretions="coming")
    flows = "document.querySelector('[data-part=flow]').getAnimations().length"
    flow = bedside.page.locator("[data-part=flow]")
    expect(flow).to_have_attribute("d", re.compile("^M .* V "))
    assert bedside.page.evaluate(flows) == 1
    bedside.machine.mute = True
    bedside.page.locator(".alarm-kind").get_by_text("NO CONNECTION").wait_for()
    assert bedside.page.evaluate(flows) == 0


def test_a_cycle_whose_end_is_not_on_record_holds_nothing_up(bedside: Bedside) -> None:
    """As where its recorder died; the page failed then, and its buttons stayed as they were."""
    page = bedside.page
    left_open = {"outcome": None, "why": "", "ended_at": None}
    bedside.machine.show(phase="halted", check_failure="the tip is inside", last_cycle=left_open)
    expect(tile(page, "Last cycle").locator(".figure")).to_have_text("Not ended")
    expect(page.locator(".phase-word")).to_have_text("Halted")
    expect(page.get_by_role("button", name=re.compile("^Reset"))).to_be_visible()
    assert bedside.complaints == []


def test_what_is_not_known_fails_no_part(bedside: Bedside) -> None:
    """Each value alone was tried, too: none but the alarms, which are always told, is needed."""
    page, machine = bedside.page, bedside.machine
    told = ("phase", "alarms", "priority", "audible", "connected", "age_s", "processes", "monitor")
    unknown = dict.fromkeys(PARKED.keys() - set(told))
    monitor = dict.fromkeys(PARKED["monitor"])
    for phase in ("parked", "suctioning", "halted"):
        machine.show(**unknown, phase=phase, monitor=monitor)
        expect(page.locator(".phase-word")).to_have_text(phase.capitalize())
    expect(page.locator(".link")).to_have_text("Live")
    assert bedside.complaints == []


def test_what_could_not_be_shown_is_not_taken_for_what_is_now(clinician: Bedside) -> None:
    page, machine = clinician.page, clinician.machine
    asks = alarming(alarm(Condition.CONTACT_STUCK_OPEN))
    machine.show(**SUCTIONING, **asks, monitor=None)  # the view fails, the alarm bar does not
    expect(page.locator(".link")).to_have_text("Page failed: reload it")
    sentence = Condition.CONTACT_STUCK_OPEN.row.sentence
    expect(page.locator(".alarm-kind")).to_contain_text(sentence, ignore_case=True)
    expect(page.locator(".bedside")).to_have_attribute("data-stale", "")
    expect(page.locator(".stale-note")).to_have_text("this page has failed: reload it")
    assert "null" in clinician.complaints[0]
    machine.show(**SUCTIONING)
    expect(page.locator(".link")).to_have_text("Live")
    expect(page.locator(".bedside[data-stale]")).to_have_count(0)
    expect(page.locator(".stale-note")).to_be_empty()
    machine.show(alarms=None)  # the alarm bar fails, the view does not
    expect(page.locator(".phase-word")).to_have_text("Parked")
    expect(page.locator(".link")).to_have_text("Page failed: reload it")
    expect(page.locator(".start-why")).to_contain_text("this page has failed")


def test_what_matters_is_shown_large(bedside: Bedside) -> None:
    page = bedside.page
    bedside.machine.show(**SUCTIONING)
    expect(page.locator(".phase-word")).to_have_text("Suctioning")
    expect(page.locator(".phase-left")).to_have_text("7 s left")
    expect(tile(page, "Catheter tip").locator(".figure")).to_have_text("62")
    expect(tile(page, "Catheter tip")).to_contain_text("± 1.5 mm")
    expect(tile(page, "Vacuum").locator(".big")).to_have_text("98")
    expect(tile(page, "Vacuum")).to_contain_text("set 100 · limit 150")
    expect(tile(page, "Valve").locator(".figure")).to_have_text("OPEN")
    for place in (".phase-word", ".tip .figure", ".vacuum .big"):
        size = page.locator(place).evaluate("one => parseFloat(getComputedStyle(one).fontSize)")
        assert size >= 0.98 * AT_TWO_METRES_PX, place
    assert bedside.complaints == []


def test_the_catheter_is_drawn_to_scale(bedside: Bedside) -> None:
    page = bedside.page
    bedside.machine.show(**INSERTING)
    expect(tile(page, "Catheter tip").locator(".figure")).to_have_text("62")
    tube, target = (
        float(str(page.locator(f".mark.{kind}").get_attribute("d")).split(",")[1].split(" ")[0])
        for kind in ("tube", "target")
    )
    tip = page.locator("[data-part=tip]")
    drawn = float(str(tip.get_attribute("cy"))) + 5.0  # its circle ends where the catheter ends
    assert (drawn - tube) / (target - tube) == pytest.approx(62.0 / 88.0, abs=0.01)
    height = float(str(page.locator("[data-part=range]").get_attribute("height")))
    assert height / (target - tube) == pytest.approx(3.0 / 88.0, abs=0.002)
    bedside.machine.show()
    expect(tile(page, "Catheter tip").locator(".figure")).to_have_text("OUT")
    expect(tip).to_have_attribute("cy", "-55.0")
    expect(page.locator("[data-part=bend]")).to_have_attribute("stroke-dasharray", "0.000 2")


def test_the_head_moves_along_its_way(bedside: Bedside) -> None:
    page, machine = bedside.page, bedside.machine
    head = page.locator("[data-part=head]")
    machine.show(head_mm=-120.0)
    expect(head).to_have_attribute("transform", "translate(420.0,0)")
    machine.show(head_mm=0.0, **TIP)
    expect(head).to_have_attribute("transform", "translate(331.0,0)")
    machine.show(head_mm=500.0, **TIP)
    expect(head).to_have_attribute("transform", "translate(242.0,0)")
    machine.show(head_mm=None, **TIP)
    expect(head).to_be_hidden()


def test_what_is_not_measured_is_said_so(bedside: Bedside) -> None:
    page = bedside.page
    nothing = {"spo2_percent": None, "heart_rate_per_min": None, "airway_pressure_cmh2o": None}
    bedside.machine.show(monitor={"connected": True, **nothing}, vacuum_mmhg=None, cam_rad=None)
    for name in ("SpO₂", "Heart rate", "Airway pressure", "Vacuum"):
        expect(tile(page, name)).to_contain_text("not measured")
    expect(tile(page, "Valve")).to_contain_text("cam not read")
    bedside.machine.show(monitor={"connected": False, **nothing})
    expect(tile(page, "SpO₂")).to_contain_text("no monitor")
    low = {"connected": True, **nothing, "spo2_percent": 84.0}
    bedside.machine.show(monitor=low)
    expect(tile(page, "SpO₂")).to_contain_text("OUT OF LIMIT")


def test_a_rest_counts_down_and_the_start_says_why_not(clinician: Bedside) -> None:
    clinician.machine.show(passes=1, rest_left_s=93.0)
    expect(tile(clinician.page, "Rest").locator(".figure")).to_have_text("1:33")
    expect(tile(clinician.page, "Passes left").locator(".figure")).to_have_text("2")
    expect(clinician.page.locator(".start-why")).to_contain_text("the patient rests another 93 s")
    expect(clinician.page.locator("#start")).to_have_attribute("aria-disabled", "true")


WHY: list[tuple[dict[str, object], str]] = [
    ({"phase": "halted"}, "deal with the cause, then reset"),
    ({"phase": "out-of-service"}, "out of service"),
    ({"locked_out": True, "phase": "halted"}, "locked out"),
    ({"passes": 3}, "look at the patient"),
    ({"preoxygenation": "requested"}, "pre-oxygenation"),
    ({"catheter_left_s": 0.0}, "past its life"),
    (INSERTING, "under way"),
]


def test_start_says_why_it_cannot(clinician: Bedside) -> None:
    for state, why in WHY:
        clinician.machine.show(**state)
        expect(clinician.page.locator(".start-why")).to_contain_text(why)
        expect(clinician.page.locator("#start")).to_have_attribute("aria-disabled", "true")
    hold(clinician.page, 1300)
    assert clinician.machine.asked == []


def hold(page: "Page", for_ms: float) -> None:
    box = page.locator("#start").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 40, box["y"] + 40)
    page.mouse.down()
    page.wait_for_timeout(for_ms)
    page.mouse.up()


@pytest.mark.parametrize("gesture", ["slides off", "a second finger lifts"])
def test_start_ends_when_the_finger_leaves_it(clinician: Bedside, gesture: str) -> None:
    page, machine = clinician.page, clinician.machine
    box = page.locator("#start").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 40, box["y"] + 40)
    page.mouse.down()
    if gesture == "slides off":
        page.mouse.move(box["x"] - 60, box["y"] - 60)
    else:
        page.locator("#start").dispatch_event("pointerup", {"pointerId": 7, "bubbles": True})
    expect(page.locator(".start-why")).to_contain_text("Hold it for a whole second")
    page.wait_for_timeout(1300)  # longer than it would have had to be held
    page.mouse.up()
    assert machine.asked == []
    # It swallows nothing afterwards: a screen reader's click asks.
    page.evaluate("document.getElementById('start').click()")
    expect(page.get_by_role("dialog")).to_be_visible()


@pytest.mark.real_time
def test_start_is_held_by_finger_or_key(clinician: Bedside) -> None:
    page, machine = clinician.page, clinician.machine
    expect(page.locator("#start")).to_contain_text(re.compile("to.88.mm"))
    hold(page, 500)
    expect(page.locator(".start-why")).to_contain_text("Hold it for a whole second")
    assert machine.asked == []
    hold(page, 1200)
    expect(page.locator(".start-why")).to_contain_text("Started")
    assert [one["ask"] for one in machine.asked] == ["start"]
    assert machine.headers[0]["x-csrf-token"] == "k" * 16
    page.locator("#start").focus()
    page.keyboard.down(" ")
    page.wait_for_timeout(500)
    page.keyboard.up(" ")
    expect(page.locator(".start-why")).to_contain_text("Hold it for a whole second")
    assert len(machine.asked) == 1
    page.keyboard.down("Enter")
    page.wait_for_timeout(1200)
    page.keyboard.up("Enter")
    expect(page.locator(".start-why")).to_contain_text("Started")
    assert len(machine.asked) == 2
    assert machine.asked[0]["key"] != machine.asked[1]["key"]


def test_start_without_holding_asks_instead(clinician: Bedside) -> None:
    page = clinician.page
    page.locator("#start").evaluate("one => one.click()")  # as a screen reader does
    dialog = page.get_by_role("dialog", name="START")
    expect(dialog).to_contain_text(re.compile("Start a cycle to.88.mm, 100.mmHg"))
    assert clinician.machine.asked == []
    dialog.get_by_role("button", name="Start now").click()
    expect(page.locator(".start-why")).to_contain_text("Started")
    assert [one["ask"] for one in clinician.machine.asked] == ["start"]


@pytest.mark.real_time
def test_a_start_that_the_machine_refuses_says_its_sentence(clinician: Bedside) -> None:
    said = {"name": "not-taught", "sentence": "no travel length has been set", "remedy": ""}
    clinician.machine.answer = {"verdict": "pressed", "refusal": said}
    hold(clinician.page, 1200)
    expect(clinician.page.locator(".start-why")).to_contain_text("no travel length has been set")


BUTTONS = [
    ({"phase": "halted"}, "Reset", "reset"),
    ({"preoxygenation": "requested"}, "Oxygen given", "oxygenated"),
    ({"preoxygenation": "requested"}, "Without oxygen", "oxygen-skipped"),
    ({"passes": 3}, "Patient assessed", "assessed"),
    ({"assessment_due": True}, "Suction not needed", "not-needed"),
]


@pytest.mark.parametrize(("state", "name", "ask"), BUTTONS)
def test_other_buttons_are_there_where_they_mean_something(
    clinician: Bedside, state: dict[str, object], name: str, ask: str
) -> None:
    button = clinician.page.get_by_role("button", name=name)
    expect(button).to_be_hidden()
    clinician.machine.show(**state)
    button.click()
    expect(clinician.page.locator(".tell-answer").last).not_to_be_empty()
    assert [one["ask"] for one in clinician.machine.asked] == [ask]


def test_a_catheter_left_inside_stands_first_and_nothing_green_above(bedside: Bedside) -> None:
    blocked = alarm(Condition.WITHDRAWAL_BLOCKED, latched=True)
    left = {**TIP, "tip_mm": 49.0, "phase": "halted", **alarming(blocked)}
    bedside.machine.show(**left)
    first = bedside.page.locator(".alarm-first")
    expect(first).to_have_text("CATHETER IS STILL IN THE AIRWAY, 49 mm: draw it out by the handle")
    expect(tile(bedside.page, "Catheter tip")).to_contain_text("STILL IN THE AIRWAY")
    box = first.bounding_box()
    assert box is not None
    assert box["y"] < 60
    green = """() => [...document.querySelectorAll('*')].filter(one => {
        const [r, g, b] = getComputedStyle(one).backgroundColor.match(/\\d+/g).map(Number);
        return g > r + 40 && g > b + 40;
    }).length"""
    assert bedside.page.evaluate(green) == 0


def test_nothing_moves_when_an_alarm_begins(bedside: Bedside) -> None:
    page = bedside.page
    before = [page.locator(one).bounding_box() for one in ("#stop", ".header", ".phase-word")]
    blocked = alarm(Condition.WITHDRAWAL_BLOCKED)
    more = alarm(Condition.AUTOMATION_STOPPED)
    bedside.machine.show(**{**TIP, "phase": "halted", **alarming(blocked, more)})
    expect(page.locator(".alarm-first")).to_contain_text("STILL IN THE AIRWAY")
    after = [page.locator(one).bounding_box() for one in ("#stop", ".header", ".phase-word")]
    for was, now in zip(before, after, strict=True):
        assert was is not None
        assert now is not None
        assert (was["x"], was["y"]) == (now["x"], now["y"])


def test_what_a_machine_lacks_stands_below_every_view(bedside: Bedside) -> None:
    page, machine = bedside.page, bedside.machine
    notice = page.get_by_role("contentinfo")
    expect(notice).to_have_text(re.compile(r"not a medical device.* In-silico: a digital twin\.$"))
    has = {"monitor": False, "mouth_barrier": True, "taught_by_hand": False, "truth": False}
    machine.machine = {**machine.machine, "is_twin": False, "capabilities": has}
    page.reload()
    expect(notice).to_have_text(
        re.compile(r"people or animals\. Not in this machine: patient monitor, teaching by hand\.$")
    )
