"""Contact switch at the catheter's tip: a ball pressed against a spring closes a circuit.

It closes at a force and opens a little below it; the contact bounces for milliseconds after it
closes, and the line to the controller adds a delay. Mucus and faults are added elsewhere.

Laser displacement sensor on the tip: bench only, for identification and scoring.

The controller never reads it.
"""

from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream


class Laser(NamedTuple):
    """Noise of one reading of the tip position (sensor, target and set-up together)."""

    noise_mm: float


class LaserState(NamedTuple):
    """Last reading, the second of a pair of random numbers, and the stream."""

    reading_mm: float
    spare: float
    has_spare: bool
    stream: RandomStream


@compiled
def step_laser(laser: Laser, state: LaserState, tip_mm: float) -> LaserState:
    """Read the tip once."""
    if state.has_spare:
        return LaserState(tip_mm + laser.noise_mm * state.spare, 0.0, False, state.stream)
    first, second, stream = random_stream.normal_pair(state.stream)
    return LaserState(tip_mm + laser.noise_mm * first, second, True, stream)


class ContactSwitch(NamedTuple):
    """Parameters of the switch."""

    close_n: float
    """Force that closes it (0.08017 N in the paper)."""
    open_n: float
    """Force below which it opens again."""
    bounce_s: float
    """How long the contact chatters after it closes."""
    bounce_open_ratio: float
    """Share of that time in which it is open."""
    latency_s: float
    """Delay from contact to reading."""
    wired: bool
    """Its line is closed through the resistor beside it; a tip that parts takes both along."""


class SwitchState(NamedTuple):
    """State of the switch and of its line."""

    pressed: bool
    since_s: float
    """Time since the ball closed the circuit; 0 while it is released."""
    reading: bool
    line: int
    """Levels on their way along the line, a bit each tick, the latest lowest."""
    stream: RandomStream


LINE_TICKS = 53
"""Longest delay of the line; as many bits a double holds exactly, and a row is of doubles."""
LINE_MASK = (1 << LINE_TICKS) - 1


def released(stream: RandomStream) -> SwitchState:
    """Nothing touches the tip."""
    return SwitchState(pressed=False, since_s=0.0, reading=False, line=0, stream=stream)


@compiled
def step(switch: ContactSwitch, state: SwitchState, force_n: float, dt_s: float) -> SwitchState:
    """Advance by one tick with ``force_n`` on the tip."""
    threshold = switch.open_n if state.pressed else switch.close_n
    pressed = force_n >= threshold
    since = state.since_s + dt_s if pressed and state.pressed else 0.0
    chance, stream = 1.0, state.stream
    # Half a tick forgives a time that is a sum of ticks.
    bouncing = pressed and since < switch.bounce_s - 0.5 * dt_s
    if bouncing:
        chance, _, stream = random_stream.uniform_pair(state.stream)
    level = pressed and (not bouncing or chance >= switch.bounce_open_ratio)
    line = (state.line << 1 | (1 if level else 0)) & LINE_MASK
    delay = min(int(switch.latency_s / dt_s + 0.5), LINE_TICKS - 1)
    return SwitchState(
        pressed=pressed,
        since_s=since,
        reading=(line >> delay & 1) == 1,
        line=line,
        stream=stream,
    )
