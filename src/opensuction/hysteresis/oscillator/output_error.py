"""Identification of the oscillator from force and displacement, by the error of its free run.

First a mass, a damper and a spring are fitted to the spectra of the record, which is linear in
them. Then parts of that spring are given to hysteretic forces that bend in different ways; the
few that follow the record's beginning best are refined on it, and the best of these on the whole
record, until the squared error of the simulated displacement (from the first sample on, never
corrected by the measured one) falls no more. Noise that is white on the displacement makes that
the estimate of maximum likelihood.

What it does not find: a hysteretic force that slides nearly all the time with hardly a spring
beside it (one of a tenth of its stiffness is found, of a sixtieth not), where no linear oscillator
is near. It is refused, or the residual is as large as the displacement.
Source: [Ljung-1999] for output-error methods; [Sanathanan-1963] for the weights of the spectra.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from opensuction.hysteresis.oscillator import motion
from opensuction.hysteresis.oscillator.motion import (
    AT_REST,
    HystereticOscillator,
    OscillatorState,
    to_row,
)
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

LEAST_SAMPLES = 200
"""Fewer do not tell ten parameters."""

FIRST_PART = 3000
"""Samples of the beginning that the starting points are compared on."""

SPRINGS = ((0.7, 0.3), (0.4, 0.6))
"""Spring and hysteretic stiffness at first, over the linear spring."""

BENDS = ((0.2, 0.0), (0.8, 0.0), (0.5, 0.5), (0.5, -0.5))
"""Dissipation and bend at first, times the scale of the force, over the linear spring."""

REFINED = 3
"""Starting points that are refined on the beginning."""

LOWEST = (0.02, 0.0, 0.0, 0.0, 0.0, -50.0, 0.5)
HIGHEST = (50.0, 50.0, 10.0, 10.0, 50.0, 50.0, 5.0)
"""Bounds: mass, damping and the stiffnesses over those of the linear fit, dissipation and bend as
`BENDS`, exponent."""

SPECTRUM_SAMPLES = 2048
"""Window of the averaged spectra of the linear fit; the record's length at most."""

RUNS_OF_PART, RUNS_OF_WHOLE = 30, 100
"""Iterations of least squares at most, on the beginning and on the record."""

DIFFERENCE = 1e-6
"""Change of a parameter, as a share of it, that its slope is taken by."""

LEAST_POWER, HIGHEST_LINE = 1e-4, 0.4
"""Lines of the linear fit: those with this share of the greatest power of the force, up to this
share of the rate. Without power they say nothing, near half of the rate the sampling bends them."""

LEAST_DAMPING = 1e-3
"""Damping that the fit begins from at least, as a share of the critical."""

RUNAWAY = 1e3
"""Bound on an error of the free run, over the scale of the displacement."""

LEAST_GAIN = 1e-8
"""Of the squared error, as a share of it, that a further step must bring. A change of one standard
error brings 1/n of it, for n samples."""

WEIGHTED_AGAIN = 5
"""Repetitions of the linear fit with weights from the one before."""


class LinearOscillator(NamedTuple):
    """Mass, damper and spring that follow a record best in the frequency domain."""

    mass_kg: float
    damping_n_s_per_m: float
    stiffness_n_per_m: float


class OscillatorFit(NamedTuple):
    """An identified oscillator, and how well the record determines it."""

    model: HystereticOscillator
    standard_error: HystereticOscillator
    """Standard error of each parameter, for white noise; not finite where the record is silent."""
    start: OscillatorState
    """State at the record's first sample."""
    rate_hz: float
    residual_m_rms: float
    """Of the free run over the record."""

    def predict(self, force_n: ArrayLike, start: OscillatorState = AT_REST) -> Array:
        """Displacement under another force at the rate of the record, m; from rest if not said."""
        return self.model.simulate(force_n, self.rate_hz, start)

    def __repr__(self) -> str:
        numbers = ", ".join(
            f"{name}={value:.6g} ± {error:.2g}"
            for name, value, error in zip(
                self.model._fields, self.model, self.standard_error, strict=True
            )
        )
        return f"OscillatorFit({numbers}, residual_m_rms={self.residual_m_rms:.3g})"


