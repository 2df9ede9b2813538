import re
from types import NoneType
from typing import Any, get_args, get_type_hints

import pytest

from opensuction.report.identification import identification_page as page
from opensuction.result.identification_result import (
    FittedParameter,
    IdentifiedRecording,
    InputRange,
    ModelResult,
    RecordedColumn,
)
from tests.report import identification_example as example
from tests.report.page_data import payload


def alone(**changes: Any) -> str:
    return page.render(example.identified(**changes), example.curves(example.MODELS[:1]))


def test_page_needs_nothing_from_elsewhere_and_is_small() -> None:
    html = page.render(example.compared(), example.curves())
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:|#)""", html)
    assert len(html.encode()) < 1_000_000


def test_page_is_small_for_a_long_recording() -> None:
    html = page.render(example.compared(), example.curves(samples=400_000))
    assert len(html.encode()) < 1_000_000


def test_parameters_stand_with_unit_and_interval() -> None:
    assert re.search(r"velocity_gain.*?0\.800.*?mm/mm.*?0\.780 to 0\.830", alone(), re.S)
    assert "not a medical device" in alone()


def test_warnings_and_provenance_are_on_the_page() -> None:
    html = alone(warnings=("the decay is not determined",))
    assert "the decay is not determined" in html
    assert "0123456789abcdef" * 4 in html
    assert "bench.csv" in html


def test_comparison_ranks_and_marks_what_is_recommended() -> None:
    html = page.render(example.compared(), example.curves())
    ranking = html[html.index('id="ranking"') :]
    places = [ranking.index(name) for name in example.MODELS]
    assert places == sorted(places)
    assert html.count(">recommended<") == 1
    shown = [model["name"] for model in payload(html)["models"] if model["shown"]]
    assert shown == [example.MODELS[0]]


def test_a_model_worse_than_a_line_does_not_shrink_the_others_bars() -> None:
    *others, last = example.compared().models
    worst = last._replace(rmse_percent_of_range=12.0)  # a straight line leaves 9.8
    html = page.render(example.compared(models=(*others, worst)), example.curves())
    widths = [float(width) for width in re.findall(r'<i style="width: ([0-9.]+)%', html)]
    assert max(widths) == 100.0
    assert widths[0] == pytest.approx(100.0 * 0.3 / 0.8, abs=0.01)  # 0.8: worst that beats it


def test_one_model_has_no_ranking() -> None:
    assert 'id="ranking"' not in alone()
    assert 'id="chips"' not in alone()


def test_nothing_held_out_is_not_shaded_and_not_claimed() -> None:
    curves = example.curves(example.MODELS[:1])._replace(fitted_samples=example.SAMPLES)
    summary = example.identified(holdout_rmse_percent_of_range=None)
    html = page.render(summary, curves)
    assert payload(html)["held_from"] is None
    assert "held out" not in html.split("<script")[0].replace("Held out", "")


def test_text_from_a_recording_is_never_markup() -> None:
    attack = "</script><script>alert(1)</script>"
    column = RecordedColumn(attack, attack, False, 0.0, 1.0)
    result = example.identified(warnings=(attack,))._replace(
        provenance=example.provenance(file=attack, input=column)
    )
    assert attack not in page.render(result, example.curves(example.MODELS[:1]))


def test_provenance_is_every_field_of_the_recording_by_its_key() -> None:
    table = alone().split("<caption>Recording</caption>")[1].split("</table>")[0]
    rows = re.findall(r"<code>(.*?)</code></th><td>(.*?)</td>", table)
    assert [name for name, _ in rows[:2]] == ["file", "sha256"]
    shown = dict(rows)
    assert shown["output.column"] == "tip_mm"
    assert shown["output.negated"] == "no"
    assert shown["fitted_samples"] == "2800"
    assert shown["holdout_ratio"] == "0.3"


def may_be_none(record: type) -> list[str]:
    """Fields that hold None where something was not measured."""
    return [name for name, hint in get_type_hints(record).items() if NoneType in get_args(hint)]


@pytest.mark.parametrize("field", may_be_none(ModelResult))
def test_what_was_not_measured_of_a_model_is_not_shown_as_none(field: str) -> None:
    html = alone(**{field: None})
    assert "None" not in html.split("<script")[0]


@pytest.mark.parametrize("field", may_be_none(IdentifiedRecording))
def test_what_is_not_known_of_a_recording_is_not_shown_as_none(field: str) -> None:
    result = example.identified()._replace(provenance=example.provenance(**{field: None}))
    html = page.render(result, example.curves(example.MODELS[:1]))
    assert "None" not in html.split("<script")[0]


def test_nothing_measured_at_all_still_makes_a_page() -> None:
    nothing = dict.fromkeys(may_be_none(ModelResult)) | {
        "parameters": {"slope": FittedParameter(None, "mm/mm", None)},
        "fitted_range": InputRange(None, None, None, None),
        "warnings": (),
    }
    result = example.identified(**nothing)
    where = result.provenance._replace(line_rmse_percent_of_range=None)
    html = page.render(result._replace(provenance=where), example.curves(example.MODELS[:1]))
    assert "None" not in html.split("<script")[0]
    assert "modified-dahl: error - of the range" in html
