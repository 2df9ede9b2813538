"""Heart rate, as far as suction changes it: the vagus slows it, and so does deep hypoxia.

A catheter in the trachea stimulates the vagus, suction and the carina more. Its tone rises in
seconds and fades more slowly. Deep hypoxia slows the heart besides. The rise of the rate in mild
hypoxia, drugs and arrhythmia are left out: what counts here is how low it can get.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.denormals import drop_tiny

TRACHEAL_STIMULUS = 0.5
"""Of a catheter beyond the tube, against the strongest stimulus (1); assumed."""
SUCTION_STIMULUS = 0.5
"""What suction adds there; assumed. Contact with the carina is the strongest stimulus alone."""
HYPOXIC_SPAN = 0.4
"""Saturation below the threshold over which hypoxia takes its whole share; assumed."""
HYPOXIC_FALL = 0.7
"""Share of the rate that the deepest hypoxia takes; assumed."""


class Heart(NamedTuple):
    """One patient's heart."""

    rest_per_min: float
    vagal_ratio: float
    """Share of the rate that the strongest stimulus takes in the end."""
    vagal_s: float
    """Time constant of the tone's rise."""
    recovery_s: float
    """Time constant of its fading."""
    hypoxic_ratio: float
    """Arterial saturation below which hypoxia slows the heart."""


class HeartState(NamedTuple):
    """State of the heart."""

    tone: float
    """Vagal tone above rest, 0 to 1."""
    rate_per_min: float


def at_rest(heart: Heart) -> HeartState:
    """A heart that nothing stimulates, well supplied."""
    return HeartState(tone=0.0, rate_per_min=heart.rest_per_min)


@compiled
def stimulus(beyond_tube: bool, sucking: bool, touching: bool) -> float:
    """Stimulus of the vagus by the catheter, 0 to 1."""
    if not beyond_tube:
        return 0.0
    if touching:
        return 1.0
    return TRACHEAL_STIMULUS + (SUCTION_STIMULUS if sucking else 0.0)


@compiled
def step(
    heart: Heart, state: HeartState, stimulated: float, saturation: float, dt_s: float
) -> HeartState:
    """Advance by one step at a given stimulus and arterial saturation (0 to 1); backward Euler."""
    time_constant_s = heart.vagal_s if stimulated > state.tone else heart.recovery_s
    share = dt_s / (time_constant_s + dt_s)
    tone = drop_tiny(state.tone + share * (stimulated - state.tone))
    hypoxia = min(max((heart.hypoxic_ratio - saturation) / HYPOXIC_SPAN, 0.0), 1.0)
    rate = heart.rest_per_min * (1.0 - heart.vagal_ratio * tone) * (1.0 - HYPOXIC_FALL * hypoxia)
    return HeartState(tone=tone, rate_per_min=rate)
