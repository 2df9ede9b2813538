import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl, simulate
from opensuction.identification import workbench
from opensuction.identification.estimator import nonlinear
from opensuction.identification.judgement.diagnosis import Labels
from opensuction.identification.workbench import (
    METHODS,
    MODELS,
    FittedModel,
    compare,
    identify,
    methods_of,
)
from opensuction.kernel.errors import InputError
from tests.identification.plant import paper_plant

Array = NDArray[np.float64]

HEAD = 50.0 * (1.0 - np.cos(np.linspace(0.0, 8.0 * math.pi, 1200)))
TIP = simulate(PUBLISHED, HEAD, 2.0)


def test_the_second_half_is_predicted_not_fitted() -> None:
    spoilt = TIP.copy()
    spoilt[600:] += 3.0
    found = identify(HEAD, spoilt, holdout_ratio=0.5)
    assert found.fitted_samples == 600
    assert found.fitted == pytest.approx(TIP, abs=1e-6)
    assert found.rmse == pytest.approx(0.0, abs=1e-6)
    percent = 100.0 * 3.0 / float(np.ptp(spoilt))
    assert found.holdout_rmse_percent_of_range == pytest.approx(percent, rel=1e-6)


def test_nothing_held_out_has_no_holdout_score() -> None:
    found = identify(HEAD, TIP)
    assert math.isnan(found.holdout_rmse_percent_of_range)
    assert found.fitted_samples == found.samples == 1200


def test_units_are_the_callers() -> None:
    labels = Labels("spindle_deg", "jaw_deg", "deg", "counts")
    found = identify(HEAD, TIP, labels=labels)
    assert found.parameters["slope"].unit == "counts/deg"
    assert found.parameters["offset"].unit == "counts"
    with pytest.raises(InputError, match=r"spindle_deg has 1200 samples, jaw_deg 1199"):
        identify(HEAD, TIP[:-1], labels=labels)


@pytest.mark.parametrize(
    ("model", "method", "holdout_ratio", "says"),
    [
        ("dahll", None, 0.0, "model 'dahll' is not known: one of "),
        ("modified-dahl", "luck", 0.0, "method 'luck' is not known: one of "),
        ("modified-dahl", None, 0.95, "holdout 0.95: should be from 0 to 0.9"),
        ("modified-dahl", None, math.nan, "holdout nan"),
    ],
)
def test_impossible_choices_are_refused_in_one_line(
    model: str, method: str | None, holdout_ratio: float, says: str
) -> None:
    with pytest.raises(InputError, match=says) as refused:
        identify(HEAD, TIP, None, model, method, holdout_ratio)
    assert "\n" not in str(refused.value)


def test_the_page_names_every_model_with_its_methods() -> None:
    page = Path(__file__).parents[2] / "docs" / "explanations" / "identification.md"
    text = page.read_text(encoding="utf-8")
    for name, model in MODELS.items():
        methods = methods_of(model)
        assert set(methods) <= set(METHODS)
        listed = ", ".join(f"`{method}`" for method in methods)
        assert f"| `{name}` | {model.summary} | {listed} |" in text
    assert set(METHODS) == {method for model in MODELS.values() for method in methods_of(model)}


NOISE = np.random.default_rng(1).normal(0.0, 0.1, HEAD.size)
TIME_S = 0.01 * np.arange(HEAD.size)


class Compared(NamedTuple):
    """All models of the backlash in noise, and what was told meanwhile."""

    results: list[FittedModel]
    told: list[tuple[str, int, int]]


@pytest.fixture(scope="module")
def compared() -> Compared:
    told: list[tuple[str, int, int]] = []
    tip = TIP + NOISE
    results = compare(HEAD, tip, TIME_S, 0.25, progress=lambda *step: told.append(step))
    return Compared(results, told)


def _each(models: list[str], long_ones: tuple[str, ...]) -> list[object]:
    """These models; those of a large grid, which take seconds, in the long runs."""
    return [
        pytest.param(one, marks=pytest.mark.soak) if one in long_ones else one for one in models
    ]


def test_one_of_the_compared_models_is_recommended(compared: Compared) -> None:
    assert [result.recommended for result in compared.results].count(True) == 1
    assert [name for name, *_ in compared.told] == list(MODELS)
    assert {result.model for result in compared.results} == set(MODELS)


@pytest.mark.parametrize("model", MODELS)
def test_every_model_follows_a_backlash(compared: Compared, model: str) -> None:
    (found,) = [result for result in compared.results if result.model == model]
    # A line leaves 8 % of the range; Dahl has no line and does not even reach that.
    bound = {"dahl": 15.0, "preisach": 3.0, "prandtl-ishlinskii": 2.0}.get(model, 0.7)
    assert found.rmse_percent_of_range < bound
    assert found.holdout_rmse_percent_of_range < bound
    assert found.fitted.shape == HEAD.shape


