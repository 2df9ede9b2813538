"""Duration for which something has held, without a break or with some, in seconds or in ticks."""

from opensuction.kernel.compiled import compiled


@compiled
def extend(seconds: float, holds: bool, dt_s: float) -> float:
    """Duration after another tick: longer by it while something holds, else 0 s."""
    return seconds + dt_s if holds else 0.0


@compiled
def count(ticks: int, holds: bool) -> int:
    """Ticks after another one: one more while something holds, else 0."""
    return ticks + 1 if holds else 0


@compiled
def add_up(seconds: float, holds: bool, fade: float, dt_s: float) -> float:
    """Duration after another tick that breaks do not end: they take a share ``fade`` of theirs off.

    What holds for less than fade / (1 + fade) of the time never adds up.
    """
    return seconds + dt_s if holds else max(seconds - fade * dt_s, 0.0)
