"""The Bouc-Wen benchmark: its signals, the accuracy of their integration, the identified model."""

import numpy as np
import pytest

from opensuction.evidence import oscillator_benchmark as benchmark
from opensuction.evidence.oscillator_benchmark import BENCHMARK, PERIOD, RATE_HZ
from opensuction.hysteresis import fit_oscillator
from opensuction.kernel.record import Array


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values * values)))


def test_the_signals_are_those_that_the_benchmark_describes() -> None:
    test = benchmark.multisine_test(1)
    assert test.force_n.size == test.displacement_m.size == PERIOD
    assert rms(test.force_n) == pytest.approx(50.0, rel=1e-9)
    power = np.abs(np.fft.rfft(test.force_n))
    lines_hz = np.fft.rfftfreq(PERIOD, 1.0 / RATE_HZ)
    outside = (lines_hz < 4.9) | (lines_hz > 150.1)
    assert power[outside].max() < 1e-9 * power.max()
    # Steady: the period before differs by less than the model's error is judged to.
    clean = benchmark.estimation_record(1, noise_m_rms=0.0)
    assert rms(clean.displacement_m[-PERIOD:] - clean.displacement_m[-2 * PERIOD : -PERIOD]) < 1e-8
    noisy = benchmark.estimation_record(1)
    assert rms(noisy.displacement_m - clean.displacement_m) == pytest.approx(8e-6, rel=0.02)


def test_half_the_step_changes_a_hundredth_of_the_noise_or_less_and_a_quarter_of_that() -> None:
    def at(refinement: int) -> Array:
        fine_n = benchmark.multisine(1, refinement)
        return benchmark.newmark(BENCHMARK, fine_n, 1.0 / (RATE_HZ * refinement))[::refinement]

    delivered, half, quarter = at(20), at(40), at(80)
    first, second = rms(delivered - half), rms(half - quarter)
    assert first < 2e-7
    assert second < 0.3 * first  # second order


def test_another_method_gives_the_same_displacement() -> None:
    force_n = benchmark.multisine(1, 1)
    fine = benchmark.newmark(BENCHMARK, benchmark.multisine(1, 20), 1.0 / (RATE_HZ * 20))
    runge_kutta = BENCHMARK.simulate(np.tile(force_n, 2), RATE_HZ)[:PERIOD]
    assert rms(runge_kutta - fine[::20]) < 5e-7


def test_a_joined_record_holds_the_periods_to_identify_from_and_the_steady_test() -> None:
    record, test = benchmark.joined_record(1, 1001), benchmark.multisine_test(1001)
    assert record.force_n.size == record.displacement_m.size == 10 * PERIOD
    np.testing.assert_array_equal(record.force_n[-PERIOD:], test.force_n)
    assert rms(record.displacement_m[-PERIOD:] - test.displacement_m) < 1e-9
    noisy = benchmark.estimation_record(1)
    fitted = noisy.force_n.size
    np.testing.assert_array_equal(record.force_n[:fitted], noisy.force_n)
    # Alike but for what the filter sees beyond the last period's end.
    inner = slice(0, fitted - 100)
    np.testing.assert_array_equal(record.displacement_m[inner], noisy.displacement_m[inner])


@pytest.mark.sweep
@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in (2, 3))]
)
def test_the_model_identified_from_noise_predicts_both_tests(seed: int) -> None:
    fit = fit_oscillator(*benchmark.estimation_record(seed), RATE_HZ)
    errors = benchmark.held_out_errors(fit, 1000 + seed)
    assert errors.multisine_m_rms < 5e-7
    assert errors.sweep_m_rms < 5e-7
