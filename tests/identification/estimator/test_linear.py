import numpy as np
import pytest

from opensuction.identification import record
from opensuction.identification.estimator import linear
from opensuction.identification.estimator.linear import Design, solve_free, solve_nonnegative

RANDOM = np.random.default_rng(6)
COLUMNS = RANDOM.normal(size=(4, 400)) + np.array([[0.0], [3.0], [0.0], [-2.0]])
TRUTH = np.array([1.0, 0.0, 2.0, 0.5])
TARGET = TRUTH @ COLUMNS + 7.0 + RANDOM.normal(0.0, 0.1, 400)


def test_a_design_without_penalty_is_least_squares() -> None:
    found = linear.fit([Design(COLUMNS, 0.0, 0)], TARGET, solve_free)
    table = np.vstack([COLUMNS, np.ones(400)]).T
    expected = np.linalg.lstsq(table, TARGET, rcond=None)[0]
    assert [*found.factors, found.offset] == pytest.approx(expected, abs=1e-10)


def test_the_error_is_that_of_samples_left_out() -> None:
    about = COLUMNS - COLUMNS.mean(axis=1)[:, None]
    aim = TARGET - TARGET.mean()
    errors = []
    for cut in record.cut_evenly(400).cuts:
        kept = np.ones(400, dtype=bool)
        kept[cut] = False
        factors = np.linalg.lstsq(about[:, kept].T, aim[kept], rcond=None)[0]
        errors.append(aim[cut] - factors @ about[:, cut])
    expected = float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
    found = linear.fit([Design(COLUMNS, 0.0, 0)], TARGET, solve_free)
    assert found.scores.rmse == pytest.approx(expected, rel=1e-9)
    # The same for a fitted model seen as linear about its optimum.
    rest = aim - np.linalg.lstsq(about.T, aim, rcond=None)[0] @ about
    assert linear.estimate_left_out(about, rest).rmse == pytest.approx(expected, rel=1e-9)


def test_useless_columns_are_not_chosen() -> None:
    noise = RANDOM.normal(size=(60, 400))
    designs = [Design(COLUMNS, 0.0, 0), Design(np.vstack([COLUMNS, noise]), 0.0, 0)]
    assert linear.fit(designs, TARGET, solve_free).chosen == 0
    assert linear.fit(designs[1:], TARGET, solve_free).scores.rmse > 0.1


def test_nonnegative_weights_stay_so_and_need_no_scale() -> None:
    scale = np.array([1e-6, 1.0, 1e6, 1.0])
    target = TARGET - 3.0 * COLUMNS[1]  # wants a weight of -3
    found = linear.fit([Design(COLUMNS, 0.0, 0)], target, solve_nonnegative)
    assert found.factors[1] == 0.0
    assert np.all(found.factors >= 0.0)
    scaled = linear.fit([Design(COLUMNS * scale[:, None], 0.0, 0)], target, solve_nonnegative)
    assert scaled.factors * scale == pytest.approx(found.factors, rel=1e-6)


def test_the_spared_columns_are_not_penalised() -> None:
    about = COLUMNS[[0, 2]]
    found = linear.fit([Design(about, 1.0, 1)], TARGET, solve_free)
    # A ridge of the column's own variance halves its factor; the last one is left alone.
    assert found.factors[0] == pytest.approx(0.5, abs=0.1)
    assert found.factors[1] == pytest.approx(2.0, abs=0.1)
