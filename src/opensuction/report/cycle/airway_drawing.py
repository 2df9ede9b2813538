"""Drawing of tube, trachea and catheter as a cycle left them."""

from typing import NamedTuple

from opensuction.report import airway_geometry, figures
from opensuction.report.airway_geometry import Depth, Mark, Tick, y_px
from opensuction.report.summary import Summary, is_inside, number
from opensuction.report.wording import depth_words, quantity

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


def cap_name(summary: Summary) -> str:
    """What a cap is: a depth that is never passed, or where the search for the carina ends."""
    return "Search ends" if figures.is_search_cap(summary) else "Cap"


def _depths(summary: Summary) -> list[Depth]:
    """What has a name and a depth."""
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
    return [Depth(name, kind, mm) for name, kind, mm in named if mm is not None]


def drawing(summary: Summary) -> Drawing | None:
    """Drawing of a cycle, or None where the summary has no deepest tip position."""
    deepest = number(summary, "tip", "deepest_mm")
    if deepest is None:
        return None
    depths = airway_geometry.visible(_depths(summary))
    boundary = number(summary, "anatomy", "patient_boundary_mm")
    still = airway_geometry.lay_out(depths, number(summary, "anatomy", "carina_mm"), boundary)
    listed = "; ".join(f"{name.lower()} at {depth:.1f} mm" for name, _, depth in depths)
    kinds = {kind: depth for _, kind, depth in depths}
    caption = _caption(summary, "deepest" in kinds)
    return Drawing(
        **still._asdict(),
        now_px=y_px(kinds["now"]) if "now" in kinds else None,
        bend_share=airway_geometry.bend_share(number(summary, "tip", "end_mm"), boundary),
        deepest_px=y_px(kinds["deepest"]) if "deepest" in kinds else None,
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
