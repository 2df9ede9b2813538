import numpy as np
import pytest
from scipy.optimize import nnls

from opensuction.identification.bank import bank_problem
from opensuction.identification.bank.bank_problem import Gram
from opensuction.kernel.errors import InputError


def problem(seed: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Columns that are nearly dependent, as neighbouring cells are, and a target."""
    random = np.random.default_rng(seed)
    columns = np.cumsum(random.normal(size=(3 * size, size)), axis=1)
    return columns, columns @ random.normal(size=size) + random.normal(size=3 * size)


def as_gram(matrix: np.ndarray) -> Gram:
    return Gram(lambda at: matrix[np.ix_(at, at)], lambda at, factors: factors @ matrix[at])


@pytest.mark.parametrize("seed", range(8))
def test_it_finds_the_least_squares_of_weights_at_least_zero(seed: int) -> None:
    columns, target = problem(seed, 40)
    gram, right = columns.T @ columns, columns.T @ target
    bounded = np.ones(40, dtype=bool)
    found = bank_problem.solve_bounded(as_gram(gram), right, bounded)
    assert found.factors == pytest.approx(nnls(columns, target)[0], abs=1e-7)
    again = bank_problem.solve_bounded(as_gram(gram), right, bounded, RANDOM_START)
    assert again.factors == pytest.approx(found.factors, abs=1e-7)


RANDOM_START = np.random.default_rng(9).random(40) > 0.5


def test_factors_that_are_not_bounded_may_have_either_sign() -> None:
    columns, target = problem(3, 12)
    gram, right = columns.T @ columns, columns.T @ target
    free = bank_problem.solve_bounded(as_gram(gram), right, np.zeros(12, dtype=bool))
    assert free.factors == pytest.approx(np.linalg.lstsq(columns, target)[0], abs=1e-7)
    bounded = np.arange(12) < 6
    found = bank_problem.solve_bounded(as_gram(gram), right, bounded).factors
    assert (found[:6] >= 0.0).all()
    assert (found[6:] < 0.0).any()


def test_a_matrix_that_is_not_definite_is_refused_in_one_line() -> None:
    gram = np.diag([1.0, -1.0])
    with pytest.raises(
        InputError, match=r"2 columns \(not definite\); record more varied"
    ) as refusal:
        bank_problem.solve_bounded(as_gram(gram), np.ones(2), np.zeros(2, dtype=bool))
    assert "\n" not in str(refusal.value)
