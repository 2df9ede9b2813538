"""The machine's sensors: what noise, offset, resolution, bandwidth and age make of the truth.

The encoder of the insertion motor counts its own steps and has none of these but age. What is late
is a message: the controller then has the value of the tick before. Contact switch and light barrier
tell one of two things; what is not ideal in them is in `tip_sensor`.

Sensors from their parameters.
"""

import math
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.arithmetic import drop_tiny
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream

DRIFT_S = 300.0
"""Time over which an offset wanders, as the parts warm up and cool down; assumed."""
ROOT_3 = math.sqrt(3.0)
HALF_WORD = 65536.0


class Analogue(NamedTuple):
    """One sensor, in the unit that it measures."""

    noise: float
    """RMS of what is new in each reading."""
    offset: float
    """What it reads too much, always."""
    drift: float
    """RMS of what that wanders by."""
    gain: float
    """Reading for each unit of what is measured; 1 if it is right."""
    step: float
    """Resolution."""
    lag_s: float
    """Time constant of its bandwidth."""


class Sensors(NamedTuple):
    """The sensors of one machine."""

    carriage: Analogue
    """On the catheter head, mm."""
    cam: Analogue
    """Of the valve's cam, rad."""
    vacuum: Analogue
    """In the canister, mmHg."""
    current: Analogue
    """Of the insertion motor, A."""
    late_share: float
    """Share of messages that come a tick late, of each node of the bus: the insertion drive with
    encoder and current, and the node of the other sensors."""


class SensorState(NamedTuple):
    """Registers of the sensors."""

    head_mm: float
    """Last messages."""
    carriage_mm: float
    cam_rad: float
    vacuum_mmhg: float
    current_a: float
    vacuum_lagging_mmhg: float
    """Behind the bandwidth."""
    current_lagging_a: float
    vacuum_drift: float
    """In multiples of the drift's RMS."""
    current_drift: float
    stream: RandomStream


class Measured(NamedTuple):
    """The truth of what is measured."""

    head_mm: float
    """By the encoder, which counts steps."""
    carriage_mm: float
    cam_rad: float
    vacuum_mmhg: float
    current_a: float


def exact(step: float) -> Analogue:
    """A sensor that errs by nothing but its resolution."""
    return Analogue(noise=0.0, offset=0.0, drift=0.0, gain=1.0, step=step, lag_s=0.0)


@compiled
def quantise(value: float, step: float) -> float:
    """A value in whole steps of a sensor; without a step as it is."""
    return math.floor(value / step + 0.5) * step if step > 0.0 else value


@compiled
def _convert(sensor: Analogue, value: float, drift: float, noise: float) -> float:
    """Reading of a sensor. drift, noise: in multiples of their RMS."""
    errors = sensor.offset + sensor.drift * drift + sensor.noise * noise
    return quantise(sensor.gain * value + errors, sensor.step)


@compiled
def _follow(before: float, value: float, lag_s: float, dt_s: float) -> float:
    return drop_tiny(before + (value - before) * (dt_s / (lag_s + dt_s)))


@compiled
def _wander(drift: float, normal: float, dt_s: float) -> float:
    """A drift a tick on: a random walk that is drawn back to nothing, of variance 1."""
    share = dt_s / DRIFT_S
    return drop_tiny(drift - share * drift + math.sqrt(2.0 * share) * normal)


@compiled
def _even(half_word: int) -> float:
    """An evenly distributed number of mean 0 and variance 1, from 16 random bits."""
    return ROOT_3 * ((2.0 * half_word + 1.0) / HALF_WORD - 1.0)


def begin(sensors: Sensors, measured: Measured, stream: RandomStream) -> SensorState:
    """Registers of a machine that has stood like this for long; the drift is drawn."""
    vacuum_drift, current_drift, later = random_stream.normal_pair(stream)
    return SensorState(
        head_mm=measured.head_mm,
        carriage_mm=_convert(sensors.carriage, measured.carriage_mm, 0.0, 0.0),
        cam_rad=_convert(sensors.cam, measured.cam_rad, 0.0, 0.0),
        vacuum_mmhg=_convert(sensors.vacuum, measured.vacuum_mmhg, vacuum_drift, 0.0),
        current_a=_convert(sensors.current, measured.current_a, current_drift, 0.0),
        vacuum_lagging_mmhg=measured.vacuum_mmhg,
        current_lagging_a=measured.current_a,
        vacuum_drift=vacuum_drift,
        current_drift=current_drift,
        stream=later,
    )


@compiled
def step(sensors: Sensors, state: SensorState, measured: Measured, dt_s: float) -> SensorState:
    """Read everything once."""
    first, second, stream = random_stream.normal_pair(state.stream)
    bits, ages, stream = random_stream.word_pair(stream)
    late = sensors.late_share * HALF_WORD
    drive_late, node_late = (ages & 0xFFFF) < late, (ages >> 16) < late
    vacuum = _follow(state.vacuum_lagging_mmhg, measured.vacuum_mmhg, sensors.vacuum.lag_s, dt_s)
    current = _follow(state.current_lagging_a, measured.current_a, sensors.current.lag_s, dt_s)
    carriage_mm, cam_rad, vacuum_mmhg = state.carriage_mm, state.cam_rad, state.vacuum_mmhg
    if not node_late:
        carriage_mm = _convert(sensors.carriage, measured.carriage_mm, 0.0, _even(bits & 0xFFFF))
        cam_rad = _convert(sensors.cam, measured.cam_rad, 0.0, _even(bits >> 16))
        vacuum_mmhg = _convert(sensors.vacuum, vacuum, state.vacuum_drift, first)
    head_mm, current_a = state.head_mm, state.current_a
    if not drive_late:
        head_mm = measured.head_mm
        current_a = _convert(sensors.current, current, state.current_drift, second)
    return SensorState(
        head_mm=head_mm,
        carriage_mm=carriage_mm,
        cam_rad=cam_rad,
        vacuum_mmhg=vacuum_mmhg,
        current_a=current_a,
        vacuum_lagging_mmhg=vacuum,
        current_lagging_a=current,
        vacuum_drift=_wander(state.vacuum_drift, first, dt_s),
        current_drift=_wander(state.current_drift, second, dt_s),
        stream=stream,
    )


def sensors(values: dict[str, float]) -> Sensors:
    """Sensors from their parameters."""
    return Sensors(
        carriage=exact(values["carriage_sensor_mm"])._replace(
            noise=values["carriage_noise_mm"], offset=values["carriage_zero_mm"]
        ),
        cam=exact(values["cam_encoder_rad"])._replace(
            noise=values["cam_noise_rad"], offset=values["cam_zero_rad"]
        ),
        vacuum=Analogue(
            noise=values["vacuum_noise_mmhg"],
            offset=values["vacuum_offset_mmhg"],
            drift=values["vacuum_drift_mmhg"],
            gain=values["vacuum_gain"],
            step=values["vacuum_step_mmhg"],
            lag_s=values["vacuum_lag_s"],
        ),
        current=Analogue(
            noise=values["current_noise_a"],
            offset=values["current_offset_a"],
            drift=values["current_drift_a"],
            gain=values["current_gain"],
            step=values["current_step_a"],
            lag_s=values["current_lag_s"],
        ),
        late_share=values["late_share"],
    )


def exact_sensors(sensors: Sensors) -> Sensors:
    """The same sensors, but they err by nothing but their resolution."""
    return Sensors(
        carriage=exact(sensors.carriage.step),
        cam=exact(sensors.cam.step),
        vacuum=exact(0.0),
        current=exact(0.0),
        late_share=0.0,
    )
