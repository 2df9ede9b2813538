"""Models of hysteresis as a regressor of scikit-learn, by its own checks and its own tools."""

import importlib
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import SkipTest

import numpy as np
import pandas as pd
import pytest
from scipy import sparse
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import GridSearchCV, TimeSeriesSplit, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.estimator_checks import parametrize_with_checks

import opensuction as osn
from opensuction.identification import workbench
from opensuction.identification.workbench import MODELS
from opensuction.sklearn import HysteresisRegressor
from tests.library.recordings import bench, wrist
from tests.library.test_fit import refusal

ROW, Y = bench(400)
X = ROW[:, None]
PAGE = Path(__file__).parents[1] / "docs" / "reference" / "library.md"

BY_ORDER = {
    "check_methods_sample_order_invariance": "what a model predicts depends on the samples before",
    "check_methods_subset_invariance": "what a model predicts depends on the samples before",
}
"""Checks that no model with a memory passes."""

NO_RECORDING = dict.fromkeys(
    (
        "check_array_api_input",
        "check_dict_unchanged",
        "check_dont_overwrite_parameters",
        "check_dtype_object",
        "check_estimators_dtypes",
        "check_estimators_fit_returns_self",
        "check_estimators_nan_inf",
        "check_estimators_overwrite_params",
        "check_estimators_pickle",
        "check_f_contiguous_array_estimator",
        "check_fit2d_predict1d",
        "check_fit_check_is_fitted",
        "check_fit_idempotent",
        "check_fit_score_takes_y",
        "check_n_features_in",
        "check_n_features_in_after_fitting",
        "check_pipeline_consistency",
        "check_positive_only_tag_during_fit",
        "check_readonly_memmap_input",
        "check_regressor_data_not_an_array",
        "check_regressors_int",
        "check_regressors_no_decision_function",
        "check_regressors_train",
        "check_supervised_y_2d",
    ),
    "fits random samples in no order: no motion to and fro, which `fit` refuses",
)
"""Checks that fit what is no recording; below they are made with a play that follows anything."""


@pytest.fixture
def briefly(request: pytest.FixtureRequest) -> Callable[[Callable[[], None]], None]:
    """Makes a check; one that is expected to fail does so in a line.

    Its traceback, which nobody reads, took three times as long as all checks.
    """

    def make(check: Callable[[], None]) -> None:
        try:
            check()
        except SkipTest:
            raise
        except Exception as failure:
            if request.node.get_closest_marker("xfail") is None:
                raise
            pytest.fail(str(failure), pytrace=False)

    return make


@parametrize_with_checks(  # type: ignore[untyped-decorator]
    [HysteresisRegressor()], expected_failed_checks=lambda _: BY_ORDER | NO_RECORDING
)
def test_scikit_learns_checks(
    estimator: HysteresisRegressor, check: Any, briefly: Callable[[Callable[[], None]], None]
) -> None:
    briefly(lambda: check(estimator))


class Follower:
    """A play that follows the sum of any inputs: a fit to samples that are no recording."""

    def __init__(self, x: Any, y: Any) -> None:
        self.inputs = tuple(f"x{place}" for place in range(x.shape[1]))
        self.centre = x.mean(axis=0)
        self.factors = np.linalg.lstsq(x - self.centre, y - y.mean())[0]
        width = 0.1 * float(np.ptp((x - self.centre) @ self.factors))
        self.play = osn.hysteresis.model("play", width_mm=width, gain=1.0, offset_mm=y.mean())

    def predict(self, x: Any, _: float | None) -> Any:
        return self.play.simulate((x - self.centre) @ self.factors, 0.0)


@pytest.fixture
def follows_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("opensuction.sklearn.LEAST_SAMPLES", 2)
    monkeypatch.setattr("opensuction.sklearn.identify", lambda x, y, *_, **__: Follower(x, y))


@pytest.mark.usefixtures("follows_anything")
@parametrize_with_checks(  # type: ignore[untyped-decorator]
    [HysteresisRegressor()], expected_failed_checks=lambda _: BY_ORDER
)
def test_scikit_learns_checks_with_a_play_that_follows_anything(
    estimator: HysteresisRegressor, check: Any, briefly: Callable[[Callable[[], None]], None]
) -> None:
    briefly(lambda: check(estimator))


