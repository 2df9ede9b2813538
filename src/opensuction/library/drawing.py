"""Curves over an input as a picture of their own: SVG, so that nothing has to be installed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.kernel.record import Array
from opensuction.report.series import keep_rows

WIDTH, HEIGHT = 560, 380
LEFT, RIGHT, TOP, BOTTOM = 64, 16, 34, 48
TICKS = 6
BUCKETS = 600
"""Stretches of a curve of which each keeps its extremes: about a pixel each."""
HUES = ("#8a8f98", "#0b6bcb", "#c2410c", "#15803d", "#7e22ce")


class Curve(NamedTuple):
    """One line of a picture, its points in the order of time."""

    label: str
    x: Array
    y: Array


@dataclass(frozen=True, repr=False)
class Drawing:
    """A picture; a notebook shows it."""

    svg: str

    def save(self, path: str | PathLike[str]) -> None:
        """Write it as an SVG file; raises OSError where that cannot be written."""
        Path(path).write_text(self.svg, encoding="utf-8", errors="backslashreplace")

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"Drawing(SVG, {WIDTH} x {HEIGHT})"


class _Axis(NamedTuple):
    """Axis of a picture: its range of numbers, and its ends in px."""

    low: float
    high: float
    ticks: list[float]
    begin: float
    end: float

    def place(self, values: Array) -> Array:
        """Pixels of numbers."""
        share = (values - self.low) / (self.high - self.low)
        pixels: Array = self.begin + (self.end - self.begin) * share
        return pixels


def _axis(values: Sequence[Array], begin: float, end: float) -> _Axis:
    low, high = min(float(one.min()) for one in values), max(float(one.max()) for one in values)
    if not high > low:
        low, high = low - 0.5, high + 0.5
    raw = (high - low) / TICKS
    decade = 10.0 ** math.floor(math.log10(raw))
    step = next(factor * decade for factor in (1.0, 2.0, 5.0, 10.0) if factor * decade >= raw)
    first = math.ceil(low / step)
    ticks = [step * place for place in range(first, math.floor(high / step) + 1)]
    margin = 0.03 * (high - low)
    return _Axis(low - margin, high + margin, ticks, begin, end)


def _text(x: float, y: float, words: str, anchor: str = "middle", more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{escape(words)}</text>'


def _grid(across: _Axis, up: _Axis) -> list[str]:
    """Lines and numbers of both axes."""
    lines = []
    for tick, x in zip(across.ticks, across.place(np.array(across.ticks)), strict=True):
        lines.append(f'<path d="M{x:.1f} {up.begin}V{up.end}" stroke="#e3e5e8"/>')
        lines.append(_text(float(x), up.begin + 16, f"{tick:.6g}"))
    for tick, y in zip(up.ticks, up.place(np.array(up.ticks)), strict=True):
        lines.append(f'<path d="M{across.begin} {y:.1f}H{across.end}" stroke="#e3e5e8"/>')
        lines.append(_text(across.begin - 6, float(y) + 4, f"{tick:.6g}", "end"))
    return lines


def _line(curve: Curve, across: _Axis, up: _Axis, hue: str) -> str:
    rows = keep_rows([curve.x, curve.y], [], BUCKETS)
    points = zip(across.place(curve.x[rows]), up.place(curve.y[rows]), strict=True)
    drawn = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{drawn}" fill="none" stroke="{hue}" stroke-width="1.5"/>'


def draw(title: str, labels: tuple[str, str], curves: Sequence[Curve]) -> Drawing:
    """Curves in one picture, the later ones above. labels: of both axes."""
    across = _axis([curve.x for curve in curves], LEFT, WIDTH - RIGHT)
    up = _axis([curve.y for curve in curves], HEIGHT - BOTTOM, TOP)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
        f'height="{HEIGHT}" font-family="sans-serif" font-size="12" role="img">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        *_grid(across, up),
        _text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 12, labels[0]),
        _text(0, 0, labels[1], more=f' transform="translate(16 {HEIGHT / 2}) rotate(-90)"'),
    ]
    at = float(LEFT)
    for place, curve in enumerate(curves):
        hue = HUES[place % len(HUES)]
        lines.append(_line(curve, across, up, hue))
        lines.append(f'<path d="M{at:.1f} 18h16" stroke="{hue}" stroke-width="3"/>')
        lines.append(_text(at + 20, 22, curve.label, "start"))
        at += 40 + 7.0 * len(curve.label)
    return Drawing("\n".join([*lines, "</svg>", ""]))
