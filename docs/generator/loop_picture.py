"""The same input through every hysteresis model, as a picture."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis.bouc_wen import BoucWen
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import simulate
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.generalised import on_range, with_factors
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.hysteresis.play import Play
from opensuction.hysteresis.preisach import Preisach

TURNS_MM = (0.0, 72.0, 54.0, 72.0, 100.0, 28.0, 46.0, 28.0, 0.0)
PANEL, MARGIN, COLUMNS = 200, 34, 3
STROKE = "#1f5f8b"


def _preisach() -> Preisach:
    """More relays in the upper part of the range than in the lower."""
    k, j = np.indices((20, 20))
    inside = (k > 0) & (k < 10) & (k + j < 20)
    weights_mm = np.where(inside, 0.03 + 0.05 * j, 0.0)
    weights_mm[0] = 1.5
    return Preisach(0.0, 100.0, weights_mm, 0.0)


def _records() -> dict[str, tuple[str, object]]:
    """Title and record of each panel's model."""
    generalised = on_range(0.0, 100.0, np.array([4.0, 15.0]), np.array([15.0]), 3)
    factors = np.array([0.05, 0.15, 0.3, 35.0, 32.0, -6.0, 8.0])
    return {
        "dahl": ("Dahl (force)", Dahl(stiffness_n_per_mm=0.15, coulomb_n=1.0)),
        "modified-dahl": ("modified Dahl, published", PUBLISHED),
        "bouc-wen": ("Bouc-Wen", BoucWen(1.0, 0.004, 0.001, 2.0, 0.95, -0.6, -7.0)),
        "play": ("play", Play(width_mm=20.0, gain=0.95, offset_mm=-6.2)),
        "preisach": ("Preisach", _preisach()),
        "generalised": ("generalised", with_factors(generalised, factors)),
    }


def _points(x: NDArray[np.float64], y: NDArray[np.float64], left: float, top: float) -> str:
    """A curve that fills a panel, as SVG points."""
    room = PANEL - MARGIN
    across = left + MARGIN / 2 + room * (x - x.min()) / np.ptp(x)
    down = top + MARGIN + (room - MARGIN / 2) * (y.max() - y) / np.ptp(y)
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))


def svg() -> str:
    """The picture."""
    x_mm = np.concatenate([np.linspace(a, b, 60) for a, b in pairwise(TURNS_MM)])
    rows = -(-len(_records()) // COLUMNS)
    width, height = COLUMNS * PANEL, rows * PANEL
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}" font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for index, (name, (title, record)) in enumerate(_records().items()):
        left, top = PANEL * (index % COLUMNS), PANEL * (index // COLUMNS)
        y_mm = simulate(CATALOGUE[name], record, x_mm, -1.0)
        points = _points(x_mm, y_mm, left, top)
        lines += [
            f'<text x="{left + MARGIN // 2}" y="{top + 20}" fill="#333">{title}</text>',
            f'<polyline points="{points}" fill="none" stroke="{STROKE}" stroke-width="1.5"/>',
        ]
    return "\n".join([*lines, "</svg>", ""])
