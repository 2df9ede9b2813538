"""The airway's drawing for the bedside: the same geometry and template as a report's.

Depths come with the request, from what `GET /machine` says: the drawing itself knows no machine.
"""

from typing import Annotated

from fastapi import APIRouter, Query, Response

from opensuction.report import airway_geometry, html
from opensuction.report.airway_geometry import Depth

router = APIRouter(tags=["Machine"])

DEEPEST_MM = 400.0
"""Deeper is no airway: of an adult the carina lies some 12 cm below a tube's end."""
RAIL_PX = {"from_px": 242, "to_px": 420}
"""Of the head's way on the drawing: where it is furthest in, and at home."""
LABEL_GAP_PX = 25.0
"""The labels are larger than a report's: they are read from further away."""

Below = Annotated[float | None, Query(ge=-DEEPEST_MM, le=DEEPEST_MM, allow_inf_nan=False)]


def draw(
    target_mm: float | None,
    cap_mm: float | None,
    carina_mm: float | None,
    boundary_mm: float | None,
    by_contact: bool,
) -> str:
    """Draw the fixed and the moving parts as SVG; depths below the tube's end."""
    named = [
        ("Tube end", "tube", 0.0),
        ("Target", "target", target_mm),
        ("Search ends" if by_contact else "Cap", "search" if by_contact else "cap", cap_mm),
        ("Carina", "carina", carina_mm),
    ]
    depths = [Depth(name, kind, mm) for name, kind, mm in named if mm is not None]
    listed = "; ".join(
        f"{one.name.lower()} at {one.mm:.1f} mm" for one in airway_geometry.visible(depths)
    )
    return html.render_part(
        "anatomy_live.svg.j2",
        drawing=airway_geometry.lay_out(depths, carina_mm, boundary_mm, LABEL_GAP_PX),
        rail=RAIL_PX,
        boundary_mm=boundary_mm,
        px_per_mm=airway_geometry.PX_PER_MM,
        above_mm=airway_geometry.ABOVE_MM,
        straight_mm=airway_geometry.STRAIGHT_MM,
        description=(
            "Tracheostomy tube, trachea and main bronchi from the front, with conduit, drive "
            "head and catheter as they "
            f"are now; the depth stands beside in figures. Depths below the tube's end: {listed}."
        ),
    )


@router.get(
    "/anatomy.svg",
    response_class=Response,
    responses={200: {"content": {"image/svg+xml": {}}, "description": "The drawing"}},
)
def show_anatomy(
    target_mm: Below = None,
    cap_mm: Below = None,
    carina_mm: Below = None,
    boundary_mm: Below = None,
    by_contact: bool = False,
) -> Response:
    """The airway's drawing, to scale; depths in mm below the tube's end, negative above it.

    by_contact: the cap is where the search for the carina ends.
    """
    drawn = draw(target_mm, cap_mm, carina_mm, boundary_mm, by_contact)
    return Response(drawn, media_type="image/svg+xml")


@router.get(
    "/anatomy.css",
    response_class=Response,
    responses={200: {"content": {"text/css": {}}, "description": "Its styles"}},
)
def show_style() -> Response:
    """Style of the drawing's parts; the colours are the page's."""
    return Response(html.read("template", "anatomy.css"), media_type="text/css")
