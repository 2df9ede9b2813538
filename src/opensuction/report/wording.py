"""The words and number formats that page and terminal share."""

from typing import Any, NamedTuple

from opensuction.kernel.vocabulary import NOT_A_DEVICE

DISCLAIMER = f"In-silico result: the machine and the patient are a digital twin. {NOT_A_DEVICE}"
"""Stands on every report."""

ABSENT = "not simulated"
"""In place of a figure that this version does not compute."""


class PhaseWords(NamedTuple):
    """A phase for people: its name, what happens in it, and the kind that gives it a colour."""

    label: str
    meaning: str
    kind: str
    """``rest``, ``in``, ``suction``, ``out`` or ``fault``."""


REST = ("parked", "halted")
"""Phases in which nothing is going on: a cycle ends with one of them."""

PHASES: dict[str, PhaseWords] = {
    "parked": PhaseWords("Parked", "Tip out of the patient, valve closed, ready.", "rest"),
    "checking": PhaseWords("Checking", "Sensors, motor, valve, pump and line are tested.", "rest"),
    "preloading": PhaseWords(
        "Taking up slack", "The head moves, the tip does not yet: slack of the conduit.", "rest"
    ),
    "inserting": PhaseWords("Inserting", "The tip advances, valve closed.", "in"),
    "backing_off": PhaseWords(
        "Backing off", "The tip leaves the carina before suction begins.", "out"
    ),
    "opening": PhaseWords("Opening valve", "The suction valve opens; suction begins.", "suction"),
    "suctioning": PhaseWords("Suctioning", "The tip stands still, valve open.", "suction"),
    "withdrawing": PhaseWords("Withdrawing", "The tip moves out, valve open.", "out"),
    "closing": PhaseWords("Closing valve", "The suction valve closes; suction ends.", "suction"),
    "aborting": PhaseWords("Aborting", "Out of the airway first.", "fault"),
    "halted": PhaseWords("Halted", "Stopped until a person resets.", "fault"),
    "teaching": PhaseWords("Teaching", "A person measures the travel length.", "rest"),
    "identifying": PhaseWords("Identifying", "Bench: the transmission is measured.", "rest"),
    "out_of_service": PhaseWords("Out of service", "Catheter change or cleaning.", "rest"),
}
"""By the name that summaries use."""


def phase_words(name: str) -> PhaseWords:
    """Words for a phase; one that is unknown here keeps its own name."""
    unknown = PhaseWords(name.replace("_", " ").capitalize(), "", "rest")
    return PHASES.get(name, unknown)


def quantity(value: float | None, unit: str, decimals: int = 1, *, signed: bool = False) -> str:
    """Number with its unit, or ``not simulated``.

    >>> quantity(0.52, "mm"), quantity(0.52, "mm", signed=True), quantity(None, "%")
    ('0.5 mm', '+0.5 mm', 'not simulated')
    """
    if value is None:
        return ABSENT
    rounded = round(value, decimals) + 0.0  # adding zero turns -0.0 into 0.0
    return f"{rounded:{'+' if signed else ''}.{decimals}f} {unit}"


def moment(iso: str) -> str:
    """A moment of UTC for a person.

    >>> moment("2026-11-23T21:24:49.854646+00:00")
    '2026-11-23 21:24:49 UTC'
    """
    return f"{iso[:19].replace('T', ' ')} UTC"


def depth_words(depth_mm: float) -> str:
    """A depth of the tip in words.

    >>> depth_words(48.63), depth_words(-20.0)
    ("48.6 mm below the tube's end", "20.0 mm above the tube's end")
    """
    side = "below" if depth_mm >= 0.0 else "above"
    return f"{quantity(abs(depth_mm), 'mm')} {side} the tube's end"


def amount(value: float | None, unit: str, digits: int = 4) -> str:
    """Number of any size in some digits with its unit, which a ratio does not have; or a dash."""
    return "-" if value is None else f"{value:.{digits}g} {unit}".rstrip()


def stopped(said: str) -> str:
    """A sentence as it was written elsewhere, made to end with exactly one full stop."""
    return said.rstrip(". ") + "."


def capitalise(said: str) -> str:
    """A sentence with its first letter as a capital, the rest as it was."""
    return said[:1].upper() + said[1:]


def plain(value: Any) -> str:
    """Any value of a summary or of settings in a table's cell."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        return ", ".join(plain(entry) for entry in value)
    return str(value)
