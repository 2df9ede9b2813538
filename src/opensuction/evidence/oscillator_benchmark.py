"""The Bouc-Wen benchmark of nonlinear system identification, generated from its equations.

A mass of 2 kg on a spring, a damper and a Bouc-Wen force; force in N in, displacement in m out,
750 samples a second. As the benchmark says it is integrated by Newmark's rules (constant average
acceleration) at 15 kHz, low-pass filtered and decimated; its own integrator is a protected file,
so this one is written anew, and its signals have other phases. It shares no step of the model's
(`hysteresis.oscillator.motion` is a Runge-Kutta method).

Estimation: a random-phase multisine, 5 to 150 Hz, 50 N rms, 5 periods of 8192 samples from rest,
with Gaussian noise of 8e-3 mm rms between 0 and 375 Hz (white, at this rate) on the displacement.
Test, without noise: another such multisine in steady state, and a sine sweep of 40 N from 20 to
50 Hz at 10 Hz a minute from rest.
Source: [BW-2016], secondary; its example of a signal for the lines of the multisine.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.oscillator.motion import (
    HystereticOscillator,
    acceleration,
    hysteretic_rate,
)
from opensuction.hysteresis.oscillator.output_error import OscillatorFit
from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream
from opensuction.kernel.record import Array

BENCHMARK = HystereticOscillator(
    mass_kg=2.0,
    damping_n_s_per_m=10.0,
    stiffness_n_per_m=5e4,
    hysteretic_stiffness_n_per_m=5e4,
    dissipation=1e3 * 0.8,
    bend=1e3 * -1.1,
    exponent=1.0,
)
"""The benchmark's oscillator: beta 1e3, gamma .8, delta -1.1, nu 1."""

RATE_HZ = 750.0
FINE_STAGES = (2, 2, 5)
"""Decimation of 15 kHz to 750 Hz, in this order."""
PERIOD = 8192
"""Samples in a period of the multisine."""
PERIODS = 5
LOWEST_HZ, HIGHEST_HZ = 5.0, 150.0
MULTISINE_N_RMS = 50.0
SWEEP_N = 40.0
SWEEP_HZ = (20.0, 50.0)
SWEEP_HZ_PER_S = 10.0 / 60.0
NOISE_M_RMS = 8e-6
FILTER_ORDER = 30
"""Of the decimation filter, as MATLAB's decimate(..., 'fir') has it."""


MOST_CORRECTIONS = 20
"""Bound on Newton's steps in an integration step; 3 are usual."""
SETTLED = 1e-11
"""Change of acceleration (m/s²) and force (N) at which they end."""

PHASE_PURPOSE, NOISE_PURPOSE = 90, 91
"""Streams of random numbers of one seed."""

SETTLING_PERIODS = 4
"""Periods of the test's multisine that a model repeats before the one that is judged."""


class BenchmarkRecord(NamedTuple):
    """Force and displacement of the benchmark, 750 samples a second."""

    force_n: Array
    displacement_m: Array


class HeldOutErrors(NamedTuple):
    """Root mean square of predicted less true displacement, without noise, m."""

    multisine_m_rms: float
    sweep_m_rms: float


def estimation_record(seed: int, noise_m_rms: float = NOISE_M_RMS) -> BenchmarkRecord:
    """The five periods from rest that a model is identified from; noise on the displacement."""
    record = _multisine_record(seed, PERIODS)
    noise = _normal(random_stream.stream(seed, NOISE_PURPOSE), record.force_n.size)
    return record._replace(displacement_m=record.displacement_m + noise_m_rms * noise)


def multisine_test(seed: int) -> BenchmarkRecord:
    """One period in steady state, without noise."""
    record = _multisine_record(seed, PERIODS)
    return BenchmarkRecord(record.force_n[-PERIOD:], record.displacement_m[-PERIOD:])


def sweep_test() -> BenchmarkRecord:
    """The sine sweep from rest, without noise."""
    low, high = SWEEP_HZ
    fine_hz = RATE_HZ * math.prod(FINE_STAGES)
    time_s = np.arange(round((high - low) / SWEEP_HZ_PER_S * fine_hz)) / fine_hz
    phase = 2.0 * math.pi * (low * time_s + 0.5 * SWEEP_HZ_PER_S * time_s * time_s)
    return _sample(SWEEP_N * np.sin(phase))


def joined_record(seed: int, test_seed: int) -> BenchmarkRecord:
    """The five periods from rest and, as one motion with them, five of the test's multisine.

    Noise is on the displacement of the first five periods alone; of the others the last is steady.
    """
    refinement = math.prod(FINE_STAGES)
    first, second = multisine(seed, refinement), multisine(test_seed, refinement)
    record = _sample(np.concatenate([np.tile(first, PERIODS), np.tile(second, PERIODS + 1)]))
    kept, noisy = 2 * PERIODS * PERIOD, PERIODS * PERIOD
    displacement_m = record.displacement_m[:kept].copy()
    noise = _normal(random_stream.stream(seed, NOISE_PURPOSE), noisy)
    displacement_m[:noisy] += NOISE_M_RMS * noise
    return BenchmarkRecord(record.force_n[:kept].copy(), displacement_m)


