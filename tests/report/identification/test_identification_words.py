import io

import pytest
from rich.console import Console

from opensuction.report.identification import identification_words
from opensuction.report.identification import identification_words as words
from opensuction.result.identification_result import (
    FittedParameter,
    InputRange,
    RecordedColumn,
    WorkbenchResult,
)
from tests.report import identification_example as example


def said(**changes: object) -> str:
    return " ".join(words.sentences(example.identified(**changes)))


def test_sentences_give_error_line_held_out_and_gap() -> None:
    text = said()
    assert "tip_mm from head_mm" in text
    assert "0.3 % of the output's range. A straight line leaves 9.8 %" in text
    assert "last 1200 samples, which it has not seen, it is 0.4 %" in text
    assert "20 mm apart" in text  # 2 * 0.8 / 0.08


def test_what_was_not_computed_is_not_said() -> None:
    text = said(holdout_rmse_percent_of_range=None, model="bouc-wen")
    assert "not seen" not in text
    assert "apart" not in text  # the gap is of the modified Dahl model


@pytest.mark.parametrize("ends", [None, (-0.1, 1.7)])
@pytest.mark.parametrize("name", ["velocity_gain", "decay"])
def test_a_gap_that_is_not_determined_has_no_figure(
    name: str, ends: tuple[float, float] | None
) -> None:
    parameters = dict(example.identified().fit.parameters)
    parameters[name] = parameters[name]._replace(ci95=ends)
    assert "apart" not in said(parameters=parameters)


@pytest.mark.parametrize("value", [None, 0.0])
def test_no_gap_is_divided_by_a_decay_that_is_not_there(value: float | None) -> None:
    parameters = dict(example.identified().fit.parameters)
    parameters["decay"] = parameters["decay"]._replace(value=value)
    assert "apart" not in said(parameters=parameters)
    del parameters["decay"]
    assert "apart" not in said(parameters=parameters)


def test_what_is_not_determined_has_no_gap_whatever_its_intervals() -> None:
    assert "apart" in said(determined=True)
    assert "apart" not in said(determined=False)


def test_a_column_without_a_unit_gives_figures_without_one() -> None:
    output = RecordedColumn("pos (5)", "", False, 0.0, 90.0)
    result = example.identified(rmse=24.79, rmse_unit="output")
    result = result._replace(provenance=example.provenance(output=output))
    text = " ".join(words.sentences(result))
    assert "an error of 24.79 RMSE" in text
    assert "lie 20 apart" in text
    assert "output" not in text.replace("output's range", "")


def test_warnings_are_said_to_be_of_the_fitted_part() -> None:
    words_ = "Warnings are about what comes before, unless they say otherwise."
    assert words_ in said()
    assert words_ not in said(warnings=())
    assert words_ not in said(holdout_rmse_percent_of_range=None)


def test_models_that_were_left_out_are_named_with_the_reason() -> None:
    text = " ".join(words.sentences(example.compared(left_out={"dahl": "tip_mm: turns back"})))
    assert "dahl is left out: tip_mm: turns back." in text
    assert "left out:" not in " ".join(words.sentences(example.compared(left_out={})))


def test_a_comparison_names_the_recommended_model() -> None:
    models = tuple(
        example.model(name, place, recommended=place == 1, reasons=("It is the simplest.",))
        for place, name in enumerate(example.MODELS)
    )
    result = example.compared(models=models)
    assert words.outcome(result).startswith(f"Recommended: {example.MODELS[1]}")
    assert words.best(result) is models[1]
    reason, count, *_ = words.sentences(result)
    assert reason == "It is the simplest."
    assert count == "3 models compared on the same samples; this one: 0.55 % where left out."


def test_errors_that_no_model_has_get_no_column() -> None:
    models = tuple(
        example.model(
            name,
            place,
            holdout_rmse_percent_of_range=None,
            cross_validation_percent_of_range=None if place else 0.35,
        )
        for place, name in enumerate(example.MODELS)
    )
    result = example.compared(models=models)
    assert words.measures(result) == ["Fitted", "Cross-validation"]
    assert [figure.name for figure in words.figures(result)][:3] == [
        "Error",
        "Cross-validation",
        "A straight line leaves",
    ]
    assert words.measures(example.identified()) == ["Fitted", "Held out", "Cross-validation"]


@pytest.mark.parametrize(
    ("inverse", "well_posed", "shown"),
    [
        ("none: it predicts only", False, "none"),
        ("none: it predicts only", True, "none"),
        ("exact", True, "continuous"),
        ("exact", False, "with gaps"),
    ],
)
def test_an_inverse_is_said_in_a_word_or_two(inverse: str, well_posed: bool, shown: str) -> None:
    model = example.model("dahl", inverse=inverse, well_posed=well_posed)
    assert words.inverse(model) == shown


def test_range_and_speeds_are_said_as_far_as_they_are_known() -> None:
    text = said(fitted_range=InputRange(1.0, 99.0, 9.0, 11.5))
    assert "over head_mm from 1 to 99 mm, in strokes of 9 to 11.5 mm a second." in text
    assert "from 1 to 99 mm." in said(fitted_range=InputRange(1.0, 99.0, None, None))
    assert "fitted over" not in said(fitted_range=InputRange(None, None, None, None))


def test_what_each_of_several_inputs_adds_is_said() -> None:
    text = said(coupling_percent_of_range={"jaw_deg": 31.25, "pitch_deg": 4.0})
    assert "the inputs add, RMS: jaw_deg 31.2 %, pitch_deg 4 %." in text
    assert "inputs add" not in said()


@pytest.mark.parametrize(
    ("value", "ends", "shown"),
    [
        (0.123456789, (0.12, 0.13), "0.1235"),
        (0.123456789, (0.1234, 0.1235), "0.123457"),
        (1234.56789, (1000.0, 1500.0), "1235"),
        (0.123456789, None, "0.123457"),
        (0.0, (-0.1, 0.1), "0.00"),
        (None, None, "-"),
    ],
)
def test_values_have_the_digits_that_their_interval_supports(
    value: float | None, ends: tuple[float, float] | None, shown: str
) -> None:
    offset = FittedParameter(value, "mm", ends)
    (row,) = words.parameters(example.model("dahl", parameters={"offset": offset}))
    assert row.value == shown


def printed(result: WorkbenchResult) -> str:
    stream = io.StringIO()
    console = Console(file=stream, width=100)
    identification_words.print_summary(console, result, ["out/report.html"])
    return stream.getvalue()


def test_terminal_shows_parameters_with_intervals_and_files() -> None:
    text = printed(example.identified())
    assert "0.930 to 0.990" in text
    assert "Warning: the residual is not noise" in text
    assert "Written: out/report.html" in text
    assert "not a medical device" in text


def test_terminal_ranks_models() -> None:
    text = printed(example.compared())
    lines = [line for line in text.splitlines() if line.startswith(example.MODELS)]
    assert len(lines) == 3
    assert "recommended" in lines[0]
    assert "Cross-validation" in text
