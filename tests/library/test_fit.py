"""Fits as a script has them: the command's figures, predictions, inverses, pictures and files."""

import functools
import json
import pickle
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import opensuction as osn
from opensuction.hysteresis.bank import play_readout
from opensuction.identification.workbench import MODELS
from tests.cli.command import opensuction
from tests.library.recordings import bench, strokes, wrist

X, Y = bench(300)
NAMES = ("head_mm", "tip_mm")


def refusal(call: Any) -> str:
    with pytest.raises(osn.InputError) as raised:
        call()
    assert len(str(raised.value).splitlines()) == 1
    return str(raised.value)


def test_the_figures_are_the_commands(tmp_path: Path) -> None:
    rows = [f"{x!r},{y!r}" for x, y in np.column_stack([X, Y]).tolist()]
    (tmp_path / "bench.csv").write_text("\n".join(["head_mm,tip_mm", *rows]) + "\n")
    options = ("--input", "head_mm", "--output", "tip_mm", "--holdout", "0.25", "--json")
    ran = opensuction("identify", "bench.csv", *options, cwd=tmp_path)
    command, fit = json.loads(ran.stdout), osn.identify(X, Y, names=NAMES, holdout=0.25)
    of_the_run = {"recording", "date_utc", "seconds", "parameter_file", "fit_seconds"}
    assert command.keys() == fit.summary.keys()
    for key in command.keys() - of_the_run:
        assert fit.summary[key] == command[key], key
    assert fit.holdout_rmse_percent_of_range == command["holdout_rmse_percent_of_range"]
    assert fit.warnings == tuple(command["warnings"])
    assert fit.parameters["slope"].value == command["parameters"]["slope"]["value"]
    assert fit.parameters["slope"].unit == "mm/mm"
    assert fit.parameters["slope"].ci95 == command["parameters"]["slope"]["ci95"]


@pytest.fixture(scope="module")
def compared() -> osn.Comparison:
    return osn.compare(X, Y, "compensate", names=NAMES, holdout=0.25)


@pytest.fixture(scope="module")
def fit(compared: osn.Comparison) -> osn.Fit:
    return compared["prandtl-ishlinskii"]


def test_every_model_predicts_what_was_fitted_and_the_same_once_loaded(
    compared: osn.Comparison, tmp_path: Path
) -> None:
    assert {fit.model for fit in compared} == MODELS.keys()
    new = strokes(257) * 0.8 + 5.0
    for fit in compared:
        assert fit.recording is not None
        assert np.array_equal(fit.predict(X), fit.recording.fitted), fit.model
        fit.save(tmp_path / "fit.toml")
        loaded = osn.load(tmp_path / "fit.toml")
        assert np.array_equal(loaded.predict(new), fit.predict(new)), fit.model
        assert (loaded.model, loaded.rmse, loaded.inputs) == (fit.model, fit.rmse, ("head_mm",))
        assert repr(loaded) == repr(fit)
        assert loaded.parameters == fit.parameters


@pytest.mark.sweep
def test_several_inputs_are_fitted_predicted_and_loaded(tmp_path: Path) -> None:
    x, y = wrist(240)
    fit = osn.identify(
        pd.DataFrame(x), y, "play-readout", names=("jaw_deg", "pitch_deg", "tip_deg")
    )
    assert fit.recording is not None
    assert np.array_equal(fit.predict(x), fit.recording.fitted)
    assert fit.summary["recording"]["other_inputs"] == ["pitch_deg"]
    fit.save(tmp_path / "fit.toml")
    loaded = osn.load(tmp_path / "fit.toml")
    assert loaded.inputs == ("jaw_deg", "pitch_deg")
    assert np.array_equal(loaded.predict(x), fit.predict(x))
    assert "follows 2 inputs (jaw_deg, pitch_deg); an inverse is of one" in refusal(
        lambda: fit.inverse(y)
    )
    assert "has 1 inputs, the model follows 2 inputs" in refusal(lambda: fit.predict(x[:, 0]))
    assert ET.fromstring(fit.plot().svg).tag.endswith("svg")


