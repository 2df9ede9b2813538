"""Drawing of tube, trachea and catheter: to scale along the depth, widths schematic."""

from typing import NamedTuple

from opensuction.report import figures
from opensuction.report.summary import Summary, is_inside, number
from opensuction.report.wording import depth_words, quantity

PX_PER_MM = 2.8
"""Scale along the depth."""
ABOVE_MM = 52.0
"""Drawn above the tube's end; the tube bends away to its upper end, not to scale."""
STRAIGHT_MM = 16.0
"""The tube is straight, and to scale, from here to its end."""
BELOW_MM = 28.0
"""Drawn below the deepest thing that has a name: room for the bronchi."""
LABEL_GAP_PX = 20.0
"""Least distance of two labels: one line of text."""
SAME_MM = 0.5
"""A deepest position this near to where the tip is now is not drawn beside it."""
TICK_MM = 10
"""Ticks of the scale; every second one has a number."""


class Mark(NamedTuple):
    """A depth with a name, and where its label stands so that labels do not overlap."""

    name: str
    kind: str
    """``tube``, ``target``, ``now``, ``deepest``, ``cap``, ``search`` or ``carina``."""
    text: str
    y_px: float
    label_y_px: float


class Tick(NamedTuple):
    """A tick of the scale; ``text`` is empty for a short one."""

    y_px: float
    text: str


class Drawing(NamedTuple):
    """Everything that the template needs; depths are in px from the top."""

    height_px: float
    tube_end_px: float
    carina_px: float | None
    now_px: float | None
    """Where the catheter ends now; None where it is out of the drawing's straight part."""
    bend_share: float
    """Share of the tube's bend that the catheter fills now, 0 to 1."""
    deepest_px: float | None
    """Where it ended at its deepest; None where it never got into the drawing, or is there now."""
    upper_end: str
    """Depth of the tube's upper end, where the patient begins; empty where that is not known."""
    marks: list[Mark]
    ticks: list[Tick]
    caption: str
    """What is drawn, in a sentence or two."""
    description: str
    """The drawing in words, for those who do not see it."""


def y_px(depth_mm: float) -> float:
    """Position of a depth on the drawing."""
    return round((depth_mm + ABOVE_MM) * PX_PER_MM, 1)


def spread(wanted_px: list[float], gap_px: float = LABEL_GAP_PX) -> list[float]:
    """Positions as near as possible to the wanted (rising) ones, at least a gap apart.

    Labels that would overlap form a group that is centred on where its members want to be.

    >>> spread([0.0, 100.0, 104.0], 20.0)
    [0.0, 92.0, 112.0]
    """
    groups: list[list[float]] = []
    tops: list[float] = []
    for wanted in wanted_px:
        groups.append([wanted])
        tops.append(wanted)
        while len(groups) > 1 and tops[-1] < tops[-2] + gap_px * len(groups[-2]):
            merged = groups[-2] + groups[-1]
            groups[-2:] = [merged]
            centred = [want - gap_px * i for i, want in enumerate(merged)]
            tops[-2:] = [sum(centred) / len(centred)]
    return [
        top + gap_px * i for top, group in zip(tops, groups, strict=True) for i in range(len(group))
    ]


def cap_name(summary: Summary) -> str:
    """What a cap is: a depth that is never passed, or where the search for the carina ends."""
    return "Search ends" if figures.is_search_cap(summary) else "Cap"


def _depths(summary: Summary) -> list[tuple[str, str, float]]:
    """Named depths (name, kind, mm), from the top down."""
    deepest, now = number(summary, "tip", "deepest_mm"), number(summary, "tip", "end_mm")
    if deepest is not None and now is not None and deepest - now < SAME_MM:
        deepest = None
    cap_kind = "search" if figures.is_search_cap(summary) else "cap"
    named = [
        ("Tube end", "tube", 0.0),
        ("Target", "target", number(summary, "tip", "target_mm")),
        ("Deepest tip", "deepest", deepest),
        ("Tip now", "now", now),
        (cap_name(summary), cap_kind, number(summary, "anatomy", "cap_mm")),
        ("Carina", "carina", number(summary, "anatomy", "carina_mm")),
    ]
    known = [(name, kind, depth) for name, kind, depth in named if depth is not None]
    return sorted(known, key=lambda entry: entry[2])


def drawing(summary: Summary) -> Drawing | None:
    """Drawing of a cycle, or None where the summary has no deepest tip position."""
    deepest = number(summary, "tip", "deepest_mm")
    if deepest is None:
        return None
    depths = [entry for entry in _depths(summary) if entry[2] >= -STRAIGHT_MM]
    bottom_mm = depths[-1][2] + BELOW_MM
    labels = spread([y_px(depth) for _, _, depth in depths])
    marks = [
        Mark(
            name,
            kind,
            f"{name} {quantity(depth, 'mm', 0 if depth == 0.0 else 1)}",
            y_px(depth),
            label,
        )
        for (name, kind, depth), label in zip(depths, labels, strict=True)
    ]
    ticks = [
        Tick(y_px(depth), str(depth) if depth % (2 * TICK_MM) == 0 else "")
        for depth in range(0, int(bottom_mm) - TICK_MM // 2, TICK_MM)
    ]
    carina = number(summary, "anatomy", "carina_mm")
    boundary = number(summary, "anatomy", "patient_boundary_mm")
    listed = "; ".join(f"{name.lower()} at {depth:.1f} mm" for name, _, depth in depths)
    kinds = {kind: depth for _, kind, depth in depths}
    caption = _caption(summary, "deepest" in kinds)
    return Drawing(
        height_px=y_px(bottom_mm),
        tube_end_px=y_px(0.0),
        carina_px=None if carina is None else y_px(carina),
        now_px=y_px(kinds["now"]) if "now" in kinds else None,
        bend_share=_bend_share(number(summary, "tip", "end_mm"), boundary),
        deepest_px=y_px(kinds["deepest"]) if "deepest" in kinds else None,
        upper_end="" if boundary is None or boundary >= 0.0 else quantity(boundary, "mm", 0),
        marks=marks,
        ticks=ticks,
        caption=caption,
        description=(
            "Tracheostomy tube, trachea and main bronchi from the front, with the catheter as it "
            f"is at the end of the record and at its deepest position ({quantity(deepest, 'mm')}). "
            f"{caption} Depths below the tube's end: {listed}."
        ),
    )


def _caption(summary: Summary, is_ghost_drawn: bool) -> str:
    """What is drawn of the catheter, and what its cap is."""
    end_mm = number(summary, "tip", "end_mm")
    said = []
    if is_inside(summary) and end_mm is not None:
        said.append(f"The catheter is still inside, its tip {depth_words(end_mm)}.")
    elif end_mm is not None:
        said.append("The catheter is out at the end of the record.")
    if is_ghost_drawn:
        said.append("Dashed: where the tip was at its deepest.")
    if figures.is_search_cap(summary):
        said.append(
            "The tip stops where it touches the carina; the search for it ends at a depth beyond."
        )
    return " ".join(said)


def _bend_share(end_mm: float | None, boundary_mm: float | None) -> float:
    """Share of the bend, upper end of the tube to its straight part, that the tip has passed."""
    if end_mm is None:
        return 0.0
    if end_mm >= -STRAIGHT_MM:
        return 1.0
    if boundary_mm is None or boundary_mm >= -STRAIGHT_MM:
        return 0.0
    return round(max((end_mm - boundary_mm) / (-STRAIGHT_MM - boundary_mm), 0.0), 3)
