"""Time of every hysteresis model for a recording of 30,000 samples, and of its inverse."""

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Tell
from benchmarks.timing import best_s
from opensuction.hysteresis.catalogue import hysteresis_model
from tests.conformance.hysteresis_cases import CASES

SAMPLES = 30_000

every_case = pytest.mark.parametrize("name", CASES)


@every_case
def test_record(benchmark: BenchmarkFixture, tell: Tell, name: str) -> None:
    case = CASES[name]
    input_mm = 50.0 * (1.0 - np.cos(np.linspace(0.0, 6.0 * np.pi, SAMPLES)))
    memory = case.model.memory(case.record, 0.0, -1.0)
    shortest_s = best_s(
        benchmark, lambda: case.model.simulate(case.record, input_mm, memory), rounds=10
    )
    tell(f"{name}: {shortest_s / SAMPLES * 1e9:.0f} ns a sample, {shortest_s * 1e3:.2f} ms in all")


@every_case
def test_inverse(benchmark: BenchmarkFixture, name: str) -> None:
    """The call from Python included."""
    case = CASES[name]
    state = hysteresis_model.start(case.model, case.record, 50.0, -1.0)
    benchmark(case.model.inverse_step, case.record, state, 1.5)
