"""A fitted model predicts recordings that it was not fitted to."""

import csv
import io
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import opensuction as osn
from opensuction.hysteresis.modified_dahl import PUBLISHED, simulate
from opensuction.kernel.errors import InputError
from opensuction.recording import table
from opensuction.report.identification import identification_words as words
from opensuction.result.identification_result import PredictionResult
from opensuction.session.choice import PredictionChoice
from opensuction.session.identification import prediction_run as run

Values = NDArray[np.float64]
NOW = datetime(2026, 11, 28, tzinfo=UTC)
TIME_S = 0.05 * np.arange(800.0)
HEAD = 50.0 - 50.0 * np.cos(2.0 * np.pi * TIME_S / 20.0)
OTHER = 50.0 - 20.0 * np.cos(2.0 * np.pi * TIME_S / 9.0) - 30.0 * np.cos(TIME_S)
NOISE_MM = 0.3


def noise(seed: int) -> Values:
    return NOISE_MM * np.random.default_rng(seed).standard_normal(TIME_S.size)


def write(file: Path, **columns: Values) -> Path:
    rows = (",".join(map(repr, row)) for row in np.column_stack([*columns.values()]).tolist())
    file.write_text("\n".join([",".join(columns), *rows]) + "\n")
    return file


def fit(file: Path, output: Values, name: str = "tip_mm", **more: Any) -> Path:
    """The parameter file of a fit."""
    osn.identify(HEAD, output, names=("head_mm", name), **more).save(file)
    return file


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fit(
        tmp_path_factory.mktemp("fit") / "fit.toml", simulate(PUBLISHED, HEAD, 0.0) + noise(1)
    )


def predicted(recording: Path, model: Path, **more: Any) -> tuple[run.Prediction, PredictionResult]:
    found = run.predict(PredictionChoice(recording, model, **more))
    return found, run.summarise(found, NOW, Path("prediction.csv"))


def test_what_the_library_predicts_is_predicted_to_the_last_bit(
    tmp_path: Path, model: Path
) -> None:
    found, result = predicted(write(tmp_path / "next.csv", head_mm=OTHER), model)
    assert np.array_equal(found.predicted, osn.load(model).predict(OTHER))
    assert (result.samples, result.output, result.error) == (800, None, None)
    assert (result.lowest, result.highest) == (found.predicted.min(), found.predicted.max())


def test_the_error_is_that_of_the_noise_and_the_interval_holds_what_it_says(
    tmp_path: Path, model: Path
) -> None:
    tip = simulate(PUBLISHED, OTHER, 0.0)
    inside = []
    for seed in range(10):
        recording = write(tmp_path / f"{seed}.csv", head_mm=OTHER, tip_mm=tip + noise(100 + seed))
        _, result = predicted(recording, model, with_interval=True)
        assert result.error is not None
        assert result.error.inside_interval_ratio is not None
        assert result.error.rmse == pytest.approx(NOISE_MM, rel=0.1)
        assert abs(result.error.mean) < 0.1 * NOISE_MM
        assert result.warnings == ()
        inside.append(result.error.inside_interval_ratio)
    assert 0.94 < np.mean(inside) < 0.96


def test_the_table_has_a_row_for_each_sample_and_loses_no_digit(
    tmp_path: Path, model: Path
) -> None:
    recording = write(tmp_path / "next.csv", t_ms=1e3 * TIME_S, head_mm=OTHER, tip_mm=OTHER)
    found, _ = predicted(recording, model, time="t_ms", with_interval=True)
    rows = list(csv.DictReader(io.StringIO(run.to_table(found))))
    assert list(rows[0]) == [
        "time_s",
        "head_mm",
        "tip_mm",
        "predicted",
        "lower_95",
        "upper_95",
    ]
    column = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    assert column["time_s"] == pytest.approx(TIME_S, abs=1e-12)
    assert column["head_mm"] == pytest.approx(OTHER, rel=1e-14)
    assert column["predicted"] == pytest.approx(found.predicted, rel=1e-14)
    half = 1.96 * osn.load(model).rmse
    assert column["upper_95"] - column["predicted"] == pytest.approx(half, rel=1e-3)
    assert column["predicted"] - column["lower_95"] == pytest.approx(half, rel=1e-3)


