"""Head ways that conduits of any class are led along in tests."""

from itertools import pairwise

import numpy as np

from opensuction.kernel.record import Array

DT_S = 0.001


def strokes_mm(speed_mm_per_s: float, *points_mm: float) -> Array:
    """Head positions tick by tick from point to point at constant speed, the first left out."""
    ways = []
    for begin, end in pairwise(points_mm):
        ticks = max(round(abs(end - begin) / (speed_mm_per_s * DT_S)), 1)
        ways.append(np.linspace(begin, end, ticks + 1)[1:])
    return np.concatenate(ways)
