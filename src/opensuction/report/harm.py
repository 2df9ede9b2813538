"""Bounds for the patient that were broken, in words: as the oracle judged, from the truth alone."""

from typing import NamedTuple

from opensuction.report import witness
from opensuction.report.figure import Figure
from opensuction.report.summary import Summary, harms


class HarmWords(NamedTuple):
    """A broken bound for a person."""

    sentence: str
    """Without its capital and full stop."""
    remedy: str
    figure: str
    """Name of the key figure that measures it; empty where none does."""


LOOK = "Look at the patient."

HARMS = {
    "left-inside": HarmWords(
        "the catheter was left in the airway", "Draw it out by the handle.", witness.AT_END
    ),
    "saturation": HarmWords(
        "oxygen saturation fell below its bound", f"{LOOK} Give oxygen.", witness.SATURATION
    ),
    "airway-pressure": HarmWords(
        "airway pressure was outside its bounds",
        f"{LOOK} Check circuit, tube and ventilator.",
        witness.PRESSURE,
    ),
    "lung-volume": HarmWords(
        "the lungs lost more volume than their bound",
        f"{LOOK} Recruit as ordered.",
        witness.LUNG_VOLUME,
    ),
    "tip-past-cap": HarmWords(
        "the tip went deeper than it ever may", f"{LOOK} Look for bleeding.", witness.DEEPEST
    ),
    "force": HarmWords(
        "the tip pressed on the carina harder than it may",
        f"{LOOK} Look for bleeding.",
        witness.FORCE,
    ),
    "contact-time": HarmWords(
        "the tip pressed on the carina for longer than it may",
        f"{LOOK} Look for bleeding.",
        witness.FORCE,
    ),
    "vacuum": HarmWords(
        "vacuum at the tip was above its bound",
        f"{LOOK} Do not suction with this pump until it holds its vacuum.",
        witness.VACUUM,
    ),
    "advance-under-vacuum": HarmWords(
        "the tip went in under vacuum", f"{LOOK} Look for bleeding.", ""
    ),
    "airway-time": HarmWords(
        "the catheter was in the airway for longer than its bound", LOOK, witness.IN_AIRWAY
    ),
    "suction-time": HarmWords("suction lasted longer than its bound", LOOK, witness.SUCTION),
}
"""By the oracle's name, the most urgent for a person first."""


def broken(summary: Summary) -> list[HarmWords]:
    """The bounds that were broken, the most urgent first; an unknown name speaks for itself."""
    names = harms(summary)
    known = [words for name, words in HARMS.items() if name in names]
    unknown = [name for name in names if name not in HARMS]
    said = [HarmWords(f"the bound '{name}' was broken", LOOK, "") for name in unknown]
    return known + said


def sentence(words: HarmWords, figures: list[Figure]) -> str:
    """A broken bound with what was measured, where a key figure measures it."""
    value = next((figure.value for figure in figures if figure.name == words.figure), "")
    return f"{words.sentence} ({value})" if any(map(str.isdigit, value)) else words.sentence