@pytest.mark.parametrize("model", _each(list(MODELS), ("preisach", "play-readout")))
def test_every_model_repeats_itself(compared: Compared, model: str) -> None:
    (found,) = [result for result in compared.results if result.model == model]
    again = identify(HEAD, TIP + NOISE, TIME_S, model, None, 0.25)
    assert repr(again.parameters) == repr(found.parameters)  # nan is not equal to itself


def test_the_true_model_is_recommended_and_its_intervals_hold(compared: Compared) -> None:
    best = compared.results[0]
    assert best.recommended
    assert best.model == "modified-dahl"
    truth = {"slope": PUBLISHED.slope, "velocity_gain": PUBLISHED.velocity_gain, "initial_lag": 2.0}
    for name, value in truth.items():
        assert best.parameters[name].low < value < best.parameters[name].high
    assert any(warning.startswith("Not invertible") for warning in best.warnings)


def test_on_the_papers_excitation_bouc_wen_is_at_or_below_modified_dahl() -> None:
    head_mm, tip_mm = paper_plant(8000)
    paper = identify(head_mm, tip_mm, model="modified-dahl")
    # The paper: .8301 mm and .8009 mm.
    assert paper.rmse == pytest.approx(0.83, abs=0.05)
    assert identify(head_mm, tip_mm, model="bouc-wen").rmse <= paper.rmse


UNEVEN_S = TIME_S + np.where(np.arange(HEAD.size) > 600, 0.5, 0.0)


@pytest.mark.parametrize(
    ("head", "tip", "time_s", "says"),
    [
        (HEAD[:400], TIP[:400], None, "Too few reversals: input turns twice by"),
        (np.round(HEAD / 4.0), TIP, None, "Range too small: input covers 25 steps"),
        (HEAD, np.minimum(TIP, 60.0), None, "Clipped: output stays at its highest value"),
        (HEAD, TIP, UNEVEN_S, "Uneven sampling: intervals from 0.01 to 0.51 s"),
        (HEAD, 0.9 * HEAD + NOISE, None, "Not determined"),
        (0.01 * HEAD, TIP[::-1] * 0.0 + 0.009 * HEAD + NOISE, None, "Uncertain: the interval of"),
        (HEAD, TIP + np.cumsum(NOISE), None, "Neighbouring residuals are alike"),
    ],
)
def test_weak_recordings_are_named_in_plain_words(
    head: Array, tip: Array, time_s: Array | None, says: str
) -> None:
    found = identify(head, tip, time_s)
    assert any(warning.startswith(says) for warning in found.warnings), found.warnings


def test_a_good_recording_of_an_invertible_model_has_no_warning() -> None:
    model = ModifiedDahl(1.0, 0.3, 0.1, 0.0)
    assert identify(HEAD, simulate(model, HEAD, 1.0) + NOISE, TIME_S).warnings == ()


STEADY = np.full(HEAD.size, 50.0)


@pytest.mark.parametrize(
    ("head", "tip", "says"),
    [
        (STEADY, 40.0 + NOISE, "input: constant at 50"),
        (STEADY + 0.1 * NOISE, 40.0 + NOISE, "input: trembles within"),
        (np.minimum(HEAD, 50.0)[:100], TIP[:100], "input: reverses by 0 of a range"),
        (1e300 * HEAD, TIP, r"input: sample 150 is 9\.99998e\+301, beyond 1e\+30; correct it"),
        (HEAD, 1e-200 * TIP, "output: moves within 8.* less than 1e-30; record in a smaller unit"),
        (HEAD, -TIP, "output: moves against input .* negate one of them"),
    ],
)
def test_recordings_that_cannot_tell_are_refused(head: Array, tip: Array, says: str) -> None:
    for run in (compare, identify):
        with pytest.raises(InputError, match=says) as refused:
            run(head, tip)
        assert "\n" not in str(refused.value)


NOT_REFUSED = [one for one in MODELS if one != "dahl"]
"""Models that noise identifies at all: the other one finds it turned against the input."""


@pytest.mark.parametrize("model", _each(NOT_REFUSED, ("preisach", "play-readout", "bouc-wen")))
def test_an_output_of_noise_is_said_to_mean_nothing(model: str) -> None:
    result = identify(HEAD, 40.0 + NOISE, model=model)
    assert any("its parameters mean nothing" in warning for warning in result.warnings)


