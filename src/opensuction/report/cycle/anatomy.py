"""Drawing of tube, trachea and catheter: to scale along the depth, widths schematic."""

from typing import NamedTuple

from opensuction.report.summary import Summary, number
from opensuction.report.wording import quantity

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


class Mark(NamedTuple):
    """A depth with a name, and where its label stands so that labels do not overlap."""

    name: str
    kind: str
    """``tube``, ``target``, ``deepest``, ``cap`` or ``carina``."""
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
    catheter_px: float | None
    """Where the catheter ends at its deepest position; None where it never got into the drawing."""
    upper_end: str
    """Depth of the tube's upper end, where the patient begins; empty where that is not known."""
    marks: list[Mark]
    ticks: list[Tick]
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


def _depths(summary: Summary) -> list[tuple[str, str, float]]:
    """Named depths (name, kind, mm), from the top down."""
    named = [
        ("Tube end", "tube", 0.0),
        ("Target", "target", number(summary, "tip", "target_mm")),
        ("Deepest tip", "deepest", number(summary, "tip", "deepest_mm")),
        ("Cap", "cap", number(summary, "anatomy", "cap_mm")),
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
    return Drawing(
        height_px=y_px(bottom_mm),
        tube_end_px=y_px(0.0),
        carina_px=None if carina is None else y_px(carina),
        catheter_px=None if deepest < -STRAIGHT_MM else y_px(deepest),
        upper_end="" if boundary is None or boundary >= 0.0 else quantity(boundary, "mm", 0),
        marks=marks,
        ticks=ticks,
        description=(
            "Tracheostomy tube, trachea and main bronchi from the front, with the catheter at its "
            f"deepest position ({quantity(deepest, 'mm')}). Depths below the tube's end: {listed}."
        ),
    )
