"""A tab of the console behind another one, throttled by its browser as on a person's computer.

Playwright holds each of its pages visible, and starts Chromium without throttling. So this is a
Chromium of its own, and a tab that Playwright does not know of, driven by the browser's protocol.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from typing import TYPE_CHECKING, Any

from tests.conftest import CHROMIUM_OPTIONS, Component

if TYPE_CHECKING:
    from playwright.sync_api import Browser, CDPSession

THROTTLES_NOT = (
    "--disable-background-timer-throttling",
    "--disable-backgrounding-occluded-windows",
    "--disable-renderer-backgrounding",
)
"""Playwright's own options, which are left out here."""
SOUNDS = "--autoplay-policy=no-user-gesture-required"
EARLY = "--enable-features=IntensiveWakeUpThrottling:grace_period_seconds/5"
"""Timers of a hidden page act once a minute after 5 s, instead of 5 minutes."""
FREEZES = (
    f"{EARLY},InfiniteTabsFreezing:num_protected_tabs/0/unfreeze_interval/1h/unfreeze_duration/1s,"
    "CPUMeasurementInFreezingPolicy:freezing_visible_protection_time/3s/"
    "freezing_audio_protection_time/1s"
)
"""A page that has been hidden for 3 s, and silent for 1 s, is halted with its workers: as one that
saves energy does after 5 minutes, by the same rules of what it leaves going."""


class HiddenTab:
    """A page that is open, and not seen."""

    def __init__(self, browser: "CDPSession", url: str) -> None:
        self._browser, self._numbers = browser, count(1)
        self._answers: dict[int, Any] = {}
        context = browser.send("Target.createBrowserContext")
        made = browser.send("Target.createTarget", {"url": url, "newWindow": True, **context})
        target = {"targetId": made["targetId"]}
        self._session = browser.send("Target.attachToTarget", {**target, "flatten": False})
        browser.on("Target.receivedMessageFromTarget", self._hear)
        self._front = browser.send(
            "Target.createTarget", {"url": "about:blank", "newWindow": False, **context}
        )

    def open_another(self, url: str) -> "HiddenTab":
        """A tab in a window of its own of the same browser."""
        return HiddenTab(self._browser, url)

    def hide(self) -> None:
        """Bring the other tab to the front."""
        self._browser.send("Target.activateTarget", self._front)

    def evaluate(self, expression: str) -> Any:
        """The value of an expression in the page, once a promise is kept."""
        number = next(self._numbers)
        asked = {"expression": expression, "returnByValue": True, "awaitPromise": True}
        message = {"id": number, "method": "Runtime.evaluate", "params": asked}
        self._browser.send(
            "Target.sendMessageToTarget", {**self._session, "message": json.dumps(message)}
        )
        while number not in self._answers:
            self._browser.send("Browser.getVersion")  # lets its answers come
        answer = self._answers.pop(number)
        assert "exceptionDetails" not in answer.get("result", {}), answer
        return answer["result"]["result"].get("value")

    def _hear(self, told: dict[str, Any]) -> None:
        message = json.loads(told["message"])
        if told["sessionId"] == self._session["sessionId"] and "id" in message:
            self._answers[message["id"]] = message


@contextmanager
def open_tab(
    chromium: "Browser", component: Component, url: str, *more: str
) -> Iterator[HiddenTab]:
    """A tab in front of another one. more: options of Chromium."""
    browser = chromium.browser_type.launch(
        executable_path=component("chromium"),
        args=[*CHROMIUM_OPTIONS, SOUNDS, *more],
        ignore_default_args=list(THROTTLES_NOT),
    )
    try:
        yield HiddenTab(browser.new_browser_cdp_session(), url)
    finally:
        browser.close()
