"""Models of hysteresis as a regressor of scikit-learn: ``opensuction[sklearn]``.

Rows are samples in the order of time: what a model predicts for one depends on those before it. No
splitter may shuffle them; `sklearn.model_selection.TimeSeriesSplit` does not.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from textwrap import shorten
from typing import Any, Self

import numpy as np

from opensuction.identification.checked_recording import LEAST_SAMPLES
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.library.fit import Fit
from opensuction.library.workbench import compare, identify

try:
    from sklearn.base import BaseEstimator, RegressorMixin
    from sklearn.utils.validation import check_is_fitted, validate_data
except ImportError:
    raise ImportError(
        "opensuction.sklearn needs scikit-learn 1.6 or later: pip install 'opensuction[sklearn]'",
        name="sklearn",
    ) from None

AUTO = "auto"
"""Model that stands for the one that `compare` recommends."""
FITTED = "fitted"
"""Past of samples that follow those of the fit."""
LONGEST_LINE = 300
"""Characters that a refusal of scikit-learn is cut to."""
LEFT_OUT = re.compile(r"array=.*?\.\n(?=Reshape)|\n\w+ does not accept.*", re.DOTALL)
"""Samples that a refusal shows, and the advice to take other regressors."""


@contextmanager
def _in_one_line() -> Iterator[None]:
    """Turn a refusal of scikit-learn into an InputError of one line."""
    try:
        yield
    except ValueError as refused:
        words = LEFT_OUT.sub("", str(refused))
        raise InputError(shorten(words, LONGEST_LINE, placeholder=" ...")) from None


class HysteresisRegressor(RegressorMixin, BaseEstimator):  # type: ignore[misc]  # has no types
    """A model of hysteresis as scikit-learn has its regressors; `fit` and `predict` take matrices.

    model: as `opensuction.identify` names it, or ``"auto"``: the one that `opensuction.compare`
    recommends, which fits them all and takes its time. method: of the fit; None: the model's own.
    purpose: of the recommendation, with ``"auto"``: ``predict``, ``compensate`` or ``transfer``.
    negate_output: True for an output that falls as the first input rises; None: as the fitted
    samples say. past: before the first sample that is predicted, from -1 (after a long retract) to
    +1 (after a long advance); None: what the fitted samples began after; ``"fitted"``: those
    samples themselves, for what follows them, as each test part of a `TimeSeriesSplit` does.

    After `fit`: ``fit_``, the `opensuction.library.fit.Fit` with parameters, intervals and
    warnings; ``recorded_``, the inputs that it was fitted to, shape (samples, inputs);
    ``n_features_in_``, the number of inputs, and ``feature_names_in_`` where a data frame names
    them. ``score`` is the coefficient of determination.
    """

    def __init__(
        self,
        model: str = "modified-dahl",
        *,
        method: str | None = None,
        purpose: str = "predict",
        negate_output: bool | None = None,
        past: float | str | None = None,
    ) -> None:
        self.model = model
        self.method = method
        self.purpose = purpose
        self.negate_output = negate_output
        self.past = past

    def fit(self, X: Any, y: Any) -> Self:
        """Fit the model to a recording, its rows in the order of time; returns the regressor.

        X: what drives, shape (samples, inputs), at least 40 samples. y: what follows, shape
        (samples,). Raises InputError, a ValueError, in one line for what cannot be identified.
        """
        with _in_one_line():
            driven, answer = validate_data(self, X, y, dtype=np.float64, y_numeric=True)
        samples, inputs = driven.shape
        if samples < LEAST_SAMPLES:
            raise InputError(
                f"X: n_samples = {samples}, n_features = {inputs}; at least {LEAST_SAMPLES} "
                "samples in the order of time are needed"
            )
        negate = self.negate_output
        if negate is None:
            negate = _falls(driven[:, 0], answer)
        self.fit_ = self._identify(driven, answer, bool(negate))
        self.recorded_ = driven.copy()
        return self

    def predict(self, X: Any) -> Array:
        """Output of the fitted model, the rows in the order of time; shape (samples,).

        X: shape (samples, inputs), as many inputs as were fitted. Raises NotFittedError before
        `fit`, and InputError, a ValueError, in one line for what is no such matrix.
        """
        check_is_fitted(self)
        with _in_one_line():
            driven = validate_data(self, X, reset=False, dtype=np.float64)
        if isinstance(self.past, str):
            if self.past != FITTED:
                raise InputError(f"past {self.past!r}: should be -1 to 1, None or '{FITTED}'")
            recorded = np.vstack([self.recorded_, driven])
            return self._predict(recorded)[len(self.recorded_) :]
        return self._predict(driven, self.past)

    def _identify(self, driven: Array, answer: Array, negate: bool) -> Fit:
        if self.model != AUTO:
            return identify(driven, answer, self.model, method=self.method, negate_output=negate)
        if self.method is not None:
            raise InputError(
                f"method {self.method!r}: each model has its own with model '{AUTO}'; name a model"
            )
        return compare(driven, answer, self.purpose, negate_output=negate).recommended

    def _predict(self, driven: Array, past: float | None = None) -> Array:
        """Output of the model, which may follow the first of several inputs alone."""
        return self.fit_.predict(driven[:, : len(self.fit_.inputs)], past)


def _falls(driven: Array, answer: Array) -> bool:
    """True where the output falls as the input rises, over all samples."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool((driven - driven.mean()) @ (answer - answer.mean()) < 0.0)