def test_a_name_with_a_comma_or_a_quote_is_one_cell(tmp_path: Path) -> None:
    model = tmp_path / "fit.toml"
    fitted = osn.identify(HEAD, simulate(PUBLISHED, HEAD, 0.0), names=('head, "x" (mm)', "tip_mm"))
    fitted.save(model)
    recording = tmp_path / "a.csv"
    recording.write_text('"head, ""x"" (mm)"\n1.5\n2.5\n')
    found, _ = predicted(recording, model)
    rows = list(csv.reader(io.StringIO(run.to_table(found))))
    assert rows[0] == ['head, "x" (mm)', "predicted"]
    assert [row[0] for row in rows[1:]] == ["1.5", "2.5"]


def test_a_span_of_time_is_predicted_by_itself(tmp_path: Path, model: Path) -> None:
    recording = write(tmp_path / "next.csv", time_s=TIME_S, head_mm=OTHER)
    found, result = predicted(recording, model, time="time_s", from_s=10.0, to_s=20.0)
    inside = (TIME_S >= 10.0) & (TIME_S <= 20.0)
    assert np.array_equal(found.predicted, osn.load(model).predict(OTHER[inside]))
    assert result.samples == inside.sum()


def test_an_output_that_was_turned_round_comes_back_as_it_was_recorded(tmp_path: Path) -> None:
    jaw = -simulate(PUBLISHED, HEAD, 0.0)
    model = fit(tmp_path / "fit.toml", jaw, "jaw_mm", negate_output=True)
    _, result = predicted(write(tmp_path / "a.csv", head_mm=HEAD, jaw_mm=jaw), model)
    assert result.error is not None
    assert result.error.rmse < 1e-6


def test_columns_of_other_names_are_named(tmp_path: Path, model: Path) -> None:
    tip = simulate(PUBLISHED, OTHER, 0.0)
    recording = write(tmp_path / "a.csv", motor_mm=OTHER, laser_mm=tip)
    with pytest.raises(InputError) as refused:
        predicted(recording, model)
    assert str(refused.value) == (
        f"{recording}: the model's input is head_mm; name its column by --input; columns: "
        "motor_mm, laser_mm"
    )
    _, result = predicted(recording, model, driven=("motor_mm",), measured="laser_mm")
    assert (result.inputs, result.output) == (("motor_mm",), "laser_mm")
    assert result.error is not None
    assert result.error.rmse < NOISE_MM


def test_an_output_that_has_gaps_may_be_left_aside(tmp_path: Path, model: Path) -> None:
    gaps = np.where(TIME_S > 20.0, np.nan, HEAD)
    recording = write(tmp_path / "a.csv", head_mm=OTHER, tip_mm=gaps)
    with pytest.raises(InputError, match="tip_mm"):
        predicted(recording, model)
    found, result = predicted(recording, model, measured="")
    assert (result.samples, result.output, result.error) == (800, None, None)
    assert run.to_table(found).startswith("head_mm,predicted\n")


def test_several_inputs_are_taken_in_the_model_s_order(tmp_path: Path) -> None:
    # A straight line of few samples: how well it is fitted is not the point, and it takes less.
    head, other = HEAD[::8], 10.0 * np.sin(TIME_S[::8])
    output = 0.9 * head + 0.3 * other
    inputs = np.column_stack([head, other])
    fitted = osn.identify(inputs, output, "play-readout", names=("head_mm", "bend_deg", "tip_mm"))
    model = tmp_path / "fit.toml"
    fitted.save(model)
    recording = write(tmp_path / "a.csv", bend_deg=other, head_mm=head, tip_mm=output)
    found, result = predicted(recording, model)
    assert result.inputs == ("head_mm", "bend_deg")
    assert np.array_equal(found.predicted, fitted.predict(inputs))
    with pytest.raises(InputError, match=r"^--input is given 1 times, the model of .* follows 2"):
        predicted(recording, model, driven=("head_mm",))


