"""The sound of an alarm as samples: bursts of pulses with the timing of IEC 60601-1-8.

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
from opensuction.safety.alarm.signal_value import (
    EDGE_SHARE,
    HARMONIC_DB,
    HARMONICS,
    HIGH,
    LOW,
    MEDIUM,
    REMINDER,
    Tone,
)
from opensuction.safety.priority import Priority

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
