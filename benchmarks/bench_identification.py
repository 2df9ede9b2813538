"""Identification of the modified Dahl model: variable projection against searches of everything."""

import time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Tell
from benchmarks.timing import best_s, is_timed
from opensuction.hysteresis.catalogue.duhem_family import MODIFIED_DAHL_FORM as FORM
from opensuction.hysteresis.modified_dahl import PUBLISHED, simulate
from opensuction.identification.estimator import modified_dahl
from opensuction.identification.estimator.linear import squares
from opensuction.identification.estimator.search import SEARCHES, search
from tests.identification.plant import cosine

SAMPLES = 30_000
UNTIMED_SAMPLES = 300
"""Where nothing is timed: the searches take seconds for each thousand."""


@pytest.mark.parametrize("method", SEARCHES)
def test_projection_over_search(benchmark: BenchmarkFixture, tell: Tell, method: str) -> None:
    samples = SAMPLES if is_timed(benchmark) else UNTIMED_SAMPLES
    head_mm = cosine(samples)
    noise_mm = np.random.default_rng(1).normal(0.0, 0.3, samples)
    tip_mm = simulate(PUBLISHED, head_mm, 2.0) + noise_mm
    squares(FORM, np.array([*PUBLISHED, 2.0]), head_mm, tip_mm)  # compiled before it is timed
    begin = time.perf_counter()
    vector = search(method, FORM, head_mm, tip_mm)
    search_s = time.perf_counter() - begin
    found = modified_dahl.fit(head_mm, tip_mm)
    mine = squares(FORM, np.array([*found.model, found.lag_mm]), head_mm, tip_mm)
    excess = mine / squares(FORM, vector, head_mm, tip_mm) - 1.0
    fit_s = best_s(benchmark, lambda: modified_dahl.fit(head_mm, tip_mm), rounds=20)
    benchmark.extra_info.update(times_faster=search_s / fit_s, excess=excess)
    tell(
        f"modified Dahl, {samples:,} samples: {fit_s * 1e3:.1f} ms, {search_s / fit_s:,.0f} times "
        f"faster than {method} and Nelder-Mead; sum of squares {excess:+.1e} of theirs"
    )
