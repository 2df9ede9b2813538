"""Magnetorheological damper whose force a voltage sets: the modified Bouc-Wen model.

A Bouc-Wen element and a dashpot c0 and spring k0 beside it, in series with a dashpot c1, and a
spring k1 beside all of it. The voltage reaches the force through a lag of first order.
Source: [Spencer-1997].
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from opensuction.identification.single_thread import single_threaded
from opensuction.kernel.compiled import compiled
from opensuction.kernel.record import Array

STEPS = 16
"""[computed] Steps of Runge-Kutta from one sample to the next: with twice as many the force of the
fitted model, at 500 Hz and 18 cm/s, changes by less than 1e-5 of its range."""
MOST_EVALUATIONS = 60
"""Of the Jacobian in a fit; it converged after some 40."""
DIVERGED_N = 1e6
"""Force that stands for one that is no number."""


class MrDamper(NamedTuple):
    """Parameters; lengths in cm, forces in N, the voltage in V."""

    damping_n_s_per_cm: float = 21.0
    """c0a."""
    damping_per_v: float = 3.5
    """c0b, N s/cm for each volt."""
    series_damping_n_s_per_cm: float = 283.0
    """c1a."""
    series_damping_per_v: float = 2.95
    """c1b."""
    hysteretic_n_per_cm: float = 140.0
    """alpha_a."""
    hysteretic_per_v: float = 695.0
    """alpha_b."""
    stiffness_n_per_cm: float = 46.9
    """k0."""
    accumulator_n_per_cm: float = 5.0
    """k1."""
    gamma_per_cm2: float = 363.0
    beta_per_cm2: float = 363.0
    lag_per_s: float = 190.0
    """eta, of the voltage."""
    start_cm: float = 0.0
    """Displacement at the first sample, from where the accumulator's spring is relaxed."""
    series_start_cm: float = 0.0
    """Displacement of the dashpot c1 at the first sample, from where k0 is relaxed."""
    hysteretic_start_cm: float = 0.0
    """Hysteretic state at the first sample."""


AMPLITUDE = 301.0
"""A; the scale of the hysteretic state, which the other parameters make up for."""
OFFSETS = 3
"""Parameters, the last ones, that begin at 0."""


class _State(NamedTuple):
    series_cm: float
    hysteretic_cm: float
    voltage_v: float


@compiled
def _rates(
    damper: MrDamper, state: _State, way_cm: float, speed_cm_per_s: float, voltage_v: float
) -> _State:
    """Derivatives of the state by time. way_cm: from the first sample on."""
    damping = damper.damping_n_s_per_cm + damper.damping_per_v * state.voltage_v
    series = damper.series_damping_n_s_per_cm + damper.series_damping_per_v * state.voltage_v
    alpha = damper.hysteretic_n_per_cm + damper.hysteretic_per_v * state.voltage_v
    stretch_cm = way_cm - state.series_cm - damper.series_start_cm
    series_rate = (
        alpha * state.hysteretic_cm
        + damping * speed_cm_per_s
        + damper.stiffness_n_per_cm * stretch_cm
    ) / (damping + series)
    sliding = speed_cm_per_s - series_rate
    z = state.hysteretic_cm
    hysteretic_rate = (
        AMPLITUDE * sliding
        - damper.gamma_per_cm2 * abs(sliding) * z * abs(z)
        - damper.beta_per_cm2 * sliding * z * z
    )
    return _State(series_rate, hysteretic_rate, damper.lag_per_s * (voltage_v - state.voltage_v))


@compiled
def _go(state: _State, rates: _State, step_s: float) -> _State:
    return _State(
        state.series_cm + step_s * rates.series_cm,
        state.hysteretic_cm + step_s * rates.hysteretic_cm,
        state.voltage_v + step_s * rates.voltage_v,
    )


@compiled
def simulate(damper: MrDamper, speed_cm_per_s: Array, voltage_v: Array, period_s: float) -> Array:
    """Force in N at each sample, shape (n,), of speed and voltage, linear between samples.

    The lag begins in equilibrium. Runge-Kutta of order 4.
    """
    state = _State(0.0, damper.hysteretic_start_cm, voltage_v[0])
    force = np.empty(speed_cm_per_s.size)
    step_s = period_s / STEPS
    way_cm = 0.0
    for k in range(speed_cm_per_s.size):
        if k > 0:
            slope = (speed_cm_per_s[k] - speed_cm_per_s[k - 1]) / period_s
            rise = (voltage_v[k] - voltage_v[k - 1]) / period_s
            for step in range(STEPS):
                speed = speed_cm_per_s[k - 1] + slope * step * step_s
                volts = voltage_v[k - 1] + rise * step * step_s
                half_s = 0.5 * step_s
                mid_cm = way_cm + half_s * (speed + 0.5 * slope * half_s)
                end_cm = way_cm + step_s * (speed + 0.5 * slope * step_s)
                mid, mid_v = speed + slope * half_s, volts + rise * half_s
                end, end_v = speed + slope * step_s, volts + rise * step_s
                one = _rates(damper, state, way_cm, speed, volts)
                two = _rates(damper, _go(state, one, half_s), mid_cm, mid, mid_v)
                three = _rates(damper, _go(state, two, half_s), mid_cm, mid, mid_v)
                four = _rates(damper, _go(state, three, step_s), end_cm, end, end_v)
                state = _go(state, one, step_s / 6.0)
                state = _go(state, two, step_s / 3.0)
                state = _go(state, three, step_s / 3.0)
                state = _go(state, four, step_s / 6.0)
                way_cm = end_cm
        rates = _rates(damper, state, way_cm, speed_cm_per_s[k], voltage_v[k])
        series = damper.series_damping_n_s_per_cm + damper.series_damping_per_v * state.voltage_v
        force[k] = series * rates.series_cm + damper.accumulator_n_per_cm * (
            way_cm + damper.start_cm
        )
    return force


@single_threaded
def fit(speed_cm_per_s: Array, voltage_v: Array, force_n: Array, period_s: float) -> MrDamper:
    """Least squares over all parameters at once, from those of [Spencer-1997] on.

    Shapes (n,); the exponent is 2 and A is 301, as there.
    """
    start = np.array(MrDamper())
    scale = np.where(start > 0.0, start, 1.0)
    spread_n = float(force_n.std())

    def rest(shares: Array) -> Array:
        found = simulate(MrDamper(*(scale * shares)), speed_cm_per_s, voltage_v, period_s)
        bounded = np.nan_to_num(found, nan=DIVERGED_N, posinf=DIVERGED_N, neginf=-DIVERGED_N)
        gap: Array = (np.clip(bounded, -DIVERGED_N, DIVERGED_N) - force_n) / spread_n
        return gap

    ones = np.append(np.ones(start.size - OFFSETS), np.zeros(OFFSETS))
    with np.errstate(all="ignore"):
        found = least_squares(rest, ones, max_nfev=MOST_EVALUATIONS)
    return MrDamper(*(float(one) for one in scale * found.x))
