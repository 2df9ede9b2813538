"""The patient monitor at the bedside: what it passes on of saturation, heart rate and pressure.

The saturation comes from the oximeter, late; the heart rate from the electrocardiogram, averaged
over some beats; the pressure from the connector above the tube, a hundred times a second.

Pulse oximeter: shows the arterial saturation late and smoothed.

Blood needs seconds from the lung to the finger, and the instrument averages: what a person reads
during suction is the patient before it. The display shows the mean of a window of the recent past.

Heart rate, as far as suction changes it: the vagus slows it, and so does deep hypoxia.

A catheter in the trachea stimulates the vagus, suction and the carina more. Its tone rises in
seconds and fades more slowly. Deep hypoxia slows the heart besides. The rise of the rate in mild
hypoxia, drugs and arrhythmia are left out: what counts here is how low it can get.
"""

from typing import NamedTuple

import numpy as np

from opensuction.kernel.arithmetic import drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import NO_MONITOR, Monitor
from opensuction.kernel.record import Array

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


def at_rest_heart(heart: Heart) -> HeartState:
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
def step_heart(
    heart: Heart, state: HeartState, stimulated: float, saturation: float, dt_s: float
) -> HeartState:
    """Advance by one step at a given stimulus and arterial saturation (0 to 1); backward Euler."""
    time_constant_s = heart.vagal_s if stimulated > state.tone else heart.recovery_s
    share = dt_s / (time_constant_s + dt_s)
    tone = drop_tiny(state.tone + share * (stimulated - state.tone))
    hypoxia = min(max((heart.hypoxic_ratio - saturation) / HYPOXIC_SPAN, 0.0), 1.0)
    rate = heart.rest_per_min * (1.0 - heart.vagal_ratio * tone) * (1.0 - HYPOXIC_FALL * hypoxia)
    return HeartState(tone=tone, rate_per_min=rate)


SAMPLE_S = 0.5
"""Interval of the display."""
MEMORY = 96
"""Samples remembered: 48 s, more than the longest delay and average together."""


class Oximeter(NamedTuple):
    """Delay and averaging, in samples of the display."""

    delay_samples: int
    """From lung to finger."""
    average_samples: int


class Sample(NamedTuple):
    """Saturation since the latest sample of the display."""

    sum_s: float
    """Integral of the saturation."""
    elapsed_s: float


class OximeterState(NamedTuple):
    """State of the oximeter."""

    history: Array
    """Saturation of past samples as a ring, shape (MEMORY,); never written, only replaced."""
    latest: int
    """Place of the latest sample in the ring."""
    sample: Sample
    shown_percent: float


BEGUN = Sample(sum_s=0.0, elapsed_s=0.0)


def of_delay(delay_s: float, average_s: float) -> Oximeter:
    """Oximeter with a delay and an averaging window, cut to what it can remember."""
    average = min(max(round(average_s / SAMPLE_S), 1), MEMORY // 2)
    delay = min(max(round(delay_s / SAMPLE_S), 0), MEMORY - average)
    return Oximeter(delay_samples=delay, average_samples=average)


def at_rest(saturation: float) -> OximeterState:
    """State after a long time at one saturation (0 to 1)."""
    return OximeterState(
        history=np.full(MEMORY, saturation),
        latest=0,
        sample=BEGUN,
        shown_percent=100.0 * saturation,
    )


@compiled
def integrate(sample: Sample, saturation: float, dt_s: float) -> Sample:
    """Advance by one step at a given arterial saturation (0 to 1)."""
    return Sample(sum_s=sample.sum_s + saturation * dt_s, elapsed_s=sample.elapsed_s + dt_s)


@compiled
def is_due(sample: Sample, dt_s: float) -> bool:
    """True where the display takes a sample after this step."""
    return sample.elapsed_s >= SAMPLE_S - 0.5 * dt_s


@compiled
def show(oximeter: Oximeter, state: OximeterState, sample: Sample) -> OximeterState:
    """Take a sample that is due, and show the mean of those of the window."""
    history = state.history.copy()
    latest = (state.latest + 1) % MEMORY
    history[latest] = sample.sum_s / sample.elapsed_s
    total = 0.0
    for i in range(oximeter.average_samples):
        total += history[(latest - oximeter.delay_samples - i) % MEMORY]
    return OximeterState(
        history=history,
        latest=latest,
        sample=BEGUN,
        shown_percent=100.0 * total / oximeter.average_samples,
    )


@compiled
def step(oximeter: Oximeter, state: OximeterState, saturation: float, dt_s: float) -> OximeterState:
    """Advance by one step at a given arterial saturation (0 to 1)."""
    sample = integrate(state.sample, saturation, dt_s)
    if is_due(sample, dt_s):
        return show(oximeter, state, sample)
    return state._replace(sample=sample)


class PatientMonitor(NamedTuple):
    """One monitor and its cables."""

    present: bool
    """Whether the machine has one: a setting, not a fault."""
    linked: bool
    """Whether its values arrive."""
    probe_on: bool
    """Whether the oximeter's probe is on the finger."""
    beat_average_s: float
    """Time constant over which the heart rate is averaged."""


@compiled
def average(
    monitor: PatientMonitor, shown_per_min: float, rate_per_min: float, dt_s: float
) -> float:
    """Heart rate shown after a step, from the one shown before and the true one."""
    share = dt_s / (monitor.beat_average_s + dt_s)
    return shown_per_min + share * (rate_per_min - shown_per_min)


@compiled
def read(
    monitor: PatientMonitor,
    spo2_percent: float,
    heart_rate_per_min: float,
    airway_pressure_cmh2o: float,
) -> Monitor:
    """Monitor values that arrive at the machine."""
    if not (monitor.present and monitor.linked):
        return NO_MONITOR
    return Monitor(
        connected=True,
        spo2_percent=spo2_percent if monitor.probe_on else 0.0,
        spo2_valid=monitor.probe_on,
        heart_rate_per_min=heart_rate_per_min,
        heart_rate_valid=True,
        airway_pressure_cmh2o=airway_pressure_cmh2o,
        airway_pressure_valid=True,
    )