@pytest.mark.soak
def test_units_and_origin_change_no_score() -> None:
    one = compare(HEAD, TIP + NOISE, holdout_ratio=0.25)
    other = compare(1e-6 * HEAD + 7.0, 1e3 * (TIP + NOISE) - 50.0, holdout_ratio=0.25)
    scores = {each.model: each.cross_validation_percent_of_range for each in one}
    for each in other:
        assert each.cross_validation_percent_of_range == pytest.approx(scores[each.model], rel=0.02)


def test_a_time_that_goes_back_is_refused() -> None:
    back = TIME_S.copy()
    back[7] = back[5]
    with pytest.raises(InputError, match="time: does not advance at sample 7"):
        identify(HEAD, TIP, back)


def test_too_little_left_to_fit_is_refused() -> None:
    with pytest.raises(InputError, match="leaves 20 of 200 samples to fit, at least 40"):
        identify(HEAD[:200], TIP[:200], holdout_ratio=0.9)


OTHER = 12.0 * np.sin(np.linspace(0.0, 31.0, HEAD.size))
COUPLED = TIP - 0.3 * OTHER + NOISE
NAMED = Labels("head_mm", "tip_mm", other_names=("bend_deg",))


@pytest.mark.soak
def test_several_inputs_are_followed_together_and_what_each_adds_is_told() -> None:
    one, *_ = compare(HEAD, COUPLED, TIME_S, 0.25, NAMED)
    found, *rest = compare(np.array([HEAD, OTHER]), COUPLED, TIME_S, 0.25, NAMED)
    assert found.model == "play-readout"
    assert found.recommended
    assert found.holdout_rmse_percent_of_range < 0.3 * one.holdout_rmse_percent_of_range
    assert list(found.coupling_percent_of_range) == ["head_mm", "bend_deg"]
    percent = 100.0 * float((0.3 * OTHER).std()) / float(np.ptp(COUPLED))
    assert found.coupling_percent_of_range["bend_deg"] == pytest.approx(percent, rel=0.15)
    assert any(name.startswith("bend_deg: gain_") for name in found.parameters)
    assert all(each.coupling_percent_of_range == {} for each in rest)


def test_another_column_that_explains_what_is_left_is_named() -> None:
    beside = {"bend_deg": OTHER, "noise": NOISE[::-1], "constant": np.ones(HEAD.size)}
    found = identify(HEAD, COUPLED, TIME_S, beside=beside)
    said = [warning for warning in found.warnings if warning.startswith("Another input")]
    assert len(said) == 1
    assert "column 'bend_deg' explains 9" in said[0]
    assert not any(
        warning.startswith("Another input")
        for warning in identify(HEAD, TIP + NOISE, TIME_S, beside=beside).warnings
    )


@pytest.mark.parametrize(
    ("others", "model", "says"),
    [
        (
            [OTHER],
            "bouc-wen",
            "model 'bouc-wen' follows one input, not 2: take model 'play-readout'",
        ),
        ([OTHER[:-1]], "play-readout", "bend_deg has 1199 samples, tip_mm 1200"),
        ([np.full(HEAD.size, 3.0)], "play-readout", "bend_deg: constant at 3, should move"),
    ],
)
def test_inputs_that_do_not_do_are_refused(others: list[Array], model: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        identify([HEAD, *others], COUPLED, model=model, labels=NAMED)
    assert "\n" not in str(refused.value)


def test_a_warning_about_the_fitted_part_alone_says_so() -> None:
    assert not any("Too few" in said for said in identify(HEAD, TIP).warnings)
    found = identify(HEAD, TIP, holdout_ratio=0.7)
    (said,) = [each for each in found.warnings if "Too few reversals" in each]
    assert said.endswith(
        "That is of the fitted part, the first 360 of 1200 samples, not of the whole."
    )
    coarse = identify(np.round(HEAD, -1), TIP, holdout_ratio=0.5)
    (said,) = [each for each in coarse.warnings if "Range too small" in each]
    assert said.endswith("are needed.")  # the whole is as coarse


def test_a_refusal_of_the_fitted_part_alone_says_so() -> None:
    with pytest.raises(InputError, match=r"reverses by .* first 120 of 1200 .* lower --holdout"):
        identify(HEAD, TIP, holdout_ratio=0.9)


def test_a_model_that_is_left_out_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise InputError("tip_mm: turns against head_mm; negate one of them")

    monkeypatch.setitem(nonlinear.FITS, "dahl", refuse)
    few = ("modified-dahl", "dahl", "prandtl-ishlinskii")
    monkeypatch.setattr(workbench, "MODELS", {name: MODELS[name] for name in few})
    best, *others = compare(HEAD[:300], TIP[:300] + NOISE[:300])
    assert best.left_out == (("dahl", "tip_mm: turns against head_mm; negate one of them"),)
    assert {each.model for each in (best, *others)} == {"modified-dahl", "prandtl-ishlinskii"}
    assert all(each.left_out == () for each in others)
