"""The oscillator against closed forms and against the Bouc-Wen map of its own displacement."""

import math

import numpy as np
import pytest

from opensuction.hysteresis import HystereticOscillator, bouc_wen
from opensuction.kernel.errors import InputError

BENCHMARK = HystereticOscillator(2.0, 10.0, 5e4, 5e4, 800.0, -1100.0, 1.0)
RATE_HZ = 750.0


def test_without_hysteretic_force_it_is_the_step_response_of_mass_spring_and_damper() -> None:
    mass, damping, stiffness, force_n = 2.0, 30.0, 8e4, 50.0
    model = HystereticOscillator(mass, damping, stiffness, 0.0, 0.0, 0.0, 1.0)
    time_s = np.arange(600) / RATE_HZ
    found = model.simulate(np.full(600, force_n), RATE_HZ)
    decay, free = damping / (2.0 * mass), math.sqrt(stiffness / mass)
    damped = math.sqrt(free * free - decay * decay)
    swing = np.cos(damped * time_s) + decay / damped * np.sin(damped * time_s)
    expected = force_n / stiffness * (1.0 - np.exp(-decay * time_s) * swing)
    # The method's own error: (w h)^4/120 of the phase a radian, w h = 2 pi/120.
    assert np.abs(found - expected).max() < 1e-6 * force_n / stiffness


@pytest.mark.parametrize(
    "model", [BENCHMARK, BENCHMARK._replace(dissipation=90.0, bend=30.0, exponent=1.5)]
)
def test_its_force_is_that_of_the_bouc_wen_map_along_its_displacement(
    model: HystereticOscillator,
) -> None:
    rate_hz = 20_000.0
    time_s = np.arange(8000) / rate_hz
    force_n = 60.0 * np.sin(2.0 * math.pi * 30.0 * time_s) * np.sin(2.0 * math.pi * 4.0 * time_s)
    y = model.simulate(force_n, rate_hz)
    acceleration = (y[2:] - 2.0 * y[1:-1] + y[:-2]) * rate_hz**2
    velocity = (y[2:] - y[:-2]) * 0.5 * rate_hz
    inner = y[1:-1]
    rest_n = (
        force_n[1:-1]
        - model.mass_kg * acceleration
        - model.damping_n_s_per_m * velocity
        - model.stiffness_n_per_m * inner
    )
    memory = bouc_wen.BoucWen(
        input_gain=model.hysteretic_stiffness_n_per_m,
        dissipation=model.dissipation,
        bend=model.bend,
        exponent=model.exponent,
        slope=0.0,
        memory_gain=1.0,
        offset_mm=0.0,
    )
    expected_n = bouc_wen.simulate(memory, y, 0.0)[1:-1]
    # Differences over 50 us stand for the derivatives.
    assert np.abs(rest_n - expected_n).max() < 2e-3 * np.abs(expected_n).max()


@pytest.mark.parametrize("force_n", [1.0, 10.0, 40.0])
def test_the_hysteretic_force_takes_work_in_a_closed_cycle(force_n: float) -> None:
    model = BENCHMARK._replace(damping_n_s_per_m=0.0)  # then all work is the hysteretic force's
    period = 30  # samples, 25 Hz
    force = force_n * np.sin(2.0 * math.pi * np.arange(400 * period) / period)
    cycle = model.simulate(force, RATE_HZ)[-period:]
    velocity = np.fft.irfft(np.fft.rfft(cycle) * 1j * np.arange(16), period)
    work_j = float(np.mean(force[-period:] * velocity)) * 2.0 * math.pi
    assert work_j > 1e-4 * force_n * np.abs(cycle).max()


def test_twice_the_force_on_twice_of_everything_moves_the_same() -> None:
    force = 50.0 * np.sin(np.arange(400.0))
    twice = HystereticOscillator(4.0, 20.0, 1e5, 1e5, 800.0, -1100.0, 1.0)
    np.testing.assert_allclose(
        twice.simulate(2.0 * force, RATE_HZ), BENCHMARK.simulate(force, RATE_HZ), rtol=1e-9
    )


@pytest.mark.parametrize(
    ("model", "force", "rate_hz", "says"),
    [
        (BENCHMARK._replace(mass_kg=0.0), [0.0] * 9, RATE_HZ, "mass_kg: 0, should be above 0"),
        (BENCHMARK._replace(bend=math.nan), [0.0] * 9, RATE_HZ, "bend: nan, should be finite"),
        (BENCHMARK, [0.0] * 5, RATE_HZ, "force_n: 5 samples, should be 6 or more"),
        (BENCHMARK, [0.0, math.nan] * 9, RATE_HZ, "force_n: should be one row of finite numbers"),
        (BENCHMARK, ["a"] * 9, RATE_HZ, "force_n: should be one row of finite numbers"),
        (BENCHMARK, [0.0] * 9, 0.0, "rate_hz: 0, should be above 0"),
        (BENCHMARK, [0.0] * 9, 0.5, "too slow for an oscillation of 35.6 Hz"),
        (BENCHMARK, [1e6] * 99, RATE_HZ, "the motion has no bound from sample"),
    ],
)
def test_what_makes_no_motion_is_refused(
    model: HystereticOscillator, force: list[float], rate_hz: float, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        model.simulate(force, rate_hz)
