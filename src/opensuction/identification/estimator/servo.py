"""Velocity and friction feedforward of an axis, from a recording of its motor's voltage.

At steady speed a geared motor takes ``volts = k_v * v + k_f * sign(v)``: the back electromotive
force and the viscous friction in the first term, the dry friction in the second.
Source: [Ellis-2012], feedforward of a velocity loop.
"""

from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Gt
from numpy.typing import ArrayLike

from opensuction.identification.record import read_pair, read_samples
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

LEAST_SAMPLES = 10
"""Fewest usable samples; two parameters from fewer would be taken on trust."""

LEAST_SPEED_RATIO = 1.2
"""Fastest over slowest usable speed; nearer to one, velocity and friction cannot be told apart."""


class ServoFit(NamedTuple):
    """Feedforward of an axis, and how well it explains the recording."""

    velocity_v_s_per_mm: Annotated[float, Gt(0)]
    """k_v: voltage for each mm/s."""
    friction_v: Annotated[float, Ge(0)]
    """k_f: voltage that overcomes dry friction, in the direction of motion."""
    rmse_v: float
    """Root mean square of the voltage left unexplained, over the samples used."""
    samples: int
    """How many samples were fast enough and not saturated."""


def velocity_mm_per_s(position_mm: ArrayLike, period_s: float, window_s: float) -> Array:
    """Velocity of a position record: central difference over a window, without delay.

    position_mm: shape (n,), sampled every ``period_s``. window_s: the whole window, at least two
    periods; wider means less noise and blunter corners. At the ends only the part of the window
    inside the record is used. Returns mm/s, shape (n,).
    Raises InputError for a bad record, or a period or window that does not fit it.
    """
    position = read_samples("position_mm", position_mm, 3)
    if not period_s > 0.0 or not np.isfinite(period_s):
        raise InputError(f"period_s: {period_s} s, should be above 0")
    length_s = (position.size - 1) * period_s
    # Half a millionth of a period forgives a window written in decimals.
    if not 2.0 * period_s * (1.0 - 1e-6) <= window_s <= length_s:
        raise InputError(
            f"window_s: {window_s} s, should be from two sampling periods ({2.0 * period_s:g} s) "
            f"to the length of the record ({length_s:g} s)"
        )
    half = round(0.5 * window_s / period_s)
    index = np.arange(position.size)
    before = np.maximum(index - half, 0)
    after = np.minimum(index + half, position.size - 1)
    velocity: Array = (position[after] - position[before]) / ((after - before) * period_s)
    return velocity


def fit_feedforward(
    volts: ArrayLike, velocity: ArrayLike, slowest_mm_per_s: float, saturation_v: float
) -> ServoFit:
    """Least squares of ``volts = k_v * velocity + k_f * sign(velocity)``.

    volts, velocity: motor voltage in V and axis speed in mm/s at the same instants, shape (n,).
    slowest_mm_per_s: slower samples are left out, friction being unsettled there.
    saturation_v: samples at or above this voltage, either sign, are left out.

    A friction that comes out negative is noise around none: it is fixed at 0.
    Raises InputError for bad records, too few usable samples, speeds too much alike to tell
    velocity from friction, or a voltage that falls with speed.
    """
    volts, velocity = read_pair(("volts", "velocity"), volts, velocity, LEAST_SAMPLES)
    if not (slowest_mm_per_s > 0.0 and saturation_v > 0.0):
        raise InputError(
            f"slowest_mm_per_s {slowest_mm_per_s} and saturation_v {saturation_v}, "
            "both should be above 0"
        )
    used = (np.abs(velocity) >= slowest_mm_per_s) & (np.abs(volts) < saturation_v)
    along_v, speed = (volts * np.sign(velocity))[used], np.abs(velocity)[used]
    if speed.size < LEAST_SAMPLES:
        raise InputError(
            f"volts: {speed.size} of {volts.size} samples are faster than {slowest_mm_per_s:g} "
            f"mm/s and below {saturation_v:g} V, at least {LEAST_SAMPLES} are needed"
        )
    if speed.max() < LEAST_SPEED_RATIO * speed.min():
        raise InputError(
            f"velocity: usable speeds from {speed.min():.4g} to {speed.max():.4g} mm/s are too "
            f"much alike, record speeds at least {LEAST_SPEED_RATIO:g}-fold apart"
        )
    offset = speed - speed.mean()
    slope = float(offset @ along_v / (offset @ offset))
    friction_v = float(along_v.mean() - slope * speed.mean())
    if friction_v < 0.0:
        slope, friction_v = float(speed @ along_v / (speed @ speed)), 0.0
    if slope <= 0.0:
        raise InputError(
            f"volts: fall with speed ({slope:.4g} V s/mm), should rise; "
            "check the sign of voltage and position"
        )
    rest_v = along_v - slope * speed - friction_v
    return ServoFit(slope, friction_v, float(np.sqrt(rest_v @ rest_v / rest_v.size)), speed.size)