def test_inputs_beyond_the_fitted_range_are_told_with_the_first(
    tmp_path: Path, model: Path
) -> None:
    recording = write(tmp_path / "a.csv", time_s=TIME_S, head_mm=HEAD * 1.2)
    _, result = predicted(recording, model, time="time_s")
    assert result.beyond_range == (HEAD * 1.2 > 100.0).sum() > 0
    assert result.warnings == (
        f"{result.beyond_range} of 800 samples, the first at "
        f"{TIME_S[np.argmax(HEAD * 1.2 > 100.0)]:.10g} s, lie outside of the inputs that the "
        "model was fitted to, 0 to 100 mm; what is predicted there is a guess.",
    )


def test_a_recording_of_another_kind_is_told(tmp_path: Path, model: Path) -> None:
    tip = simulate(PUBLISHED, HEAD, 0.0) + 5.0
    _, result = predicted(write(tmp_path / "a.csv", head_mm=HEAD, tip_mm=tip), model)
    assert result.error is not None
    assert result.error.mean == pytest.approx(5.0, abs=0.1)
    (warning,) = result.warnings
    assert "times that of the fit, and its mean is 5" in warning


@pytest.mark.parametrize(
    ("columns", "more", "words"),
    [
        ({"head_m": OTHER}, {"driven": ("head_m",)}, "'head_m' is in m, and the model of .* mm"),
        (
            {"head_mm": OTHER},
            {"measured": "tip_mm"},
            "unknown column in .*'tip_mm'; known: head_mm",
        ),
        ({"head_mm": OTHER}, {"from_s": 1.0}, "--from needs the column of time"),
        ({"head_mm": OTHER, "time_s": -TIME_S}, {"time": "time_s"}, "time_s"),
        (
            {"head_mm": np.array([0.0, np.nan, 1.0])},
            {},
            "line 3, column 'head_mm': 'nan' is no number",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused_in_one_line(
    tmp_path: Path, model: Path, columns: dict[str, Values], more: dict[str, Any], words: str
) -> None:
    with pytest.raises(InputError, match=words) as refused:
        predicted(write(tmp_path / "a.csv", **columns), model, **more)
    assert "\n" not in str(refused.value)


def test_no_parameter_file_is_refused_before_the_recording_is_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.toml"):
        predicted(tmp_path / "absent.csv", tmp_path / "absent.toml")


def test_rows_without_a_number_are_left_out_on_request(tmp_path: Path, model: Path) -> None:
    holed = OTHER.copy()
    holed[[3, 50]] = np.nan
    recording = write(tmp_path / "a.csv", head_mm=holed)
    found, result = predicted(recording, model, skip_missing=True)
    assert (result.samples, result.skipped_rows) == (798, 2)
    assert np.array_equal(found.predicted, osn.load(model).predict(np.delete(OTHER, [3, 50])))


def test_standard_input_is_read(
    tmp_path: Path, model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = write(tmp_path / "a.csv", head_mm=OTHER)
    with recording.open("rb") as stream:
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(stream))
        _, result = predicted(table.DASH, model)
    assert (result.file, result.samples) == (table.NAME, 800)


def test_the_words_say_what_the_figures_say(tmp_path: Path, model: Path) -> None:
    tip = simulate(PUBLISHED, HEAD, 0.0) + noise(3)
    recording = write(tmp_path / "a.csv", head_mm=HEAD, tip_mm=tip)
    _, result = predicted(recording, model, with_interval=True)
    assert result.error is not None
    assert result.error.inside_interval_ratio is not None
    first, second, third = words.prediction_sentences(result)
    assert first.endswith("mm for head_mm.")
    assert "From the measured tip_mm it is 0.3035 mm RMSE" in second
    assert f"{100.0 * result.error.inside_interval_ratio:.3g} % of the measured lie in it" in third
    alone = words.prediction_sentences(result._replace(error=None, interval_half_width=None))
    assert alone[1:] == ["The recording has no output to hold it against."]
