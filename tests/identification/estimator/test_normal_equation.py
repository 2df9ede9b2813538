import numpy as np
import pytest

from opensuction.identification.estimator.linear import solve_least_squares
from tests.identification.plant import RIPPLED


def test_least_squares_of_nearly_equal_columns_keeps_its_digits() -> None:
    one = RIPPLED - RIPPLED.mean()
    other = np.cos(np.linspace(0.0, 7.0, RIPPLED.size))
    # Alike to 1e-5: normal equations alone see 1e-10 and keep six digits of the factors.
    columns = np.stack([one, one + 1e-5 * np.ptp(one) * (other - other.mean())])
    factors = solve_least_squares(columns, np.array([3.0, -2.0]) @ columns)
    assert factors == pytest.approx([3.0, -2.0], rel=1e-9)


def test_least_squares_leaves_an_empty_column_alone() -> None:
    columns = np.stack([RIPPLED - RIPPLED.mean(), np.zeros(RIPPLED.size)])
    assert solve_least_squares(columns, 2.0 * columns[0]) == pytest.approx([2.0, 0.0])
