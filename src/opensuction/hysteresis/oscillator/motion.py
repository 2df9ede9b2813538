"""A driven mass with a Bouc-Wen force, integrated by the Runge-Kutta method of fourth order.

``m y'' + c y' + k y + z = u`` and ``z' = A y' - B |y'| |z|^(n-1) z - D y' |z|^n``, with the force
u on the mass, its displacement y and the hysteretic force z that no sensor reads. Unlike the maps
of the catalogue it has a time of its own: the displacement answers a force through the inertia.

What a recording cannot tell. The literature writes B = beta gamma and D = beta delta: from force
and displacement only these products follow, so they are the parameters here. Mass and scale of
the force are not separately identifiable either: with a force that is known but for a factor, as
the volts of a shaker, all of m, c, k, A and z are known but for the same factor.

The force between two samples is a spline through them, so that it has no corners where the
recorded signal had none. |y'| and |z| have corners; the step they fall in is of second order.
Source: [Wen-1976]; [BW-2016] for the form with n = nu.
"""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from annotated_types import Ge, Gt
from numpy.typing import ArrayLike

from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

STEPS_PER_PERIOD = 120
"""Integration steps in a period of the free oscillation about rest, at least."""

MOST_STEPS_PER_SAMPLE = 1000
"""Beyond it the recording is too slow for the oscillation that its parameters say."""

SPLINE_DEGREE = 5
"""Of the force between samples. A sine of a fifth of the rate is off by 5e-4 (a cubic: 9e-3)."""


class OscillatorState(NamedTuple):
    """State of the oscillator at one instant; all 0 at rest without memory."""

    displacement_m: float = 0.0
    """y."""
    velocity_m_per_s: float = 0.0
    """y'."""
    hysteretic_n: float = 0.0
    """z."""


AT_REST = OscillatorState()


class HystereticOscillator(NamedTuple):
    """Parameters of the oscillator, force in N to displacement in m.

    With a force in another unit read that unit for N, and for kg that unit times s²/m.

    >>> linear = HystereticOscillator(2.0, 10.0, 5e4, 0.0, 0.0, 0.0, 1.0)
    >>> displacement_m = linear.simulate([100.0] * 4000, rate_hz=750.0)
    >>> f"{displacement_m[-1]:.6f}"  # 100 N on 50 N/mm
    '0.002000'
    """

    mass_kg: Annotated[float, Gt(0)]
    """m."""
    damping_n_s_per_m: Annotated[float, Ge(0)]
    """c."""
    stiffness_n_per_m: Annotated[float, Ge(0)]
    """k: of the spring without memory."""
    hysteretic_stiffness_n_per_m: Annotated[float, Ge(0)]
    """A (alpha): slope of the hysteretic force where it is 0."""
    dissipation: Annotated[float, Ge(0)]
    """B (beta gamma): bends loading and unloading apart, N^(1-n)/m."""
    bend: float
    """D (beta delta): bends both alike, N^(1-n)/m; below -B the force hardens."""
    exponent: Annotated[float, Gt(0)]
    """n (nu): 1 bends at once, large ones late and sharply."""

    def simulate(
        self, force_n: ArrayLike, rate_hz: float, start: OscillatorState = AT_REST
    ) -> Array:
        """Displacement under a force, in m, one for each sample of it, the first that of `start`.

        force_n: shape (n,), at least 6. rate_hz: samples a second. To a periodic force in steady
        state, repeat it and take the last period.
        Raises InputError for a force or parameters that make no motion, a sampling too slow for
        the oscillation, and a motion that grows without bound.
        """
        samples_n = to_row("force_n", force_n)
        self.check()
        steps = steps_per_sample(self, rate_hz)
        displacement_m = integrate(
            self, refine(samples_n, steps), steps, 1.0 / (rate_hz * steps), start
        )
        if not np.isfinite(displacement_m).all():
            first = int(np.argmin(np.isfinite(displacement_m)))
            raise InputError(
                f"the motion has no bound from sample {first} on: with D < -B the hysteretic force "
                "grows with the displacement; take a smaller force, or a larger bend"
            )
        return displacement_m

    def check(self) -> None:
        """Raise InputError for parameters that make no oscillator."""
        for name, value in self._asdict().items():
            is_right = math.isfinite(value)
            if name in ("mass_kg", "exponent"):
                is_right = is_right and value > 0.0
            elif name != "bend":
                is_right = is_right and value >= 0.0
            if not is_right:
                least = "above 0" if name in ("mass_kg", "exponent") else "0 or more"
                wanted = "finite" if name == "bend" else least
                raise InputError(f"{name}: {value:g}, should be {wanted}")


