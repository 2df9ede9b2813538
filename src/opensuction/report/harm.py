"""Bounds for the patient that were broken, in words: as the oracle judged, from the truth alone."""

from typing import NamedTuple

from opensuction.report.wording import amount
from opensuction.result.cycle_result import CycleResult


class HarmWords(NamedTuple):
    """A broken bound for a person."""

    sentence: str
    """Without its capital and full stop."""
    remedy: str


LOOK = "Look at the patient."

HARMS = {
    "left-inside": HarmWords("the catheter was left in the airway", "Draw it out by the handle."),
    "saturation": HarmWords("oxygen saturation fell below its bound", f"{LOOK} Give oxygen."),
    "airway-pressure": HarmWords(
        "airway pressure was outside its bounds", f"{LOOK} Check circuit, tube and ventilator."
    ),
    "lung-volume": HarmWords(
        "the lungs lost more volume than their bound", f"{LOOK} Recruit as ordered."
    ),
    "tip-past-cap": HarmWords("the tip went deeper than it ever may", f"{LOOK} Look for bleeding."),
    "force": HarmWords(
        "the tip pressed on the carina harder than it may", f"{LOOK} Look for bleeding."
    ),
    "contact-time": HarmWords(
        "the tip pressed on the carina for longer than it may", f"{LOOK} Look for bleeding."
    ),
    "vacuum": HarmWords(
        "vacuum at the tip was above its bound",
        f"{LOOK} Do not suction with this pump until it holds its vacuum.",
    ),
    "advance-under-vacuum": HarmWords("the tip went in under vacuum", f"{LOOK} Look for bleeding."),
    "airway-time": HarmWords("the catheter was in the airway for longer than its bound", LOOK),
    "suction-time": HarmWords("suction lasted longer than its bound", LOOK),
}
"""By the oracle's name, the most urgent for a person first."""


def broken(result: CycleResult) -> list[tuple[str, HarmWords]]:
    """The bounds that were broken, by name, the most urgent first; unknown ones come last."""
    names = result.harms
    known = [(name, words) for name, words in HARMS.items() if name in names]
    unknown = [name for name in names if name not in HARMS]
    return known + [(name, HarmWords(f"the bound '{name}' was broken", LOOK)) for name in unknown]


def sentence(result: CycleResult, name: str, words: HarmWords) -> str:
    """A broken bound with what was measured and the bound itself, where they are known."""
    for bound in result.simulated.broken_bounds if result.simulated else ():
        if bound.name == name and bound.worst is not None and bound.limit is not None:
            worst, limit = (amount(one, bound.unit, 3) for one in (bound.worst, bound.limit))
            return f"{words.sentence} ({worst}, bound {limit})"
    return words.sentence
