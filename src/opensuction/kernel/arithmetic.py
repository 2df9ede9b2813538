"""Arithmetic of a tick: durations, numbers that are as good as nothing, sets as bit masks.

A duration says for how long something has held, without a break or with some, in seconds or ticks.

What decays to zero never gets there: it halves and halves. Below 1e-308 a processor takes some
hundred cycles for each sum or product with such a number; a controller that has been at rest for
half a minute then takes half as long again for a tick, and nothing has changed but the time.

Sets of numbered things as bit masks: bit ``n`` is the thing of number ``n``.
"""

from opensuction.kernel.compiled import compiled


@compiled
def flag(holds: bool, number: int) -> int:
    """Mask with the bit of a number if something holds, else 0."""
    return 1 << number if holds else 0


TINY = 1e-30
"""Less is nothing, in whatever unit: also its square is far from where numbers become slow."""


@compiled
def drop_tiny(value: float) -> float:
    """The value; 0 where it is as good as nothing."""
    return 0.0 if abs(value) < TINY else value


@compiled
def extend_duration(seconds: float, holds: bool, dt_s: float) -> float:
    """Duration after another tick: longer by it while something holds, else 0 s."""
    return seconds + dt_s if holds else 0.0


@compiled
def count_ticks(ticks: int, holds: bool) -> int:
    """Ticks after another one: one more while something holds, else 0."""
    return ticks + 1 if holds else 0


@compiled
def add_up_duration(seconds: float, holds: bool, fade: float, dt_s: float) -> float:
    """Duration after another tick that breaks do not end: they take a share ``fade`` of theirs off.

    What holds for less than fade / (1 + fade) of the time never adds up.
    """
    return seconds + dt_s if holds else max(seconds - fade * dt_s, 0.0)