class _Problem(NamedTuple):
    """A record, and the scales in which its parameters are about 1."""

    fine_n: Array
    steps: int
    step_s: float
    displacement_m: Array
    linear: LinearOscillator
    force_scale_n: float
    scale_m: float
    at_rest: bool


def fit_oscillator(
    force_n: ArrayLike, displacement_m: ArrayLike, rate_hz: float, at_rest: bool = True
) -> OscillatorFit:
    """Identify a `motion.HystereticOscillator` from one record.

    force_n, displacement_m: shape (n,), at least 200 samples, rate_hz of them a second; the
    displacement counts from where the mass rests without force. at_rest: the record begins at
    rest and without memory; else its first state is estimated, too. Deterministic; some ten
    seconds for 40,000 samples.
    Raises InputError for what is no record, a sampling too slow for the oscillation, and a
    displacement that follows the force like no mass on a spring.
    """
    force = to_row("force_n", force_n)
    measured = to_row("displacement_m", displacement_m)
    if force.size != measured.size:
        raise InputError(
            f"displacement_m: {measured.size} samples, force_n has {force.size}; should be as many"
        )
    if force.size < LEAST_SAMPLES:
        raise InputError(f"force_n: {force.size} samples, should be {LEAST_SAMPLES} or more")
    linear = fit_linear(force, measured, rate_hz)
    whole = _pose(force, measured, rate_hz, linear, at_rest)
    part = slice(0, FIRST_PART)
    beginning = _pose(force[part], measured[part], rate_hz, linear, at_rest)
    tried = sorted(_starting_points(beginning), key=lambda point: _cost(beginning, point))
    refined = [_refine(beginning, point, RUNS_OF_PART) for point in tried[:REFINED]]
    best = min(refined, key=lambda found: float(found.cost))
    return _conclude(whole, _refine(whole, best.x, RUNS_OF_WHOLE), rate_hz)


def fit_linear(force_n: Array, displacement_m: Array, rate_hz: float) -> LinearOscillator:
    """Fit mass, damper and spring to the averaged cross-spectrum of force and displacement.

    ``(k - m w² + i w c) S_yu = S_uu`` in every line, weighted by the force's power and the inverse
    of what the fit before would leave of it. Raises InputError where no positive mass and
    stiffness come of it.
    """
    from scipy import signal

    window = min(SPECTRUM_SAMPLES, force_n.size)
    lines_hz, power = signal.csd(force_n, force_n, rate_hz, nperseg=window)
    _, cross = signal.csd(force_n, displacement_m, rate_hz, nperseg=window)
    told = (np.real(power) > LEAST_POWER * np.real(power).max()) & (
        lines_hz < HIGHEST_LINE * rate_hz
    )
    omega = 2.0 * np.pi * lines_hz[told]
    gain = cross[told] / np.real(power[told])
    columns = np.stack([-(omega**2) * gain, 1j * omega * gain, gain], axis=1)
    weight = np.sqrt(np.real(power[told]))
    found = np.zeros(3)
    for _ in range(WEIGHTED_AGAIN):
        rows = columns * weight[:, None]
        scale = np.linalg.norm(rows, axis=0)
        if not (scale > 0.0).all():
            break
        real = np.concatenate([np.real(rows / scale), np.imag(rows / scale)])
        target = np.concatenate([weight, np.zeros(weight.size)])
        found = np.linalg.lstsq(real, target, rcond=None)[0] / scale
        dynamic = found[2] - found[0] * omega**2 + 1j * omega * found[1]
        weight = np.sqrt(np.real(power[told])) / np.abs(dynamic)
    mass, damping, stiffness = (float(value) for value in found)
    if not (mass > 0.0 and stiffness > 0.0):
        raise InputError(
            "the displacement does not follow the force as a mass on a spring does; are both in "
            "step, is the sign of the force right, and does it excite the resonance?"
        )
    critical = 2.0 * float(np.sqrt(mass * stiffness))
    return LinearOscillator(mass, min(max(damping, LEAST_DAMPING * critical), critical), stiffness)


