"""Buttons of the machine: one table, from which API, command line and page know each of them.

A new button is a field of `kernel.interface.Requests`, a bit in `procedure.cycle.button`, and a row
here. One that stands on the bedside view also needs the states in which it is shown (its part of
the page).
"""

from enum import StrEnum
from typing import Any, NamedTuple

from opensuction.accounts.rule.right import Right


class PagePart(StrEnum):
    """Part of the page that presses a button, by its file among the page's scripts."""

    STOP = "stop.js"
    START = "bedside/start.js"
    BEDSIDE = "bedside/buttons.js"
    """Draws its buttons from this table; the others have a form of their own."""
    ALARM_BAR = "alarm/bar.js"
    CATHETER = "setup/catheter.js"
    TEACHING = "setup/teaching.js"


class BedsideWords(NamedTuple):
    """Words on a button of the bedside view, and after it was pressed."""

    label: str
    hint: str
    done: str
    """``{s}`` stands for the seconds that given oxygen still counts."""


class MachineButton(NamedTuple):
    """A button of the machine."""

    field: str
    """Of `kernel.interface.Requests`; the name in mailbox, journal and recording."""
    right: Right
    """Whoever presses it needs it; a reason is asked for where the right needs one."""
    label: str = ""
    """Name for other programs; empty where a press alone is not enough, and `path` takes more."""
    part: PagePart | None = None
    """None: the page has none, only API and command line."""
    path: str = "/requests"
    """Path of the API by which the page presses it."""
    words: BedsideWords | None = None
    """Of a button of `PagePart.BEDSIDE`."""
    is_refusable: bool = False
    """The core may refuse it, and says so in its counters."""

    @property
    def name(self) -> str:
        """Name as people and programs type it."""
        return self.field.replace("_", "-")


BUTTONS = (
    MachineButton("start", Right.START, "Start", PagePart.START, is_refusable=True),
    MachineButton("identify", Right.CALIBRATE, "Identify"),
    MachineButton("abort", Right.STOP, "Stop", PagePart.STOP),
    MachineButton(
        "reset",
        Right.RESET,
        "Reset",
        PagePart.BEDSIDE,
        words=BedsideWords("Reset", "The cause has been dealt with", "Reset received"),
        is_refusable=True,
    ),
    MachineButton(
        "teach", Right.TEACH, "Teach the travel length", PagePart.TEACHING, path="/teaching"
    ),
    MachineButton(
        "confirm", Right.TEACH, "The tip is at the carina", PagePart.TEACHING, path="/teaching"
    ),
    MachineButton("home", Right.TEACH, "Bring the head home", PagePart.TEACHING, path="/teaching"),
    MachineButton("service", Right.CHANGE_CATHETER, "Take out of service", PagePart.CATHETER),
    # Takes the label of the new catheter.
    MachineButton("changed", Right.CHANGE_CATHETER, part=PagePart.CATHETER, path="/catheter"),
    MachineButton(
        "return_to_service", Right.CHANGE_CATHETER, "Return to service", PagePart.CATHETER
    ),
    MachineButton(
        "not_needed",
        Right.ATTEND_PATIENT,
        "Nothing to suction",
        PagePart.BEDSIDE,
        words=BedsideWords(
            "Suction not needed", "Nothing to suction now", "On record: suction not needed"
        ),
    ),
    MachineButton("acknowledge", Right.ATTEND_ALARMS, "Acknowledge", PagePart.ALARM_BAR),
    MachineButton("audio_pause", Right.ATTEND_ALARMS, "Audio pause", PagePart.ALARM_BAR),
    MachineButton(
        "assessed",
        Right.ATTEND_PATIENT,
        "Patient looked at",
        PagePart.BEDSIDE,
        words=BedsideWords(
            "Patient assessed", "I have looked at the patient", "On record: patient assessed"
        ),
    ),
    MachineButton(
        "oxygenated",
        Right.ATTEND_PATIENT,
        "Oxygen given",
        PagePart.BEDSIDE,
        words=BedsideWords(
            "Oxygen given", "Pre-oxygenation is done", "On record: oxygen given, holds {s} s"
        ),
    ),
    MachineButton(
        "oxygen_skipped",
        Right.ATTEND_PATIENT,
        "Skip oxygen",
        PagePart.BEDSIDE,
        words=BedsideWords("Without oxygen", "Goes on record", "On record: without oxygen"),
    ),
)
"""Every button, in the order of `kernel.interface.Requests`."""
BY_NAME = {button.name: button for button in BUTTONS}
PRESSABLE = {name: button for name, button in BY_NAME.items() if button.label}
"""Those that a press alone works, by name."""


def list_plain() -> dict[str, dict[str, Any]]:
    """The table as the page takes it: right and words of each button, by name."""
    return {
        button.name: {
            "right": str(button.right),
            "words": None if button.words is None else button.words._asdict(),
        }
        for button in BUTTONS
    }
