"""Values of alarm sounds and lights: the range that IEC 60601-1-8 asks for, the choice, its source.

No text of the standard could be read: docs/sources.md says what each tag stands for.
"""

import math
from typing import NamedTuple

F = "[PUI-Audio]"
K = "[K]"
OWN = "[design]"


class Value(NamedTuple):
    """A value, the range it must lie in, and where that range is from."""

    value: float
    least: float
    most: float
    unit: str
    source: str


class Tone(NamedTuple):
    """Sound of one priority."""

    pattern: tuple[int, ...]
    """Pulses of each group of a burst; the groups of a half are 2 x pause + pulse apart."""
    halves: int
    """How often the pattern comes in a burst."""
    fundamental_hz: Value
    pulse_s: Value
    """Effective length of a pulse."""
    pause_s: Value
    """Pause between the pulses of a group: x of the high, y of the medium priority."""
    half_pause_s: Value
    """Pause between the halves, where there are two."""
    interval_s: Value
    """Between bursts."""

    def pauses_s(self) -> tuple[float, ...]:
        """Pauses between successive pulses of a burst."""
        inner = (self.pause_s.value,)
        between_groups = 2.0 * self.pause_s.value + self.pulse_s.value
        half: tuple[float, ...] = ()
        for index, count in enumerate(self.pattern):
            half += ((between_groups,) if index else ()) + inner * (count - 1)
        return half + ((self.half_pause_s.value, *half) * (self.halves - 1))


def _fundamental(value_hz: float) -> Value:
    return Value(value_hz, 150.0, 1000.0, "Hz", F)


HARMONICS = Value(5.0, 4.0, math.inf, "between 300 and 4000 Hz", F)
HARMONIC_DB = Value(-3.0, -15.0 / 4.0, 15.0 / 4.0, "dB from each to the next: 15 dB over five", F)
EDGE_SHARE = Value(0.25, 0.17, 0.34, "of the pulse: whole rise, 59 % of it from 10 to 90 %", K)
NO_HALF = Value(0.0, 0.0, 0.0, "s", "has one half only")

HIGH = Tone(
    pattern=(3, 2),
    halves=2,
    fundamental_hz=_fundamental(660.0),
    pulse_s=Value(0.150, 0.075, 0.200, "s", K),
    pause_s=Value(0.100, 0.050, 0.125, "s", K),
    half_pause_s=Value(0.60, 0.35, 1.30, "s", K),
    interval_s=Value(3.0, 2.5, 15.0, "s", K),
)
MEDIUM = Tone(
    pattern=(3,),
    halves=1,
    fundamental_hz=_fundamental(523.0),
    pulse_s=Value(0.200, 0.125, 0.250, "s", K),
    pause_s=Value(0.200, 0.125, 0.250, "s", K),
    half_pause_s=NO_HALF,
    interval_s=Value(4.0, 2.5, 30.0, "s", K),
)
LOW = MEDIUM._replace(
    pattern=(2,),
    fundamental_hz=_fundamental(392.0),
    interval_s=Value(16.0, 15.0, math.inf, "s", K),
)
REMINDER = LOW._replace(pattern=(1,), interval_s=Value(60.0, 15.0, math.inf, "s", OWN))
"""One pulse of the low priority; the alarm step says when (`Signals.reminder`)."""


class Light(NamedTuple):
    """Visual signal of one priority."""

    colour: str
    flash_hz: Value
    """0: steady."""
    duty_ratio: Value
    """Share of a period in which it is lit."""


DUTY = Value(0.5, 0.2, 0.6, "of the period", K)
HIGH_LIGHT = Light("red", Value(2.0, 1.4, 2.8, "Hz", K), DUTY)
MEDIUM_LIGHT = Light("yellow", Value(0.6, 0.4, 0.8, "Hz", K), DUTY)
LOW_LIGHT = Light("cyan", Value(0.0, 0.0, 0.0, "Hz", K), Value(1.0, 1.0, 1.0, "of the period", K))
DARK = Light("none", LOW_LIGHT.flash_hz, Value(0.0, 0.0, 0.0, "of the period", OWN))
