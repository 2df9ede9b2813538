"""The phases and what leads from one to the next when all is well, as a picture."""

from math import hypot

from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import ACTIVE, NORMAL

COLUMN, ROW, BOX_WIDTH, BOX_HEIGHT = 244, 104, 140, 34
LEFT, TOP, WIDTH, HEIGHT = 146, 24, 726, 568
APART = 7
"""Half the distance of two arrows that run to and fro between the same boxes."""
NEAR_START = 0.35
"""Share of a slanting arrow at which its label stands: the boxes are widest apart there."""
INK, LINE, ACCENT = "#1d2a33", "#5b6b78", "#1f5f8b"
PLACES = {  # column and row
    Phase.TEACHING: (0, 1),
    Phase.IDENTIFYING: (1, 0),
    Phase.PARKED: (1, 1),
    Phase.OUT_OF_SERVICE: (0, 2),
    Phase.HALTED: (0, 3),
    Phase.ABORTING: (0, 4),
    Phase.CHECKING: (1, 2),
    Phase.PRELOADING: (1, 3),
    Phase.INSERTING: (1, 4),
    Phase.BACKING_OFF: (1, 5),
    Phase.OPENING: (2, 5),
    Phase.SUCTIONING: (2, 4),
    Phase.WITHDRAWING: (2, 3),
    Phase.CLOSING: (2, 2),
}
STYLE = (
    f"text{{font:13px sans-serif;fill:{INK}}} .name{{font-weight:bold;text-anchor:middle}} "
    f".event{{font-size:12px;fill:{LINE};paint-order:stroke;stroke:white;stroke-width:4px}} "
    f"path{{stroke:{LINE};marker-end:url(#tip)}} marker path{{fill:{LINE};marker:none}}"
)


def words(name: str) -> str:
    """A phase or an event as it is written in a sentence."""
    return name.lower().replace("_", " ")


def arrows() -> dict[tuple[Phase, Phase], list[str]]:
    """Events that lead from one phase to another, when all is well."""
    found: dict[tuple[Phase, Phase], list[str]] = {}
    for (phase, event), following in NORMAL.items():
        found.setdefault((phase, following), []).append(words(event.name))
    return found


def _centre(phase: Phase) -> tuple[float, float]:
    column, row = PLACES[phase]
    return LEFT + COLUMN * column, TOP + ROW * row


def _leaves(offset: tuple[float, float], dx: float, dy: float) -> float:
    """Share of the way (dx, dy) after which a line that starts beside the centre leaves a box."""
    shares = [
        ((size if way > 0.0 else -size) - start) / way
        for start, way, size in (
            (offset[0], dx, BOX_WIDTH / 2),
            (offset[1], dy, BOX_HEIGHT / 2),
        )
        if way
    ]
    return min(shares)


def _arrow(one: Phase, other: Phase, events: list[str], both: bool) -> list[str]:
    (x1, y1), (x2, y2) = _centre(one), _centre(other)
    dx, dy = x2 - x1, y2 - y1
    aside = APART / hypot(dx, dy) if both else 0.0
    offset = (-dy * aside, dx * aside)
    first, last = _leaves(offset, dx, dy), 1.0 - _leaves(offset, -dx, -dy)
    ax, ay = x1 + offset[0] + first * dx, y1 + offset[1] + first * dy
    bx, by = x1 + offset[0] + last * dx, y1 + offset[1] + last * dy
    arrow = f'<path d="M{ax:.0f} {ay:.0f}L{bx:.0f} {by:.0f}"/>'
    share = 0.5 if both or not dx or not dy else NEAR_START
    place = (ax + share * (bx - ax), ay + share * (by - ay))
    return [arrow, *_labels(place, (dx, dy), events, both)]


def _labels(
    place: tuple[float, float], way: tuple[float, float], events: list[str], both: bool
) -> list[str]:
    """The events of an arrow: on the outer side of one of a pair, else to its right."""
    dx, dy = way
    side = -1 if both and (dy > 0.0 or (dx and dy > -ROW)) else 1
    anchor, x, y = ("start", 6, 4) if side > 0 else ("end", -6, 4)
    if dy == 0.0:
        anchor, x, y = "middle", 0, (17 if both and dx > 0.0 else -6)
    return [
        f'<text class="event" x="{place[0] + x:.0f}" y="{place[1] + y + 14 * line:.0f}" '
        f'text-anchor="{anchor}">{event}</text>'
        for line, event in enumerate(events)
    ]


def _box(phase: Phase) -> str:
    x, y = _centre(phase)
    colour, fill = (ACCENT, "#dcebf7") if phase in ACTIVE else (LINE, "#f4f5f6")
    return (
        f'<rect x="{x - BOX_WIDTH / 2:.0f}" y="{y - BOX_HEIGHT / 2:.0f}" width="{BOX_WIDTH}" '
        f'height="{BOX_HEIGHT}" rx="8" fill="{fill}" stroke="{colour}"/>'
        f'<text class="name" x="{x:.0f}" y="{y + 5:.0f}">{phase.name}</text>'
    )


def svg() -> str:
    """The picture; blue boxes can be broken off into ABORTING."""
    drawn = arrows()
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'width="{WIDTH}" height="{HEIGHT}"><style>{STYLE}</style>',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" '
        'markerHeight="8" orient="auto"><path d="M0 0L8 4L0 8z"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    for (one, other), events in drawn.items():
        lines += _arrow(one, other, events, (other, one) in drawn)
    lines += [_box(phase) for phase in PLACES]
    return "\n".join([*lines, "</svg>", ""])
