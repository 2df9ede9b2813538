"""Depth of the tip as a bar of characters, and the characters that a console can show."""

from typing import Final, NamedTuple

from rich.console import Console

CELLS: Final = 40
"""Width of the bar."""

MARGIN_RATIO: Final = 1.1
"""Depth at the end of the bar over the cap, so that the cap has a place within it."""


class Glyphs(NamedTuple):
    """Characters of the display; plain ones where the terminal knows no others."""

    done: str
    now: str
    later: str
    failed: str
    look: str
    full: str
    empty: str


UNICODE: Final = Glyphs(done="✓", now="▶", later="·", failed="✗", look="!", full="█", empty="░")
ASCII: Final = Glyphs(done="x", now=">", later=".", failed="!", look="?", full="#", empty="-")


def glyphs(console: Console) -> Glyphs:
    """Characters that a console can show."""
    return ASCII if console.options.ascii_only else UNICODE


def depth_bar(tip_mm: float, target_mm: float | None, cap_mm: float, marks: Glyphs) -> str:
    """Depth from the tube's end as a bar; ``T`` stands at the target, ``C`` at the cap.

    target_mm: None where the cycle stops by contact.

    >>> depth_bar(50.0, 90.0, 100.0, ASCII)
    '##################--------------T--C----'
    """
    per_cell = MARGIN_RATIO * cap_mm / CELLS
    filled = min(max(round(tip_mm / per_cell), 0), CELLS)
    cells = [marks.full] * filled + [marks.empty] * (CELLS - filled)
    for depth, letter in ((target_mm, "T"), (cap_mm, "C")):
        if depth is not None:
            cells[min(max(round(depth / per_cell) - 1, 0), CELLS - 1)] = letter
    return "".join(cells)
