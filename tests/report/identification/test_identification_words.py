import io

import pytest
from rich.console import Console

from opensuction.report.identification import identification_terminal
from opensuction.report.identification import identification_words as words
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


@pytest.mark.parametrize("ends", [None, [-0.1, 1.7]])
def test_a_gap_that_is_not_determined_has_no_figure(ends: list[float] | None) -> None:
    parameters = example.identified()["parameters"]
    gain = parameters["velocity_gain"] | {"ci95": ends}
    assert "apart" not in said(parameters=parameters | {"velocity_gain": gain})


def test_what_is_not_determined_has_no_gap_whatever_its_intervals() -> None:
    assert "apart" in said(determined=True)
    assert "apart" not in said(determined=False)


def test_a_column_without_a_unit_gives_figures_without_one() -> None:
    recording = example.provenance()["recording"]
    recording["output"] = {"column": "pos (5)", "unit": "", "negated": False}
    text = said(recording=recording, rmse=24.79, rmse_unit="output")
    assert "an error of 24.79 RMSE" in text
    assert "lie 20 apart" in text
    assert "output" not in text.replace("output's range", "")


def test_warnings_are_said_to_be_of_the_fitted_part() -> None:
    words_ = "Warnings are about what comes before, unless they say otherwise."
    assert words_ in said()
    assert words_ not in said(warnings=[])
    assert words_ not in said(holdout_rmse_percent_of_range=None)


def test_models_that_were_left_out_are_named_with_the_reason() -> None:
    text = " ".join(words.sentences(example.compared(left_out={"dahl": "tip_mm: turns back"})))
    assert "dahl is left out: tip_mm: turns back." in text
    assert "left out:" not in " ".join(words.sentences(example.compared(left_out={})))


def test_a_comparison_names_the_recommended_model() -> None:
    models = [
        example.model(name, place, recommended=place == 1)
        for place, name in enumerate(example.MODELS)
    ]
    summary = example.compared(models=models)
    assert words.outcome(summary).startswith(f"Recommended: {example.MODELS[1]}")
    assert "3 models compared" in words.sentences(summary)[0]


@pytest.mark.parametrize(
    ("value", "ends", "shown"),
    [
        (0.123456789, [0.12, 0.13], "0.1235"),
        (0.123456789, [0.1234, 0.1235], "0.123457"),
        (1234.56789, [1000.0, 1500.0], "1235"),
        (0.123456789, None, "0.123457"),
        (0.0, [-0.1, 0.1], "0.00"),
    ],
)
def test_values_have_the_digits_that_their_interval_supports(
    value: float, ends: list[float] | None, shown: str
) -> None:
    entry = {"value": value, "unit": "mm", "ci95": ends}
    (row,) = words.parameters(example.identified(parameters={"offset": entry}))
    assert row.value == shown


def printed(summary: dict[str, object]) -> str:
    stream = io.StringIO()
    console = Console(file=stream, width=100)
    identification_terminal.print_summary(console, summary, ["out/report.html"])
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