@pytest.mark.parametrize("check", [*BY_ORDER, *NO_RECORDING])
def test_the_page_lists_the_checks_that_fail(check: str) -> None:
    assert f"`{check}`" in PAGE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def fitted() -> HysteresisRegressor:
    return HysteresisRegressor().fit(X, Y)


def test_it_predicts_what_its_fit_does_to_the_last_bit(fitted: HysteresisRegressor) -> None:
    fit = osn.identify(ROW, Y)
    assert np.array_equal(fitted.predict(X), fit.predict(ROW))
    assert fitted.fit_.parameters == fit.parameters
    assert fitted.score(X, Y) == pytest.approx(fit.score(ROW, Y), abs=1e-12)


def test_the_past_is_that_of_the_fit_a_number_or_the_fitted_samples(
    fitted: HysteresisRegressor,
) -> None:
    later, after_advance = clone(fitted).set_params(past="fitted"), clone(fitted)
    after_advance.set_params(past=1.0)
    later.fit(X[:300], Y[:300])
    assert np.array_equal(later.predict(X[300:]), later.fit_.predict(ROW)[300:])
    after_advance.fit(X, Y)
    assert np.array_equal(after_advance.predict(X), fitted.fit_.predict(ROW, past=1.0))
    assert not np.array_equal(after_advance.predict(X), fitted.predict(X))


def test_an_output_that_falls_is_negated_unless_it_is_said_otherwise() -> None:
    falling = HysteresisRegressor().fit(X, -Y)
    assert np.array_equal(
        falling.predict(X), osn.identify(ROW, -Y, negate_output=True).predict(ROW)
    )
    said = refusal(lambda: HysteresisRegressor(negate_output=False).fit(X, -Y))
    assert "falls where 'x' rises" in said


def test_it_stands_in_a_pipeline() -> None:
    pipeline = make_pipeline(StandardScaler(), HysteresisRegressor("modified-dahl"))
    assert pipeline.fit(X, Y).score(X, Y) > 0.99


def test_it_is_cross_validated_on_what_follows() -> None:
    splits = TimeSeriesSplit(n_splits=3)
    scores = cross_val_score(HysteresisRegressor(past="fitted"), X, Y, cv=splits)
    assert scores.shape == (3,)
    assert scores.min() > 0.9


