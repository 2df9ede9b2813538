"""Values of alarm sounds and lights: the range that IEC 60601-1-8 asks for, the choice, its source.

No text of the standard could be read: docs/sources.md says what each tag stands for.

The light of an alarm as a function of time: colour and flashing of IEC 60601-1-8.

The sound of an alarm as samples: bursts of pulses with the timing of IEC 60601-1-8.

A *pulse* is one tone with several harmonics; a *burst* is a pattern of pulses; bursts repeat after
an interval for as long as the alarm sounds. High: ten pulses, twice three and two; medium: three;
low: two; the reminder: one. Not compiled: a loudspeaker's buffer is filled well ahead of time.
Timing of a pulse counts between the points at 90 % of its amplitude.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.safety.handling import Priority

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


LIGHTS: dict[Priority, Light] = {
    Priority.HIGH: HIGH_LIGHT,
    Priority.MEDIUM: MEDIUM_LIGHT,
    Priority.LOW: LOW_LIGHT,
    Priority.NONE: DARK,
}
"""Of each priority; `Priority.NONE` is dark."""


def is_lit(priority: Priority, time_s: float) -> bool:
    """True while the light is on at a time since any fixed beginning.

    It flashes for as long as the alarm is shown, acknowledged or paused as it may be.
    """
    light = LIGHTS[priority]
    phase = (time_s * light.flash_hz.value) % 1.0
    return phase < light.duty_ratio.value


Samples = Array

TONES: dict[Priority, Tone] = {
    Priority.HIGH: HIGH,
    Priority.MEDIUM: MEDIUM,
    Priority.LOW: LOW,
    Priority.NONE: REMINDER,
}
"""Of each priority; with nothing to sound, the reminder's."""

NINETY_PERCENT = math.acos(-0.8) / math.pi
"""Share of a raised-cosine edge after which 90 % of the amplitude is reached: 0.795."""


class Pulse(NamedTuple):
    """One tone of a burst, between its points at 90 %."""

    start_s: float
    end_s: float


def pulses(priority: Priority) -> tuple[Pulse, ...]:
    """The pulses of one burst, the first at 0 s."""
    tone = TONES[priority]
    pulse_s = tone.pulse_s.value
    starts = [0.0]
    for pause_s in tone.pauses_s():
        starts.append(starts[-1] + pulse_s + pause_s)
    return tuple(Pulse(start_s, start_s + pulse_s) for start_s in starts)


def edge_s(priority: Priority) -> float:
    """Whole length of the rise, and of the fall, of a pulse."""
    return EDGE_SHARE.value * TONES[priority].pulse_s.value


def burst_s(priority: Priority) -> float:
    """Length of a burst with the foot of its first rise and its last fall."""
    return pulses(priority)[-1].end_s + 2.0 * NINETY_PERCENT * edge_s(priority)


def envelope(priority: Priority, time_s: Samples) -> Samples:
    """Amplitude 0 to 1 at times since the beginning of a burst, of any shape."""
    edge = edge_s(priority)
    foot_s = NINETY_PERCENT * edge
    level = np.zeros_like(time_s)
    for pulse in pulses(priority):
        inside_s = np.minimum(time_s - pulse.start_s, pulse.end_s + 2.0 * foot_s - time_s)
        rise = np.clip(inside_s / edge, 0.0, 1.0)
        level += 0.5 * (1.0 - np.cos(np.pi * rise))
    return level


def _tone(priority: Priority, time_s: Samples) -> Samples:
    """The fundamental and its harmonics; their amplitudes add up to 1."""
    fundamental_hz = TONES[priority].fundamental_hz.value
    levels = [10.0 ** (HARMONIC_DB.value * order / 20.0) for order in range(int(HARMONICS.value))]
    wave = np.zeros_like(time_s)
    for order, level in enumerate(levels, start=1):
        wave += level * np.sin(2.0 * np.pi * order * fundamental_hz * time_s)
    wave /= sum(levels)
    return wave


def burst(priority: Priority, sample_rate_hz: float) -> Samples:
    """One burst, samples between -1 and 1; ``Priority.NONE`` gives the reminder.

    Raises InputError for a rate too low for the highest harmonic.
    """
    least_hz = 2.0 * HARMONICS.value * TONES[priority].fundamental_hz.value
    if not sample_rate_hz > least_hz:
        raise InputError(
            f"the sample rate is {sample_rate_hz:g} Hz; the {priority.name.lower()} alarm needs "
            f"more than {least_hz:g} Hz"
        )
    count = math.ceil(burst_s(priority) * sample_rate_hz)
    time_s = np.arange(count) / sample_rate_hz
    samples: Samples = envelope(priority, time_s) * _tone(priority, time_s)
    return samples


def repeat(priority: Priority, seconds: float, sample_rate_hz: float) -> Samples:
    """Bursts with their interval for a time, as long as the alarm is not silenced.

    The interval runs from the end of the last pulse to the beginning of the next burst's first.
    """
    one = burst(priority, sample_rate_hz)
    period_s = pulses(priority)[-1].end_s + TONES[priority].interval_s.value
    samples = np.zeros(round(seconds * sample_rate_hz))
    for index in range(math.ceil(seconds / period_s)):
        begin = round(index * period_s * sample_rate_hz)
        part = one[: samples.size - begin]
        samples[begin : begin + part.size] = part
    return samples
