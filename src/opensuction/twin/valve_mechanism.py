"""Cam, follower and return spring of the suction valve."""

import math
from typing import NamedTuple

from opensuction.kernel.compiled import compiled


class ValveMechanism(NamedTuple):
    """The cam pushes the valve open, the spring pushes it back."""

    stroke_rad: float
    """Cam angle of the full stroke (30 degrees)."""
    slide_mm: float
    """Travel of the valve at the full stroke (s = 5 mm)."""
    seal_mm: float
    """Travel before the seal opens."""
    spring_preload_v: float
    """Load of the closed spring on the valve axis, as the voltage that balances it."""
    spring_v_per_rad: float


@compiled
def slide_mm(valve: ValveMechanism, cam_rad: float) -> float:
    """Valve travel for a cam angle: harmonic cam, dwelling at both ends."""
    share = min(max(cam_rad / valve.stroke_rad, 0.0), 1.0)
    return valve.slide_mm * 0.5 * (1.0 - math.cos(math.pi * share))


@compiled
def open_ratio(valve: ValveMechanism, cam_rad: float) -> float:
    """Share of the valve's full opening, 0 to 1."""
    past_seal = slide_mm(valve, cam_rad) - valve.seal_mm
    return min(max(past_seal / (valve.slide_mm - valve.seal_mm), 0.0), 1.0)


@compiled
def load_v(valve: ValveMechanism, cam_rad: float) -> float:
    """Load of the spring on the valve axis, as a voltage; none once the cam has let go."""
    if cam_rad <= 0.0:
        return 0.0
    return valve.spring_preload_v + valve.spring_v_per_rad * cam_rad
