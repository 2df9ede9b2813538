"""The bedside view on small screens: nothing lies over anything else, and no word leaves its tile.

By geometry, of what the browser has drawn: 1024 x 768, 1024 x 600, a tablet, and the tablet at
200 %, which is half as wide and half as high to the page.
"""

from collections.abc import Iterator
from datetime import timedelta
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest

from opensuction.accounts.rule.right import Role
from opensuction.safety.condition import Condition
from tests.browser.console.fake_machine import MACHINE, FakeMachine, Json, alarm, alarming
from tests.browser.console.waiting import drawn

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page

pytestmark = pytest.mark.browser

TOUCH_PX = 44.0
"""The least width and height of what a finger is to hit [WCAG-2-2] 2.5.5."""


class Screen(NamedTuple):
    """What a page has of a screen."""

    wide: int
    high: int
    scale: float = 1.0
    scrolls: bool = False
    """The view is longer than the screen; STOP and START stay in sight."""


SCREENS = {
    "1024 x 768": Screen(1024, 768),
    "1024 x 600": Screen(1024, 600),
    "1280 x 800": Screen(1280, 800),
    "1280 x 800 at 200 %": Screen(640, 400, 2.0, scrolls=True),
}
WORST_SCREENS = ("1024 x 600", "1280 x 800 at 200 %")
"""The lowest, and the one that scrolls."""
WORST: Json = {
    "phase_left_s": 123.0,
    "tip_mm": -88.0,
    "tip_low_mm": -100.4,
    "tip_high_mm": -75.6,
    "is_inside": True,
    "contact": True,
    "moving": "still",
    "vacuum_mmhg": 158.0,
    "vacuum_setpoint_mmhg": 120.0,
    "valve_open": True,
    "cam_rad": 3.1,
    "pump_on": True,
    "secretions": "coming",
    "rest_left_s": 5025.0,
    "passes": 3,
    "monitor": {
        "connected": True,
        "spo2_percent": 100.0,
        "heart_rate_per_min": 148.0,
        "airway_pressure_cmh2o": -12.0,
    },
}
"""Figures as wide as they come, with the most lines beneath."""
LONGEST = sorted(Condition, key=lambda one: len(one.row.sentence) + len(one.row.remedy))[-3:]
ENDED = {
    "outcome": "completed",
    "why": LONGEST[-1].row.sentence,
    "ended_at": "2026-03-01T10:00:00+00:00",
}


def states() -> Iterator[tuple[str, Json]]:
    """What the machine shows, with a name for each."""
    yield "parked", {}
    yield "no monitor", {"monitor": {**WORST["monitor"], "connected": False, "spo2_percent": None}}
    for one in MACHINE["phases"]:
        yield one["phase"], {**WORST, "phase": one["phase"], "last_cycle": ENDED}
    alarms = alarming(*(alarm(one) for one in reversed(LONGEST)))
    yield "alarms", {**WORST, "phase": "suctioning", **alarms}
    yield "alarms, left inside", {**WORST, "phase": "halted", **alarms, "last_cycle": ENDED}
    asks = {"preoxygenation": "requested", "assessment_due": True, "passes": 3}
    yield "asks", asks
    yield "asks, with alarms", {**asks, **alarms}


LOOK = """() => {
  const plain = ({ left, top, right, bottom }) => ({ left, top, right, bottom });
  const box = (one) => plain(one.getBoundingClientRect());
  const isShown = (one) => one.checkVisibility() && one.getClientRects().length > 0;
  const boxes = {};
  const words = [];
  const look = (name, place) => { boxes[name] = box(document.querySelector(place)); };
  const read = (holder, name, from = holder) => {
    const walker = document.createTreeWalker(from, NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      const around = node.parentElement;
      if (!node.data.trim() || !isShown(around)) continue;
      const range = document.createRange();
      range.selectNodeContents(node);
      // What ends in an ellipsis is as long as its lines that are shown.
      const ends = getComputedStyle(around).webkitLineClamp !== "none";
      const rects = ends ? [box(around)] : [...range.getClientRects()].map(plain);
      words.push({ name, text: node.data, holder: box(holder), rects });
    }
  };
  for (const name of
       ["alarm-bar", "header", "clock-apart", "navigation", "phase", "anatomy-figure", "footer"])
    look(name, `.${name}`);
  for (const name of ["start", "stop"]) {
    look(name, `#${name}`);
    read(document.getElementById(name), name);
  }
  for (const one of document.querySelectorAll(".tile")) {
    const name = `tile ${one.querySelector("h2").textContent}`;
    boxes[name] = box(one);
    read(one, name);
  }
  const bar = document.querySelector(".alarm-bar");
  for (const one of bar.querySelectorAll(".alarm-kind, .alarm-first, .alarm-button"))
    if (isShown(one)) read(bar, "alarm-bar", one);
  return { boxes, words, wide: document.documentElement.scrollWidth };
}"""
"""Boxes of the parts, and of each piece of text with the box that is to hold it."""


