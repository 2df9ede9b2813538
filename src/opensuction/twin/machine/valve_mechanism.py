"""Cam, follower and return spring of the suction valve.

The cam lifts in proportion to its angle, so the spring's torque, force times lift per radian,
grows with the angle and nowhere vanishes: without motor torque the valve closes from any opening.
"""

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
    stop_rad: float
    """End stop, this far behind the closed position."""
    least_ratio: float
    """The slide closes no further: 0, but where it sticks open or its seal is torn."""
    most_ratio: float
    """The slide opens no further: 1, but where it has parted from the cam."""


@compiled
def slide_mm(valve: ValveMechanism, cam_rad: float) -> float:
    """Valve travel for a cam angle, in proportion between closed and full stroke."""
    return valve.slide_mm * min(max(cam_rad / valve.stroke_rad, 0.0), 1.0)


@compiled
def open_ratio(valve: ValveMechanism, cam_rad: float) -> float:
    """Share of the valve's full opening, 0 to 1."""
    past_seal = slide_mm(valve, cam_rad) - valve.seal_mm
    lifted = past_seal / (valve.slide_mm - valve.seal_mm)
    return min(max(lifted, valve.least_ratio), valve.most_ratio)


@compiled
def load_v(valve: ValveMechanism, cam_rad: float) -> float:
    """Load of the spring on the valve axis, as a voltage; none once the cam has let go."""
    if cam_rad <= 0.0:
        return 0.0
    return valve.spring_preload_v + valve.spring_v_per_rad * cam_rad