def test_residuals_and_score_are_of_the_output_as_it_was_given() -> None:
    x, y = X, -2.0 * X + np.sin(np.arange(X.size))
    fit = osn.identify(x, y, "prandtl-ishlinskii", negate_output=True)
    assert np.array_equal(fit.residuals, y - fit.predict(x))
    assert fit.score(x, y) == pytest.approx(1.0 - np.var(fit.residuals) / np.var(y), abs=1e-6)
    assert fit.score(x, y + 50.0) < 1.0 - 50.0**2 / np.var(y) + 0.1
    assert "does not move" in refusal(lambda: fit.score(x, np.ones(x.size)))
    assert f"x has {x.size} samples, y has 3" in refusal(lambda: fit.score(x, [1.0, 2.0, 3.0]))


def test_a_fit_that_has_predicted_is_pickled(fit: osn.Fit) -> None:
    predicted = fit.predict(X)
    again = pickle.loads(pickle.dumps(fit))
    assert np.array_equal(again.predict(X), predicted)
    assert again.summary == fit.summary


def test_a_loaded_fit_has_no_residuals(fit: osn.Fit, tmp_path: Path) -> None:
    fit.save(tmp_path / "fit.toml")
    said = refusal(lambda: osn.load(tmp_path / "fit.toml").residuals)
    assert "a parameter file has no samples" in said


def test_a_readout_with_a_slow_state_predicts_and_is_loaded_again(tmp_path: Path) -> None:
    x = strokes(2400)
    y = osn.hysteresis.model("play", width_mm=8.0, gain=0.9, offset_mm=1.0).simulate(x)
    y += 0.02 * play_readout.lag_columns(np.array([300.0]), x, np.array([0.0]))[0]
    fit = osn.identify(x, y + 0.02 * np.sin(7.0 * np.arange(x.size)), "play-readout")
    assert any(name.startswith("lag") for name in fit.parameters)
    assert fit.recording is not None
    assert np.array_equal(fit.predict(x), fit.recording.fitted)
    fit.save(tmp_path / "fit.toml")
    assert np.array_equal(osn.load(tmp_path / "fit.toml").predict(x), fit.predict(x))


@pytest.mark.parametrize("past", [-1.0, 0.0, 1.0])
def test_what_is_inverted_is_predicted_again(fit: osn.Fit, past: float) -> None:
    assert fit.is_invertible
    wanted = np.concatenate([np.linspace(0.0, 70.0, 40), np.linspace(70.0, 10.0, 40)])
    x = fit.inverse(wanted, past=past)
    start = 100.0 if past > 0.0 else 0.0
    assert fit.predict(x, past=past, start=start) == pytest.approx(wanted, abs=1e-9)
    again = fit.inverse(wanted, past=past, start=30.0)
    assert fit.predict(again, past=past, start=30.0) == pytest.approx(wanted, abs=1e-9)


def test_a_model_that_is_not_invertible_says_why_and_may_jump() -> None:
    y = osn.hysteresis.model("play", width_mm=12.0, gain=0.9, offset_mm=1.0).simulate(X)
    fit = osn.identify(X, y + 0.01 * np.sin(X), "modified-dahl")
    assert not fit.is_invertible
    said = refusal(lambda: fit.inverse([10.0, 20.0]))
    assert "has no continuous inverse" in said
    assert "jumps=True" in said
    wanted = np.array([10.0, 40.0, 39.0, 20.0])
    x = fit.inverse(wanted, jumps=True)
    assert fit.predict(x, past=-1.0, start=0.0) == pytest.approx(wanted, abs=1e-6)


def test_a_model_that_only_predicts_has_no_inverse_with_or_without_jumps(
    compared: osn.Comparison,
) -> None:
    for jumps in (False, True):
        said = refusal(functools.partial(compared["residual-readout"].inverse, [10.0], jumps=jumps))
        assert "has no inverse" in said
        assert "jumps" not in said


def test_an_output_that_no_input_reaches_is_refused(compared: osn.Comparison) -> None:
    preisach = compared["preisach"]
    assert "y: sample 1 is 1e+06, which no input of model 'preisach' reaches" in refusal(
        lambda: preisach.inverse([10.0, 1e6], jumps=True)
    )
    for no_row in ([1.0, np.nan], [[1.0]], "far"):
        assert "one row of finite numbers" in refusal(functools.partial(preisach.inverse, no_row))