def _pose(
    force: Array, measured: Array, rate_hz: float, linear: LinearOscillator, at_rest: bool
) -> _Problem:
    """The record as the fit takes it."""
    spring = HystereticOscillator(*linear, 0.0, 0.0, 0.0, 1.0)
    steps = motion.steps_per_sample(spring, rate_hz)
    return _Problem(
        fine_n=motion.refine(force, steps),
        steps=steps,
        step_s=1.0 / (rate_hz * steps),
        displacement_m=measured,
        linear=linear,
        force_scale_n=float(np.std(measured)) * linear.stiffness_n_per_m,
        scale_m=float(np.std(measured)),
        at_rest=at_rest,
    )


def _starting_points(problem: _Problem) -> list[Array]:
    """Parameters to begin from, each about 1."""
    state = [] if problem.at_rest else [float(problem.displacement_m[0]) / problem.scale_m, 0, 0]
    return [
        np.array([1.0, 0.3, *springs, dissipation, bend, 1.0, *state])
        for springs in SPRINGS
        for dissipation, bend in BENDS
    ]


def _scales(problem: _Problem, exponent: float) -> Array:
    """Factors from the numbers of a point to parameters in SI units and the first state."""
    linear = problem.linear
    bend = linear.stiffness_n_per_m / problem.force_scale_n**exponent
    speed = problem.scale_m * np.sqrt(linear.stiffness_n_per_m / linear.mass_kg)
    scales = [*linear, linear.stiffness_n_per_m, bend, bend, 1.0]
    state = [] if problem.at_rest else [problem.scale_m, speed, problem.force_scale_n]
    return np.array(scales + state)


def _read(problem: _Problem, point: Array) -> tuple[HystereticOscillator, OscillatorState]:
    """Parameters and first state of a point."""
    values = [float(value) for value in point * _scales(problem, float(point[6]))]
    start = AT_REST if problem.at_rest else OscillatorState(*values[7:])
    return HystereticOscillator(*values[:7]), start


def _errors(point: Array, problem: _Problem) -> Array:
    """Free run less measured displacement, over its scale; bounded where the run is not."""
    model, start = _read(problem, point)
    run_m = motion.integrate(model, problem.fine_n, problem.steps, problem.step_s, start)
    errors = (run_m - problem.displacement_m) / problem.scale_m
    return np.clip(np.nan_to_num(errors, nan=RUNAWAY), -RUNAWAY, RUNAWAY)


def _cost(problem: _Problem, point: Array) -> float:
    """Sum of squared errors."""
    errors = _errors(point, problem)
    return float(errors @ errors)


def _refine(problem: _Problem, point: Array, most_runs: int) -> Any:
    """Least squares from a starting point."""
    from scipy.optimize import least_squares

    free = [np.inf] * (point.size - len(LOWEST))
    low, high = np.array([*LOWEST, *[-f for f in free]]), np.array([*HIGHEST, *free])
    return least_squares(
        _errors,
        np.clip(point, low + 1e-9, high - 1e-9),
        bounds=(low, high),
        x_scale="jac",
        diff_step=DIFFERENCE,
        ftol=LEAST_GAIN,
        xtol=LEAST_GAIN,
        gtol=LEAST_GAIN,
        max_nfev=most_runs,
        args=(problem,),
    )


def _conclude(problem: _Problem, found: Any, rate_hz: float) -> OscillatorFit:
    """Parameters with their standard errors."""
    model, start = _read(problem, found.x)
    samples = problem.displacement_m.size
    variance = 2.0 * float(found.cost) / (samples - found.x.size)
    _, singular, rows = np.linalg.svd(found.jac, full_matrices=False)
    to_parameters = np.diag(_scales(problem, float(found.x[6])))
    # The scale of dissipation and bend is a power of the force, with the exponent.
    per_exponent = -np.log(problem.force_scale_n)
    to_parameters[4, 6], to_parameters[5, 6] = (
        model.dissipation * per_exponent,
        model.bend * per_exponent,
    )
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        # A direction that changes nothing has no bound.
        errors = np.sqrt(variance * np.sum((to_parameters @ rows.T / singular) ** 2, axis=1))
    return OscillatorFit(
        model=model,
        standard_error=HystereticOscillator(*(float(value) for value in errors[:7])),
        start=start,
        rate_hz=rate_hz,
        residual_m_rms=float(np.sqrt(2.0 * found.cost / samples)) * problem.scale_m,
    )
