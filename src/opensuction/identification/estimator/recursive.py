"""Recursive least squares with forgetting: parameters that follow a plant which drifts.

For a known decay the modified Dahl model is linear in slope, velocity gain and offset, with the
regressors head, unit lag and 1. Each sample corrects the three; old samples are forgotten by the
travel of the head, not by time, so that a plant at rest is not forgotten and does not blow up the
covariance. The lag itself is a regressor: it is advanced in closed form with a gain of one.
Source: [Ljung-1999] sec. 11.2; [Bierman-1977] for symmetric updates; [Astrom-1995] sec. 11.5 for
the bound on the trace.
"""

import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Gt

from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array


class RecursiveSettings(NamedTuple):
    """Assumptions of the estimator."""

    decay_per_mm: Annotated[float, Gt(0)]
    """alpha_0, from an identification; it is kept."""
    memory_mm: Annotated[float, Gt(0)]
    """Head travel over which a sample's weight falls to 1/e."""
    noise_mm: Annotated[float, Gt(0)]
    """Standard deviation of the tip's measurement."""
    most_spread: Annotated[float, Gt(0)]
    """Upper bound on the standard deviation of slope and gain: bounds the covariance where the
    motion does not excite them."""
    least_move_mm: Annotated[float, Ge(0)]
    """Moves up to this length are accumulated before they are used: noise of the encoder."""


class RecursiveState(NamedTuple):
    """Estimates and their covariance."""

    slope: float
    velocity_gain: float
    offset_mm: float
    covariance: Array
    """Of slope, gain and offset, shape (3, 3)."""
    head_mm: float
    """Head at the last sample used."""
    unit_lag_mm: float
    """Lag there for a velocity gain of one."""
    error_mm: float
    """Tip less prediction at the last sample used, before the correction."""


def start(
    model: ModifiedDahl, lag_mm: float, head_mm: float, spread: tuple[float, float, float]
) -> RecursiveState:
    """State at a known model.

    lag_mm: lag at ``head_mm``. spread: standard deviations of slope, gain and offset (mm).
    """
    return RecursiveState(
        slope=model.slope,
        velocity_gain=model.velocity_gain,
        offset_mm=model.offset_mm,
        covariance=np.diag(np.square(np.array(spread, dtype=np.float64))),
        head_mm=head_mm,
        unit_lag_mm=lag_mm / model.velocity_gain if model.velocity_gain > 0.0 else 0.0,
        error_mm=0.0,
    )


@compiled
def model_of(settings: RecursiveSettings, state: RecursiveState) -> ModifiedDahl:
    """The model as now estimated."""
    return ModifiedDahl(
        slope=state.slope,
        velocity_gain=state.velocity_gain,
        decay_per_mm=settings.decay_per_mm,
        offset_mm=state.offset_mm,
    )


@compiled
def _correct(settings: RecursiveSettings, covariance: Array, column: Array) -> Array:
    """Gain of one measurement; ``covariance`` is overwritten with the one after it."""
    noise = settings.noise_mm * settings.noise_mm
    seen = np.zeros(3)
    for i in range(3):
        for j in range(3):
            seen[i] += covariance[i, j] * column[j]
    total = noise
    for i in range(3):
        total += column[i] * seen[i]
    gain = seen / total
    for i in range(3):
        for j in range(3):
            covariance[i, j] += gain[i] * gain[j] * total - gain[i] * seen[j] - gain[j] * seen[i]
    return gain


@compiled
def step(
    settings: RecursiveSettings, state: RecursiveState, head_mm: float, tip_mm: float
) -> RecursiveState:
    """Take in one sample of head and measured tip.

    A sample that is not finite, or whose head has not moved far enough, changes nothing.
    Returns the next state; the old one is kept.
    """
    move_mm = head_mm - state.head_mm
    if not (math.isfinite(tip_mm) and abs(move_mm) > settings.least_move_mm):
        return state
    if not math.isfinite(move_mm):
        return state
    unit = ModifiedDahl(
        slope=0.0, velocity_gain=1.0, decay_per_mm=settings.decay_per_mm, offset_mm=0.0
    )
    unit_lag_mm = modified_dahl.step(unit, state.unit_lag_mm, move_mm)
    covariance = state.covariance.copy()
    grown = math.exp(abs(move_mm) / settings.memory_mm)
    largest = settings.most_spread * settings.most_spread
    if max(covariance[0, 0], covariance[1, 1]) * grown < largest:
        for i in range(3):
            for j in range(3):
                covariance[i, j] *= grown
    column = np.array([head_mm, unit_lag_mm, 1.0])
    predicted = state.slope * head_mm + state.velocity_gain * unit_lag_mm + state.offset_mm
    error_mm = tip_mm - predicted
    gain = _correct(settings, covariance, column)
    return RecursiveState(
        slope=state.slope + gain[0] * error_mm,
        velocity_gain=state.velocity_gain + gain[1] * error_mm,
        offset_mm=state.offset_mm + gain[2] * error_mm,
        covariance=covariance,
        head_mm=head_mm,
        unit_lag_mm=unit_lag_mm,
        error_mm=error_mm,
    )


@compiled
def track(
    settings: RecursiveSettings,
    state: RecursiveState,
    head_mm: Array,
    tip_mm: Array,
) -> tuple[RecursiveState, Array]:
    """Take in a whole record; the state after it and the estimates after every sample.

    head_mm, tip_mm: shape (n,). Estimates: slope, velocity gain, offset_mm, error_mm; (n, 4).
    """
    estimates = np.empty((head_mm.size, 4))
    for k in range(head_mm.size):
        state = step(settings, state, head_mm[k], tip_mm[k])
        estimates[k, 0] = state.slope
        estimates[k, 1] = state.velocity_gain
        estimates[k, 2] = state.offset_mm
        estimates[k, 3] = state.error_mm
    return state, estimates
