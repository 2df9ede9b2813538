import numpy as np
import pytest

from opensuction.report.identification import identification_page as series
from tests.report import identification_example as example


def test_extremes_of_output_and_residual_are_kept() -> None:
    curves = example.curves(samples=100_000)
    spoilt = curves.answer.copy()
    spoilt[54_321] += 30.0
    plots = series.curve_plots(curves._replace(answer=spoilt))
    name = example.MODELS[0]
    rest = spoilt - curves.fitted[name]
    assert max(plots["rest"][name]) == pytest.approx(rest.max(), abs=1e-3)
    assert max(plots["output"]) == pytest.approx(spoilt.max(), abs=1e-2)


def test_every_list_over_time_has_the_length_of_time() -> None:
    plots = series.curve_plots(example.curves())
    lists = [plots["output"], *plots["fitted"].values(), *plots["rest"].values()]
    assert {len(values) for values in lists} == {len(plots["time"])}
    loop = plots["loop"]
    lists = [loop["output"], loop["line"], *loop["fitted"].values()]
    assert {len(values) for values in lists} == {len(loop["input"])}


def test_loop_of_many_cycles_shows_some_of_them() -> None:
    driven = np.sin(np.linspace(0.0, 400.0 * np.pi, 100_000))  # 400 reversals
    end = series.loop_end(driven)
    assert end == pytest.approx(100_000 * series.LOOP_REVERSALS / 400, rel=0.1)
    assert series.loop_end(driven[:5000]) == 5000


def test_jitter_is_no_reversal() -> None:
    jitter = 0.005 * np.where(np.arange(1000) % 2, 1.0, -1.0)
    assert series.loop_end(np.linspace(0.0, 1.0, 1000) + jitter) == 1000


def test_samples_without_time_are_counted() -> None:
    plots = series.curve_plots(example.curves(timed=False))
    assert not plots["timed"]
    assert plots["time"][-1] == example.SAMPLES - 1
    assert plots["held_from"] == example.FITTED
    assert plots["autocorrelation"]["lag"][:3] == [0.0, 1.0, 2.0]


def test_held_out_samples_begin_where_the_fit_ends() -> None:
    curves = example.curves()
    assert curves.time_s is not None
    assert series.curve_plots(curves)["held_from"] == pytest.approx(curves.time_s[example.FITTED])
    whole = curves._replace(fitted_samples=example.SAMPLES)
    assert series.curve_plots(whole)["held_from"] is None


def test_noise_band_is_that_of_the_fitted_samples() -> None:
    band = series.curve_plots(example.curves())["autocorrelation"]["band"]
    assert band == pytest.approx(1.96 / np.sqrt(example.FITTED))
