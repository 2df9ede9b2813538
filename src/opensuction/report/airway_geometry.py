"""Geometry of the airway's drawing: to scale along the depth, widths schematic.

One for reports, which draw how a cycle ended, and for the console, which draws what is going on.

Drawing of tube, trachea and catheter as a cycle left them.
"""

from collections.abc import Iterable
from typing import NamedTuple

from opensuction.report import figures
from opensuction.report.wording import depth_words, quantity
from opensuction.result.cycle_result import CycleResult

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
TICK_MM = 10
"""Ticks of the scale; every second one has a number."""


class Depth(NamedTuple):
    """Something that has a name and a depth below the tube's end."""

    name: str
    kind: str
    """``tube``, ``target``, ``now``, ``deepest``, ``cap``, ``search`` or ``carina``."""
    mm: float


class Mark(NamedTuple):
    """A depth with a name, and where its label stands so that labels do not overlap."""

    name: str
    kind: str
    """As of `Depth`."""
    text: str
    y_px: float
    label_y_px: float


class Tick(NamedTuple):
    """A tick of the scale; ``text`` is empty for a short one."""

    y_px: float
    text: str


class Still(NamedTuple):
    """Fixed parts of the drawing; depths are in px from the top."""

    height_px: float
    tube_end_px: float
    carina_px: float | None
    upper_end: str
    """Depth of the tube's upper end, where the patient begins; empty where that is not known."""
    marks: list[Mark]
    ticks: list[Tick]


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


def visible(depths: Iterable[Depth]) -> list[Depth]:
    """Those that are in the straight part of the drawing, from the top down."""
    return sorted((one for one in depths if one.mm >= -STRAIGHT_MM), key=lambda one: one.mm)


def lay_out(
    depths: Iterable[Depth],
    carina_mm: float | None,
    boundary_mm: float | None,
    gap_px: float = LABEL_GAP_PX,
) -> Still:
    """Everything that stands still, with room for all of some depths (at least one)."""
    seen = visible(depths)
    bottom_mm = seen[-1].mm + BELOW_MM
    labels = spread([y_px(one.mm) for one in seen], gap_px)
    return Still(
        height_px=y_px(bottom_mm),
        tube_end_px=y_px(0.0),
        carina_px=None if carina_mm is None else y_px(carina_mm),
        upper_end=(
            "" if boundary_mm is None or boundary_mm >= 0.0 else quantity(boundary_mm, "mm", 0)
        ),
        marks=[
            Mark(
                name,
                kind,
                f"{name} {quantity(mm, 'mm', 0 if mm == 0.0 else 1)}",
                y_px(mm),
                label_px,
            )
            for (name, kind, mm), label_px in zip(seen, labels, strict=True)
        ],
        ticks=[
            Tick(y_px(mm), str(mm) if mm % (2 * TICK_MM) == 0 else "")
            for mm in range(0, int(bottom_mm) - TICK_MM // 2, TICK_MM)
        ],
    )


def bend_share(tip_mm: float | None, boundary_mm: float | None) -> float:
    """Share of the bend, upper end of the tube to its straight part, that the tip has passed."""
    if tip_mm is None:
        return 0.0
    if tip_mm >= -STRAIGHT_MM:
        return 1.0
    if boundary_mm is None or boundary_mm >= -STRAIGHT_MM:
        return 0.0
    return round(max((tip_mm - boundary_mm) / (-STRAIGHT_MM - boundary_mm), 0.0), 3)


SAME_MM = 0.5
"""A deepest position this near to where the tip is now is not drawn beside it."""


class Drawing(NamedTuple):
    """Everything that the template needs; depths are in px from the top."""

    height_px: float
    tube_end_px: float
    carina_px: float | None
    upper_end: str
    """All down to the ticks: as of `airway_geometry.Still`."""
    marks: list[Mark]
    ticks: list[Tick]
    now_px: float | None
    """Where the catheter ends now; None where it is out of the drawing's straight part."""
    bend_share: float
    """Share of the tube's bend that the catheter fills now, 0 to 1."""
    deepest_px: float | None
    """Where it ended at its deepest; None where it never got into the drawing, or is there now."""
    caption: str
    """What is drawn, in a sentence or two."""
    description: str
    """The drawing in words, for those who do not see it."""


def cap_name(result: CycleResult) -> str:
    """Name of a cap: a depth that is never passed, or the end of the search for the carina."""
    return "Search ends" if figures.is_search_cap(result) else "Cap"


def _depths(result: CycleResult) -> list[Depth]:
    """Depths to draw, each with its name."""
    deepest, now = result.tip.deepest_mm, result.tip.end_mm
    if deepest is not None and now is not None and deepest - now < SAME_MM:
        deepest = None
    cap_kind = "search" if figures.is_search_cap(result) else "cap"
    named = [
        ("Tube end", "tube", 0.0),
        ("Target", "target", result.tip.target_mm),
        ("Deepest tip", "deepest", deepest),
        ("Tip now", "now", now),
        (cap_name(result), cap_kind, result.anatomy.cap_mm),
        ("Carina", "carina", result.anatomy.carina_mm),
    ]
    return [Depth(name, kind, mm) for name, kind, mm in named if mm is not None]


def drawing(result: CycleResult) -> Drawing | None:
    """Drawing of a cycle, or None where the result has no deepest tip position."""
    deepest = result.tip.deepest_mm
    if deepest is None:
        return None
    depths = visible(_depths(result))
    boundary = result.anatomy.patient_boundary_mm
    still = lay_out(depths, result.anatomy.carina_mm, boundary)
    listed = "; ".join(f"{name.lower()} at {depth:.1f} mm" for name, _, depth in depths)
    kinds = {kind: depth for _, kind, depth in depths}
    caption = _caption(result, "deepest" in kinds)
    return Drawing(
        **still._asdict(),
        now_px=y_px(kinds["now"]) if "now" in kinds else None,
        bend_share=bend_share(result.tip.end_mm, boundary),
        deepest_px=y_px(kinds["deepest"]) if "deepest" in kinds else None,
        caption=caption,
        description=(
            "Tracheostomy tube, trachea and main bronchi from the front, with the catheter as it "
            f"is at the end of the record and at its deepest position ({quantity(deepest, 'mm')}). "
            f"{caption} Depths below the tube's end: {listed}."
        ),
    )


def _caption(result: CycleResult, is_ghost_drawn: bool) -> str:
    """Caption on the drawn catheter and its cap."""
    end_mm = result.tip.end_mm
    said = []
    if result.is_inside and end_mm is not None:
        said.append(f"The catheter is still inside, its tip {depth_words(end_mm)}.")
    elif end_mm is not None:
        said.append("The catheter is out at the end of the record.")
    if is_ghost_drawn:
        said.append("Dashed: where the tip was at its deepest.")
    if figures.is_search_cap(result):
        said.append(
            "The tip stops where it touches the carina; the search for it ends at a depth beyond."
        )
    return " ".join(said)
