import numpy as np
import pytest

from opensuction.hysteresis.modified_dahl import PUBLISHED, simulate
from opensuction.identification.record import find_turns, thin
from tests.identification.plant import RIPPLED


def test_thinning_keeps_the_lag_of_every_sample_that_stays() -> None:
    index = np.arange(RIPPLED.size, dtype=np.float64)
    head_mm, kept = thin(RIPPLED, index, samples=300)
    assert 300 <= kept.size < 1200
    full_mm = simulate(PUBLISHED, RIPPLED, 2.0)
    assert simulate(PUBLISHED, head_mm, 2.0) == pytest.approx(full_mm[kept.astype(int)], abs=1e-11)
    assert np.ptp(head_mm) == np.ptp(RIPPLED)


def test_thinning_a_short_recording_changes_nothing() -> None:
    head_mm, tip_mm = thin(RIPPLED[:50], RIPPLED[50:100], samples=300)
    assert np.array_equal(head_mm, RIPPLED[:50])
    assert np.array_equal(tip_mm, RIPPLED[50:100])


def test_turns_are_found_but_for_the_small_ones() -> None:
    head_mm = np.array([0.0, 0.0, 5.0, 9.0, 8.9, 9.5, 3.0, 3.0, 4.0])
    assert find_turns(head_mm, 0.0).tolist() == [3, 4, 5, 7]
    assert find_turns(head_mm, 0.5).tolist() == [5, 7]
    assert find_turns(np.zeros(5), 0.0).size == 0


def test_a_trembling_head_is_thinned_all_the_same() -> None:
    random = np.random.default_rng(5)
    head_mm, _ = thin(RIPPLED + random.normal(0.0, 0.02, RIPPLED.size), RIPPLED, samples=300)
    assert head_mm.size < 4 * 300 + 2