def test_a_negated_output_comes_back_as_it_was_given(tmp_path: Path) -> None:
    fit = osn.identify(X, -Y, negate_output=True)
    plain = osn.identify(X, Y)
    assert fit.predict(X) == pytest.approx(-plain.predict(X))
    assert fit.inverse([-30.0, -40.0], jumps=True) == pytest.approx(
        plain.inverse([30.0, 40.0], jumps=True)
    )
    fit.save(tmp_path / "fit.toml")
    assert np.array_equal(osn.load(tmp_path / "fit.toml").predict(X), fit.predict(X))


def test_a_start_needs_its_past(fit: osn.Fit) -> None:
    assert "give past= too" in refusal(lambda: fit.predict(X, start=1.0))


class Axes:
    """What matplotlib's axes offer of all that is drawn here."""

    def __init__(self) -> None:
        self.lines: dict[str, tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]] = {}
        self.labels: list[str] = []
        self.has_legend = False

    def plot(self, x: Any, y: Any, label: str) -> None:
        self.lines[label] = x, y

    def set_xlabel(self, label: str) -> None:
        self.labels.append(label)

    set_ylabel = set_xlabel

    def legend(self) -> None:
        self.has_legend = True


def test_it_is_drawn_without_anything_installed_and_into_axes(fit: osn.Fit, tmp_path: Path) -> None:
    drawing = fit.plot()
    root = ET.fromstring(drawing._repr_svg_())
    lines = root.findall("{http://www.w3.org/2000/svg}polyline")
    words = [one.text for one in root.iter("{http://www.w3.org/2000/svg}text")]
    assert len(lines) == 2
    assert {"head_mm (mm)", "tip_mm (mm)", "recording", "prandtl-ishlinskii"} <= set(words)
    drawing.save(tmp_path / "loop.svg")
    assert (tmp_path / "loop.svg").read_text("utf-8") == drawing.svg
    axes = Axes()
    assert fit.plot(ax=axes) is axes
    assert np.array_equal(axes.lines["recording"][1], Y)
    assert np.array_equal(axes.lines["prandtl-ishlinskii"][1], fit.predict(X))
    assert axes.labels == ["head_mm (mm)", "tip_mm (mm)"]
    assert axes.has_legend


def test_a_notebook_shows_figures_and_loop_and_no_markup_of_a_column() -> None:
    fit = osn.identify(X, Y, names=("<script>", "tip_mm"))
    page = fit._repr_html_()
    assert "rmse" in page
    assert "<svg" in page
    assert "<script>" not in page


def test_it_is_shown_in_a_line(fit: osn.Fit) -> None:
    assert repr(fit).startswith("Fit(prandtl-ishlinskii, rmse 0.0")
    assert repr(fit).endswith(" % of range), 300 samples)")
    assert len(repr(fit.parameters).splitlines()) <= 9


def test_another_ending_is_refused(fit: osn.Fit, tmp_path: Path) -> None:
    assert "ends in .toml" in refusal(lambda: fit.save(tmp_path / "fit.json"))
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(FileNotFoundError):
        fit.save(tmp_path / "none" / "fit.toml")


def test_a_loaded_fit_has_what_its_file_holds_and_nothing_that_was_judged(tmp_path: Path) -> None:
    fit = osn.identify(X, Y, names=NAMES, holdout=0.25)
    fit.save(tmp_path / "fit.toml")
    loaded = osn.load(tmp_path / "fit.toml")
    assert list(loaded.summary) == [
        "model",
        "method",
        "parameters",
        "rmse",
        "rmse_unit",
        "rmse_percent_of_range",
        "well_posed",
        "samples",
        "fitted_samples",
        "parameter_file",
    ]
    for key in loaded.summary.keys() - {"parameter_file"}:
        assert loaded.summary[key] == fit.summary[key], key
    assert loaded.summary["parameter_file"] == str(tmp_path / "fit.toml")
    assert fit.warnings
    assert fit.holdout_rmse_percent_of_range is not None
    assert (loaded.warnings, loaded.holdout_rmse_percent_of_range) == ((), None)


def test_a_file_of_the_command_is_loaded_and_of_something_else_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text("a = 1\n")
    assert "no format_version" in refusal(lambda: osn.load(tmp_path / "bad.toml"))
    fit = osn.identify(X, Y)
    fit.save(tmp_path / "fit.toml")
    text = (tmp_path / "fit.toml").read_text("utf-8")
    (tmp_path / "old.toml").write_text(text.replace('"modified-dahl"', '"preisach"'))
    assert "written by an older version; identify again" in refusal(
        lambda: osn.load(tmp_path / "old.toml")
    )