def test_models_are_searched() -> None:
    search = GridSearchCV(
        HysteresisRegressor(past="fitted"),
        {"model": ["dahl", "modified-dahl"]},
        cv=TimeSeriesSplit(n_splits=2),
    )
    search.fit(X, Y)
    assert np.isfinite(search.cv_results_["mean_test_score"]).all()
    assert search.best_estimator_.fit_.model == search.best_params_["model"]
    assert search.score(X, Y) > 0.9


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Models that are quick to fit."""
    names = ("modified-dahl", "dahl")
    monkeypatch.setattr(workbench, "MODELS", {name: MODELS[name] for name in names})


@pytest.mark.usefixtures("few")
def test_auto_takes_the_model_that_is_recommended() -> None:
    x, y = wrist(400)
    auto = HysteresisRegressor("auto", purpose="transfer").fit(X, Y)
    recommended = osn.compare(ROW, Y, purpose="transfer").recommended
    assert auto.fit_.model == recommended.model
    assert np.array_equal(auto.predict(X), recommended.predict(ROW))
    of_two = HysteresisRegressor("auto").fit(x, y)
    assert np.array_equal(of_two.predict(x), of_two.fit_.predict(x[:, 0]))
    assert "each model has its own" in refusal(
        lambda: HysteresisRegressor("auto", method="rising").fit(X, Y)
    )
    assert "purpose" in refusal(lambda: HysteresisRegressor("auto", purpose="win").fit(X, Y))


def test_before_it_is_fitted_it_says_so() -> None:
    with pytest.raises(NotFittedError, match="HysteresisRegressor instance is not fitted yet"):
        HysteresisRegressor().predict(X)


WITH_NAN = np.where(np.arange(X.size) == 7, np.nan, ROW)[:, None]
BAD: dict[str, tuple[Any, Any, dict[str, Any], str]] = {
    "one axis": (ROW, Y, {}, "Reshape your data"),
    "a list of one axis": (ROW.tolist(), Y, {}, "Reshape your data"),
    "three axes": (X[:, :, None], Y, {}, "dim 3"),
    "not a number": (WITH_NAN, Y, {}, "X contains NaN."),
    "infinite": (X, np.where(np.arange(Y.size) == 3, np.inf, Y), {}, "y contains infinity"),
    "text": ([["far"]] * 50, Y[:50], {}, "could not convert string to float"),
    "complex": (X + 1j, Y, {}, "Complex data not supported"),
    "lengths": (X, Y[:-1], {}, "inconsistent numbers of samples: [400, 399]"),
    "too few": (X[:30], Y[:30], {}, "n_samples = 30, n_features = 1; at least 40"),
    "huge": (X * 1e300, Y * 1e300, {}, "beyond 1e+30"),
    "constant": (np.ones_like(X), Y, {}, "constant at 1"),
    "constant output": (X, np.ones_like(Y), {}, "constant at 1"),
    "one way": (np.sort(X, axis=0), np.sort(Y), {}, "reverses by 0 of"),
    "no order": (
        np.random.default_rng(5).permutation(X),
        Y,
        {},
        "trembles",
    ),
    "two inputs": (np.hstack([X, X**2]), Y, {}, "follows one input, not 2"),
    "model": (X, Y, {"model": "dal"}, "dahl"),
    "no model": (X, Y, {"model": None}, "model"),
    "method": (X, Y, {"method": "best"}, "best"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_recordings_are_refused_in_one_line(case: str) -> None:
    x, y, parameters, words = BAD[case]
    assert words in refusal(lambda: HysteresisRegressor(**parameters).fit(x, y))


def test_what_it_cannot_predict_is_refused_in_one_line(fitted: HysteresisRegressor) -> None:
    assert "2 features, but HysteresisRegressor is expecting 1" in refusal(
        lambda: fitted.predict(np.hstack([X, X]))
    )
    assert "contains NaN." in refusal(lambda: fitted.predict(WITH_NAN))
    for past, words in (("never", "past 'never': should be"), (3.0, "past")):
        other = pickle.loads(pickle.dumps(fitted)).set_params(past=past)
        assert words in refusal(lambda one=other: one.predict(X))
    with pytest.raises(TypeError, match="Sparse data was passed"):
        fitted.predict(sparse.csr_array(X))


def test_columns_are_known_by_their_names() -> None:
    frame = pd.DataFrame({"head_mm": ROW})
    regressor = HysteresisRegressor().fit(frame, pd.Series(Y))
    assert regressor.feature_names_in_.tolist() == ["head_mm"]
    assert "unseen at fit time: - tip_mm" in refusal(
        lambda: regressor.predict(frame.rename(columns={"head_mm": "tip_mm"}))
    )


def test_it_is_cloned_pickled_and_shown(fitted: HysteresisRegressor) -> None:
    assert np.array_equal(pickle.loads(pickle.dumps(fitted)).predict(X), fitted.predict(X))
    other = clone(HysteresisRegressor("dahl", past="fitted", negate_output=True))
    assert other.get_params() == {
        "model": "dahl",
        "method": None,
        "purpose": "predict",
        "negate_output": True,
        "past": "fitted",
    }
    assert repr(other) == "HysteresisRegressor(model='dahl', negate_output=True, past='fitted')"


@pytest.mark.parametrize("missing", ["sklearn.base", "sklearn.utils.validation"])
def test_without_scikit_learn_one_line_says_what_to_install(
    missing: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, "opensuction.sklearn")
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(ImportError) as refused:
        importlib.import_module("opensuction.sklearn")
    assert str(refused.value) == (
        "opensuction.sklearn needs scikit-learn 1.6 or later: pip install 'opensuction[sklearn]'"
    )
