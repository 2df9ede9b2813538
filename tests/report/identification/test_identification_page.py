import re
from typing import Any

import pytest

from opensuction.report.identification import identification_page as page
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
    html = alone(warnings=["the decay is not determined"])
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
    models = [example.model(name, place) for place, name in enumerate(example.MODELS)]
    models[2] |= {"rmse_percent_of_range": 12.0}  # a straight line leaves 9.8
    html = page.render(example.compared(models=models), example.curves())
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
    recording = example.provenance()["recording"] | {"file": attack}
    recording["input"] = {"column": attack, "unit": attack, "negated": False}
    html = alone(recording=recording, warnings=[attack])
    assert attack not in html


@pytest.mark.parametrize("key", sorted(example.identified()))
def test_any_key_may_be_null_or_missing(key: str) -> None:
    curves = example.curves(example.MODELS[:1])
    without = {name: entry for name, entry in example.identified().items() if name != key}
    if key == "model":  # names the curves
        return
    for summary in (example.identified(**{key: None}), without):
        assert "None" not in page.render(summary, curves).split("<script")[0]