def predict_multisine(fit: OscillatorFit, force_n: Array) -> Array:
    """The steady state of a model under a period of force, m."""
    return fit.predict(np.tile(force_n, SETTLING_PERIODS + 1))[-force_n.size :]


def held_out_errors(fit: OscillatorFit, seed: int) -> HeldOutErrors:
    """The errors of a model on both test records, free run; seed: of the test's multisine."""
    steady, sweep = multisine_test(seed), sweep_test()
    return HeldOutErrors(
        _rms(predict_multisine(fit, steady.force_n) - steady.displacement_m),
        _rms(fit.predict(sweep.force_n) - sweep.displacement_m),
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values * values)))


def multisine(seed: int, refinement: int) -> Array:
    """One period of the force with random phases, N, `refinement` times the delivered rate."""
    size = PERIOD * refinement
    resolution_hz = RATE_HZ / PERIOD
    lines = np.arange(
        math.floor(LOWEST_HZ / resolution_hz), math.ceil(HIGHEST_HZ / resolution_hz) + 1
    )
    phases = _phases(random_stream.stream(seed, PHASE_PURPOSE), lines.size)
    spectrum = np.zeros(size // 2 + 1, dtype=np.complex128)
    spectrum[lines] = np.exp(1j * phases)
    force = np.fft.irfft(spectrum, size)
    return np.asarray(MULTISINE_N_RMS * force / np.std(force))


def _multisine_record(seed: int, periods: int) -> BenchmarkRecord:
    """Periods of a multisine from rest; one more is simulated, where the filter ends."""
    fine = multisine(seed, math.prod(FINE_STAGES))
    record = _sample(np.tile(fine, periods + 1))
    kept = periods * PERIOD
    return BenchmarkRecord(record.force_n[:kept], record.displacement_m[:kept])


def _sample(fine_n: Array) -> BenchmarkRecord:
    """The response to a force of 15 kHz, both at 750 Hz."""
    refinement = math.prod(FINE_STAGES)
    displacement_m = newmark(BENCHMARK, fine_n, 1.0 / (RATE_HZ * refinement))
    return BenchmarkRecord(fine_n[::refinement].copy(), decimate(displacement_m))


def decimate(values: Array) -> Array:
    """Low-pass filtered without phase and decimated, stage by stage."""
    from scipy import signal

    for stage in FINE_STAGES:
        values = signal.decimate(values, stage, FILTER_ORDER, ftype="fir", zero_phase=True)
    return np.ascontiguousarray(values)


@compiled
def _phases(source: RandomStream, count: int) -> Array:
    """Uniform numbers from 0 to 2 pi, shape (count,)."""
    phases = np.empty(count)
    for k in range(count):
        share, _, source = random_stream.uniform_pair(source)
        phases[k] = random_stream.TWO_PI * share
    return phases


@compiled
def _normal(source: RandomStream, count: int) -> Array:
    """Standard normal numbers, shape (count,)."""
    numbers = np.empty(count)
    for k in range(count):
        numbers[k], _, source = random_stream.normal_pair(source)
    return numbers


@compiled
def newmark(model: HystereticOscillator, force_n: Array, step_s: float) -> Array:
    """Displacement from rest under a force, one sample a step, m, shape (n,).

    Method: Newmark's rules with beta 1/4 and gamma 1/2 for the motion, the trapezoidal rule for
    the hysteretic force, Newton's method for both at once; of second order.
    """
    displacement_m = np.zeros(force_n.size)
    y, v, z = 0.0, 0.0, 0.0
    a = acceleration(model, force_n[0], y, v, z)
    rate = 0.0
    half_s, quarter = 0.5 * step_s, 0.25 * step_s * step_s
    inertia = model.mass_kg + half_s * model.damping_n_s_per_m + quarter * model.stiffness_n_per_m
    for k in range(1, force_n.size):
        new_a, new_z = a, z + step_s * rate
        new_y, new_v, new_rate = y, v, rate
        for _ in range(MOST_CORRECTIONS):
            new_v = v + half_s * (a + new_a)
            new_y = y + step_s * v + quarter * (a + new_a)
            new_rate = hysteretic_rate(model, new_v, new_z)
            short_n = model.mass_kg * (acceleration(model, force_n[k], new_y, new_v, new_z) - new_a)
            short_z = z + half_s * (rate + new_rate) - new_z
            # Slopes of z' with the velocity and with z, for an exponent of 1.
            by_v = (
                model.hysteretic_stiffness_n_per_m
                - model.dissipation * math.copysign(1.0, new_v) * new_z
                - model.bend * abs(new_z)
            )
            by_z = -model.dissipation * abs(new_v) - model.bend * new_v * math.copysign(1.0, new_z)
            low, right = -half_s * half_s * by_v, 1.0 - half_s * by_z
            determinant = inertia * right - low
            change_a = (short_n * right - short_z) / determinant
            change_z = (inertia * short_z - low * short_n) / determinant
            new_a += change_a
            new_z += change_z
            if abs(change_z) < SETTLED and abs(change_a) < SETTLED:
                break
        v += half_s * (a + new_a)
        y = y + step_s * (v - half_s * (a + new_a)) + quarter * (a + new_a)
        a, z = new_a, new_z
        rate = hysteretic_rate(model, v, z)
        displacement_m[k] = y
    return displacement_m
