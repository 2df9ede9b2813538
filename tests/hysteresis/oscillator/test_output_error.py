"""Identification of the oscillator from short records whose parameters are known."""

import numpy as np
import pytest

from opensuction.hysteresis import HystereticOscillator, fit_oscillator
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

RATE_HZ = 750.0
TRUE = HystereticOscillator(1.0, 20.0, 3e4, 8e4, 900.0, 300.0, 1.0)


def broadband(samples: int) -> Array:
    """A force of random phases up to 150 Hz, 50 N rms."""
    random = np.random.default_rng(3)
    spectrum = np.zeros(samples // 2 + 1, dtype=np.complex128)
    lines = np.arange(samples // 150, samples // 5)
    spectrum[lines] = np.exp(2j * np.pi * random.uniform(size=lines.size))
    force = np.fft.irfft(spectrum, samples)
    return np.asarray(50.0 * force / np.std(force))


@pytest.mark.parametrize("at_rest", [True, False])
def test_parameters_of_a_short_noisy_record_are_found(at_rest: bool) -> None:
    force = broadband(1600)
    clean = TRUE.simulate(force, RATE_HZ)
    noise = 0.005 * np.std(clean) * np.random.default_rng(4).standard_normal(force.size)
    first = 0 if at_rest else 400  # in mid-motion
    fit = fit_oscillator(force[first:], (clean + noise)[first:], RATE_HZ, at_rest)
    assert fit.residual_m_rms == pytest.approx(np.std(noise), rel=0.05)
    for found, error, true in zip(fit.model, fit.standard_error, TRUE, strict=True):
        assert abs(found - true) < 4.0 * error < 0.2 * abs(true)
    assert repr(fit).startswith("OscillatorFit(mass_kg=")
    assert len(repr(fit)) < 400
    other = broadband(1600)[::-1]
    expected = TRUE.simulate(other, RATE_HZ)
    assert np.std(fit.predict(other) - expected) < 0.002 * np.std(expected)


def test_a_linear_record_says_that_its_hysteresis_is_not_determined() -> None:
    linear = HystereticOscillator(2.0, 30.0, 8e4, 0.0, 0.0, 0.0, 1.0)
    force = broadband(600)
    clean = linear.simulate(force, RATE_HZ)
    noise = 0.01 * np.std(clean) * np.random.default_rng(5).standard_normal(force.size)
    fit = fit_oscillator(force, clean + noise, RATE_HZ)
    assert fit.model.mass_kg == pytest.approx(2.0, rel=0.01)
    stiffness = fit.model.stiffness_n_per_m + fit.model.hysteretic_stiffness_n_per_m
    assert stiffness == pytest.approx(8e4, rel=0.01)
    assert fit.standard_error.hysteretic_stiffness_n_per_m > 0.1 * 8e4


@pytest.mark.parametrize(
    ("force", "displacement", "says"),
    [
        (np.zeros(300), np.zeros(299), "displacement_m: 299 samples, force_n has 300"),
        (np.zeros(100), np.zeros(100), "force_n: 100 samples, should be 200 or more"),
        (broadband(600), -TRUE.simulate(broadband(600), RATE_HZ), "as a mass on a spring does"),
        (np.zeros(300), np.zeros(300), "as a mass on a spring does"),
        (broadband(600), np.zeros(600), "as a mass on a spring does"),
    ],
)
def test_what_is_no_record_of_an_oscillator_is_refused(
    force: Array, displacement: Array, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        fit_oscillator(force, displacement, RATE_HZ)
