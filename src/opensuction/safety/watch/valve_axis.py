"""Supervision of the valve's cam against its command: it must move at once, and arrive in time."""

from typing import NamedTuple

from opensuction.kernel.arithmetic import extend_duration
from opensuction.kernel.compiled import compiled
from opensuction.safety.limits import ValveLimits

CLOSED_RAD = 0.02
"""Cam angle (1.1 degrees) below which the valve's seal holds."""
BEHIND_RAD = 0.03
"""Angle behind it at which a closed cam can be: its end stop 0.5 degrees, the sensor's zero 0.6 and
its noise 0.2 [computed]."""
OPEN_SHARE = 0.9
"""Share of the open angle from which the cam has arrived; a servo settles at 0.95 or more."""
STILL_S = 0.15
"""How long the cam may stand on its way; against its spring it starts within 0.02 s [computed]:
1.2 V of spring and friction at 7 V/deg and 15 deg/s."""
STILL_RAD = 0.005
"""Way of a cam that has not moved: its sensor's noise is 0.03 degrees either way, and a twentieth
its step [computed]; one that moves at 15 deg/s goes it in 20 ms."""
OVERDUE_SHARE = 1.5
"""A stroke may last this many times its planned duration (and `SETTLE_S`)."""
SETTLE_S = 0.5
"""Time for the valve's servo to settle; assumed, as in the pre-use test."""


class ValveAxis(NamedTuple):
    """Watch on the valve's cam: time away from its commanded end, s."""

    away_s: float
    still_s: float
    """And has not moved meanwhile."""
    still_rad: float
    """Where it has stood meanwhile."""
    resting: bool
    """Commanded to close, it has closed since: the spring alone holds it there."""


START = ValveAxis(away_s=0.0, still_s=0.0, still_rad=0.0, resting=False)


@compiled
def is_open(limits: ValveLimits, cam_rad: float) -> bool:
    """True where the valve has opened as far as commanded."""
    return cam_rad >= OPEN_SHARE * limits.open_rad


@compiled
def is_closed(cam_rad: float) -> bool:
    """True where the valve's seal holds."""
    return -BEHIND_RAD <= cam_rad <= CLOSED_RAD


@compiled
def step(
    limits: ValveLimits,
    state: ValveAxis,
    opened: bool,
    command_changed: bool,
    cam_rad: float,
    dt_s: float,
) -> ValveAxis:
    """Bring it up to this tick.

    opened: the valve is commanded to be open. command_changed: it was not, or was, a tick ago.
    """
    arrived = is_open(limits, cam_rad) if opened else is_closed(cam_rad)
    away = not arrived and not command_changed
    still = abs(cam_rad - state.still_rad) <= STILL_RAD
    return ValveAxis(
        away_s=extend_duration(state.away_s, away, dt_s),
        still_s=extend_duration(state.still_s, away and still, dt_s),
        still_rad=state.still_rad if still else cam_rad,
        resting=not opened and (arrived or (state.resting and not command_changed)),
    )


@compiled
def restart(state: ValveAxis) -> ValveAxis:
    """Forget for how long the cam has been away."""
    return state._replace(away_s=0.0, still_s=0.0)


@compiled
def is_stuck(limits: ValveLimits, state: ValveAxis) -> bool:
    """True where the cam does not follow."""
    return state.still_s > STILL_S or state.away_s > OVERDUE_SHARE * limits.stroke_s + SETTLE_S
