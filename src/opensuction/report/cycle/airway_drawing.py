"""Drawing of tube, trachea and catheter as a cycle left them."""

from typing import NamedTuple

from opensuction.report import airway_geometry, figures
from opensuction.report.airway_geometry import Depth, Mark, Tick, y_px
from opensuction.report.wording import depth_words, quantity
from opensuction.result.cycle_result import CycleResult

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
    depths = airway_geometry.visible(_depths(result))
    boundary = result.anatomy.patient_boundary_mm
    still = airway_geometry.lay_out(depths, result.anatomy.carina_mm, boundary)
    listed = "; ".join(f"{name.lower()} at {depth:.1f} mm" for name, _, depth in depths)
    kinds = {kind: depth for _, kind, depth in depths}
    caption = _caption(result, "deepest" in kinds)
    return Drawing(
        **still._asdict(),
        now_px=y_px(kinds["now"]) if "now" in kinds else None,
        bend_share=airway_geometry.bend_share(result.tip.end_mm, boundary),
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