def overlap(one: Json, other: Json) -> bool:
    """Whether two boxes have more than a pixel's rounding in common."""
    wide = min(one["right"], other["right"]) - max(one["left"], other["left"])
    high = min(one["bottom"], other["bottom"]) - max(one["top"], other["top"])
    return bool(wide > 1.0 and high > 1.0)


def is_within(one: Json, other: Json) -> bool:
    """Whether a box lies in another one, but for a pixel's rounding."""
    return bool(
        one["left"] >= other["left"] - 1.0
        and one["top"] >= other["top"] - 1.0
        and one["right"] <= other["right"] + 1.0
        and one["bottom"] <= other["bottom"] + 1.0
    )


def find_faults(found: Any, screen: Screen) -> Iterator[str]:
    """What is not as it should be, in words."""
    boxes: Json = found["boxes"]
    for one, other in combinations(boxes, 2):
        if overlap(boxes[one], boxes[other]):
            yield f"{one} and {other} overlap: {boxes[one]}, {boxes[other]}"
    sight = {"left": 0, "top": 0, "right": screen.wide, "bottom": screen.high}
    for name in ("start", "stop") if screen.scrolls else boxes:
        if not is_within(boxes[name], sight):
            yield f"{name} is not wholly visible: {boxes[name]}"
    for one in (boxes["start"], boxes["stop"]):
        if min(one["right"] - one["left"], one["bottom"] - one["top"]) < TOUCH_PX:
            yield f"smaller than a finger: {one}"
    for one in found["words"]:
        if not all(is_within(rect, one["holder"]) for rect in one["rects"]):
            yield f"{one['name']}: {one['text']!r} leaves it: {one['rects']}, {one['holder']}"
    if found["wide"] > screen.wide:
        yield f"the page is {found['wide']} px wide"


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(one, marks=() if one in WORST_SCREENS else pytest.mark.sweep)
        for one in SCREENS
    ],
)
def shown_on(
    request: pytest.FixtureRequest, tablet: "BrowserContext", chromium: "Browser"
) -> Iterator[tuple["BrowserContext", Screen]]:
    """Whose pages have such a screen; one of another scale is a context of its own."""
    screen = SCREENS[request.param]
    if screen.scale == 1.0:
        yield tablet, screen
        return
    context = chromium.new_context(device_scale_factor=screen.scale)
    context.new_page()  # keeps the process of the others alive
    yield context, screen
    context.close()


@pytest.fixture
def small(
    shown_on: tuple["BrowserContext", Screen], fake: tuple[FakeMachine, str]
) -> Iterator[tuple["Page", FakeMachine, Screen]]:
    """The bedside view of a clinician on such a screen."""
    context, screen = shown_on
    machine, url = fake
    machine.sign_in(Role.CLINICIAN)
    page = context.new_page()
    page.set_viewport_size({"width": screen.wide, "height": screen.high})
    page.goto(url)
    page.get_by_text("Live", exact=True).wait_for()
    page.locator(".live-anatomy").wait_for()
    yield page, machine, screen
    page.close()


@pytest.mark.parametrize(
    "ahead", [pytest.param(timedelta(), marks=pytest.mark.soak), timedelta(hours=-11)]
)
def test_nothing_lies_over_anything_and_no_word_leaves_its_tile(
    small: tuple["Page", FakeMachine, Screen], ahead: timedelta
) -> None:
    page, machine, screen = small
    if ahead:
        machine.ahead = ahead
        page.reload()
        page.locator(".clock-apart").get_by_text("11 h ahead").wait_for()
    faults = []
    for name, state in states():
        machine.show(**state)
        drawn(page, machine)
        faults += [f"{name}: {one}" for one in find_faults(page.evaluate(LOOK), screen)]
    assert not faults, "\n".join(faults)


def test_stop_and_start_stay_where_they_are_while_the_view_scrolls(
    small: tuple["Page", FakeMachine, Screen],
) -> None:
    page, machine, screen = small
    machine.show(**WORST, phase="suctioning", **alarming(alarm(LONGEST[-1])))
    drawn(page, machine)
    before = page.evaluate(LOOK)["boxes"]
    page.mouse.move(screen.wide / 3, screen.high - 60)
    page.mouse.wheel(0, 600)
    drawn(page, machine)
    after = page.evaluate(LOOK)["boxes"]
    for name in ("start", "stop", "alarm-bar"):
        assert after[name] == before[name], name
    hit = "([x, y]) => document.elementFromPoint(x, y).closest('button')?.id"
    for name in ("start", "stop"):
        one = after[name]
        middle = [(one["left"] + one["right"]) / 2, (one["top"] + one["bottom"]) / 2]
        assert page.evaluate(hit, middle) == name
