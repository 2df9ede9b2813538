"""Data that the library takes as a recording, and refusals in one line."""

from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

import opensuction as osn
from opensuction.library import columns
from tests.library.recordings import bench, wrist
from tests.library.test_fit import refusal

X, Y = bench(200)
PLAIN = osn.identify(X, Y)
FRAME = {"head_mm": X, "tip_mm": Y}


@pytest.mark.parametrize("frame", [pd.DataFrame(FRAME), pl.DataFrame(FRAME), FRAME])
def test_columns_of_a_data_frame_bring_their_names_and_units(frame: Any) -> None:
    fit = osn.identify(frame["head_mm"], frame["tip_mm"])
    assert fit.predict(X) == pytest.approx(PLAIN.predict(X), abs=1e-12)
    if frame is not FRAME:
        recording = fit.summary["recording"]
        assert recording["input"]["column"] == "head_mm"
        assert recording["output"]["column"] == "tip_mm"
        assert fit.parameters["offset"].unit == "mm"


@pytest.mark.parametrize("make", [pd.DataFrame, pl.DataFrame, dict])
def test_a_data_frame_is_several_inputs(make: Any) -> None:
    x, _ = wrist(200)
    frame = make({"jaw_deg": x[:, 0], "pitch_deg": x[:, 1]})
    assert list(columns.split_inputs(frame)) == ["jaw_deg", "pitch_deg"]
    assert np.array_equal(columns.read_inputs(frame, 2), x.T)


def test_lists_columns_and_whole_numbers_are_taken() -> None:
    assert np.array_equal(osn.identify(X.tolist(), Y.tolist()).predict(X), PLAIN.predict(X))
    assert np.array_equal(osn.identify(X[:, None], Y[:, None]).predict(X), PLAIN.predict(X))
    assert osn.identify(X.astype(int), np.round(Y).astype(np.int32)).rmse > 0.0


def test_time_may_be_dates() -> None:
    dates = np.datetime64("2026-01-01") + (np.arange(X.size) * 50).astype("timedelta64[ms]")
    fit = osn.identify(X, Y, time=dates)
    assert fit.summary["recording"]["to_s"] == pytest.approx(0.05 * (X.size - 1))
    assert osn.identify(X, Y, time=pd.Series(dates)).summary["recording"]["to_s"] > 9.0


def test_names_and_units_are_those_that_are_given() -> None:
    fit = osn.identify(X, Y, names=("a", "b"), units=("deg", "mm"))
    assert fit.parameters["slope"].unit == "mm/deg"
    assert fit.summary["recording"]["output"] == fit.summary["recording"]["output"] | {
        "column": "b",
        "unit": "mm",
    }


BAD: dict[str, tuple[Any, str]] = {
    "unequal": (lambda: osn.identify(X, Y[1:]), "samples of x 200, y 199: they should be as many"),
    "constant": (lambda: osn.identify(0.0 * X, Y), "column 'x' is constant at 0"),
    "falling": (lambda: osn.identify(X, -Y), "add negate_output"),
    "missing": (lambda: osn.identify(np.append(X[1:], np.nan), Y), "x: sample 199 is nan"),
    "masked": (
        lambda: osn.identify(np.ma.masked_array(X, X > 99.0), Y),
        "sample 25 is nan",
    ),
    "complex": (lambda: osn.identify(X + 1j, Y), "not a row of numbers but of complex128"),
    "digits": (lambda: osn.identify([str(one) for one in X], Y), "not a row of numbers but of"),
    "nothing": (lambda: osn.identify(None, Y), "shape (), should be (samples,)"),
    "text": (lambda: osn.identify(["a", "b"], Y), "x: not a row of numbers"),
    "turned": (lambda: osn.identify(np.zeros((2, 200)), Y), "transpose it: x.T"),
    "cube": (lambda: osn.identify(np.zeros((2, 2, 2)), Y), "should be (samples,) or"),
    "short": (lambda: osn.identify(X[:5], Y[:5]), "at least 12 are needed"),
    "no columns": (lambda: osn.identify({}, Y), "has no columns"),
    "two inputs": (lambda: osn.identify(wrist(200)[0], Y), "follows one input, not 2"),
    "no matrix": (lambda: osn.identify(np.zeros((200, 0)), Y), "has no columns"),
    "no model": (lambda: osn.identify(X, Y, None), "unknown model None"),  # type: ignore[arg-type]
    "unit": (
        lambda: osn.identify(X, Y, units="mm"),  # type: ignore[arg-type]
        "should be those of input and output",
    ),
    "model": (lambda: osn.identify(X, Y, "modifed-dahl"), "did you mean 'modified-dahl'?"),
    "method": (lambda: osn.identify(X, Y, method="guess"), "unknown method 'guess'"),
    "holdout": (lambda: osn.identify(X, Y, holdout=2.0), "holdout 2: should be from 0 to 0.9"),
    "time": (lambda: osn.identify(X, Y, time=X), "time should rise"),
    "purpose": (lambda: osn.compare(X, Y, "win"), "unknown purpose 'win'"),
    "names": (lambda: osn.identify(X, Y, names=("a",)), "should be 2 names"),
    "a name": (lambda: osn.identify(X, Y, names="ab"), "should be 2 names"),
    "alike": (lambda: osn.identify(X, Y, names=("a", "a")), "each should be another"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_identified_is_refused_in_the_words_of_python(case: str) -> None:
    call, words = BAD[case]
    said = refusal(call)
    assert words in said
    assert "--" not in said