def to_row(name: str, values: ArrayLike) -> Array:
    """One row of finite numbers that a spline goes through; raises InputError."""
    try:
        row: Any = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: should be one row of finite numbers") from None
    if row.ndim == 2 and 1 in row.shape:
        row = row.ravel()
    if row.ndim != 1 or not np.isfinite(row).all():
        raise InputError(f"{name}: should be one row of finite numbers")
    if row.size <= SPLINE_DEGREE:
        raise InputError(f"{name}: {row.size} samples, should be {SPLINE_DEGREE + 1} or more")
    return np.asarray(row)


def steps_per_sample(model: HystereticOscillator, rate_hz: float) -> int:
    """Integration steps between two samples; raises InputError for a rate that is too slow."""
    if not (math.isfinite(rate_hz) and rate_hz > 0.0):
        raise InputError(f"rate_hz: {rate_hz:g}, should be above 0")
    stiffness = model.stiffness_n_per_m + model.hysteretic_stiffness_n_per_m
    frequency_hz = math.sqrt(stiffness / model.mass_kg) / (2.0 * math.pi)
    steps = max(1, math.ceil(STEPS_PER_PERIOD * frequency_hz / rate_hz))
    if steps > MOST_STEPS_PER_SAMPLE:
        raise InputError(
            f"rate_hz: {rate_hz:g}, too slow for an oscillation of {frequency_hz:.3g} Hz; are the "
            "units of mass and stiffness the same?"
        )
    return steps


def refine(force_n: Array, steps: int) -> Array:
    """The force at the ends and middles of all integration steps, shape (2 steps (n - 1) + 1,)."""
    from scipy.interpolate import make_interp_spline

    at = np.arange(force_n.size, dtype=np.float64)
    fine = np.linspace(0.0, force_n.size - 1.0, 2 * steps * (force_n.size - 1) + 1)
    return np.asarray(make_interp_spline(at, force_n, SPLINE_DEGREE)(fine), dtype=np.float64)


@compiled
def hysteretic_rate(model: HystereticOscillator, velocity: float, hysteretic_n: float) -> float:
    """z', N/s, for a velocity in m/s."""
    size = abs(hysteretic_n)
    power = size if model.exponent == 1.0 else math.pow(size, model.exponent)
    bent = model.dissipation * abs(velocity) * math.copysign(power, hysteretic_n)
    return model.hysteretic_stiffness_n_per_m * velocity - bent - model.bend * velocity * power


@compiled
def acceleration(
    model: HystereticOscillator, force_n: float, place: float, velocity: float, hysteretic_n: float
) -> float:
    """y'', m/s²."""
    spring_n = model.stiffness_n_per_m * place + model.damping_n_s_per_m * velocity
    return (force_n - spring_n - hysteretic_n) / model.mass_kg


@compiled
def integrate(
    model: HystereticOscillator, fine_n: Array, steps: int, step_s: float, start: OscillatorState
) -> Array:
    """Displacement at each sample, m, shape (n,).

    fine_n: as `refine` gives it. steps: integration steps in a sample, each of step_s.
    Method: the classical Runge-Kutta of fourth order, with a fixed step.
    """
    samples = (fine_n.size - 1) // (2 * steps) + 1
    displacement_m = np.empty(samples)
    y, v, z = start.displacement_m, start.velocity_m_per_s, start.hysteretic_n
    displacement_m[0] = y
    half_s = 0.5 * step_s
    at = 0
    for k in range(1, samples):
        for _ in range(steps):
            a1 = acceleration(model, fine_n[at], y, v, z)
            r1 = hysteretic_rate(model, v, z)
            v2, z2 = v + half_s * a1, z + half_s * r1
            a2 = acceleration(model, fine_n[at + 1], y + half_s * v, v2, z2)
            r2 = hysteretic_rate(model, v2, z2)
            v3, z3 = v + half_s * a2, z + half_s * r2
            a3 = acceleration(model, fine_n[at + 1], y + half_s * v2, v3, z3)
            r3 = hysteretic_rate(model, v3, z3)
            v4, z4 = v + step_s * a3, z + step_s * r3
            a4 = acceleration(model, fine_n[at + 2], y + step_s * v3, v4, z4)
            r4 = hysteretic_rate(model, v4, z4)
            y += step_s * (v + 2.0 * (v2 + v3) + v4) / 6.0
            v += step_s * (a1 + 2.0 * (a2 + a3) + a4) / 6.0
            z += step_s * (r1 + 2.0 * (r2 + r3) + r4) / 6.0
            at += 2
        displacement_m[k] = y
    return displacement_m
