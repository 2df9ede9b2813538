import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import differential_evolution, minimize
from scipy.stats import norm

from opensuction.hysteresis import play
from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl, simulate
from opensuction.identification.estimator.modified_dahl import fit
from opensuction.kernel.errors import InputError
from tests.hysteresis import distributed_play
from tests.identification.plant import cosine

Array = NDArray[np.float64]


def squares(model: ModifiedDahl, lag_mm: float, head_mm: Array, tip_mm: Array) -> float:
    rest_mm = simulate(model, head_mm, lag_mm) - tip_mm
    return float(rest_mm @ rest_mm)


@settings(max_examples=40)
@given(
    slope=st.floats(0.5, 1.5),
    velocity_gain=st.floats(0.05, 1.0),
    decay_per_range=st.floats(0.8, 100.0),
    offset_mm=st.floats(-20.0, 20.0),
    lag_ratio=st.floats(-1.0, 1.0),
    stroke_mm=st.floats(5.0, 300.0),
)
def test_exact_recordings_give_the_exact_parameters(
    slope: float,
    velocity_gain: float,
    decay_per_range: float,
    offset_mm: float,
    lag_ratio: float,
    stroke_mm: float,
) -> None:
    model = ModifiedDahl(slope, velocity_gain, decay_per_range / stroke_mm, offset_mm)
    lag_mm = lag_ratio * model.velocity_gain / model.decay_per_mm
    head_mm = cosine(2000, stroke_mm=stroke_mm)
    found = fit(head_mm, simulate(model, head_mm, lag_mm))
    # Relative; positions relative to the stroke.
    assert found.model[:3] == pytest.approx(model[:3], rel=1e-6)
    assert found.model.offset_mm == pytest.approx(offset_mm, abs=1e-6 * stroke_mm)
    assert found.lag_mm == pytest.approx(lag_mm, abs=1e-6 * stroke_mm)
    assert found.rmse_mm < 1e-9 * stroke_mm
    assert found.determined
    assert found.well_posed == (slope > 2.0 * found.model.velocity_gain)
    assert found.samples == 2000


def test_the_papers_plant_is_close_to_a_play() -> None:
    # The distributed play nearest to the paper's plant: 40 widths at the quantiles of N(20, 3) mm,
    # gain 0.95, 1 kHz for 40 s. The paper found .9677, .854, .077, -7.151, RMSE .8301 mm.
    widths_mm = 20.0 + 3.0 * norm.ppf((np.arange(40) + 0.5) / 40.0)
    head_mm = cosine(40_000)
    tip_mm = distributed_play.simulate(widths_mm, 0.95, -6.2, head_mm, np.zeros(40))
    found = fit(head_mm, tip_mm)
    assert found.model.slope == pytest.approx(0.968, abs=0.002)
    assert found.model.velocity_gain == pytest.approx(0.80, abs=0.01)
    assert found.model.decay_per_mm == pytest.approx(0.076, abs=0.001)
    assert found.model.offset_mm == pytest.approx(-7.15, abs=0.03)
    assert found.rmse_mm == pytest.approx(0.84, abs=0.01)
    assert not found.well_posed
    assert found.determined


def noisy_plant(seed: int) -> tuple[Array, Array]:
    """A short recording of a plant that is not quite the model, encoder jitter included."""
    random = np.random.default_rng(seed)
    stroke_mm = random.uniform(20.0, 120.0)
    widths_mm = random.uniform(0.05, 0.4) * stroke_mm * random.uniform(0.5, 1.5, 8)
    head_mm = cosine(300, cycles=random.uniform(1.0, 3.0), stroke_mm=stroke_mm)
    head_mm = head_mm + random.normal(0.0, 2e-4 * stroke_mm, head_mm.size)
    start_mm = random.uniform(-0.5, 0.5) * widths_mm
    tip_mm = distributed_play.simulate(widths_mm, 0.9, -5.0, head_mm, start_mm)
    return head_mm, tip_mm + random.normal(0.0, 0.01 * stroke_mm, tip_mm.size)


@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in (2, 3, 4))]
)
def test_never_worse_than_a_global_search_with_refinement(seed: int) -> None:
    head_mm, tip_mm = noisy_plant(seed)
    stroke_mm = float(np.ptp(head_mm))

    def cost(parameters: Array) -> float:
        slope, gain, log_decay, offset, lag = parameters
        model = ModifiedDahl(slope, gain, math.exp(log_decay) / stroke_mm, offset * stroke_mm)
        return squares(model, lag * stroke_mm, head_mm, tip_mm)

    bounds = [(0.1, 4.0), (0.0, 4.0), (math.log(0.05), math.log(1000.0)), (-2.0, 2.0), (-1.0, 1.0)]
    rough = differential_evolution(cost, bounds, seed=seed, maxiter=150, tol=1e-8, polish=False)
    fine = minimize(
        cost,
        rough.x,
        method="Nelder-Mead",
        options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000, "maxfev": 4000},
    )
    found = fit(head_mm, tip_mm)
    mine = squares(found.model, found.lag_mm, head_mm, tip_mm)
    assert mine <= fine.fun * (1.0 + 1e-9)
    assert found.rmse_mm == pytest.approx(math.sqrt(mine / tip_mm.size), rel=1e-9)


def test_no_small_change_of_any_parameter_improves_the_fit() -> None:
    head_mm, tip_mm = noisy_plant(11)
    found = fit(head_mm, tip_mm)
    least = squares(found.model, found.lag_mm, head_mm, tip_mm)
    for place in range(4):
        for share in (-1e-4, 1e-4):
            changed = list(found.model)
            changed[place] *= 1.0 + share
            assert squares(ModifiedDahl(*changed), found.lag_mm, head_mm, tip_mm) > least


@pytest.mark.parametrize("scale", [1e-3, 25.4])
@pytest.mark.parametrize("shift_mm", [0.0, 1e4])
def test_units_and_origin_do_not_matter(scale: float, shift_mm: float) -> None:
    head_mm, tip_mm = noisy_plant(21)
    one = fit(head_mm, tip_mm)
    other = fit(scale * head_mm + shift_mm, scale * tip_mm - 2.0 * shift_mm)
    # 1e4 mm cost four of sixteen digits of a stroke; in millimetres the loss is absolute.
    tolerance = 1e-6
    assert other.model.slope == pytest.approx(one.model.slope, rel=tolerance)
    assert other.model.velocity_gain == pytest.approx(one.model.velocity_gain, rel=tolerance)
    assert other.model.decay_per_mm == pytest.approx(one.model.decay_per_mm / scale, rel=tolerance)
    assert other.lag_mm == pytest.approx(scale * one.lag_mm, rel=tolerance)
    assert other.rmse_mm == pytest.approx(scale * one.rmse_mm, rel=tolerance)
    shifted_mm = scale * one.model.offset_mm - 2.0 * shift_mm - one.model.slope * shift_mm
    assert other.model.offset_mm == pytest.approx(shifted_mm, rel=tolerance)


def test_mirrored_recordings_give_mirrored_models() -> None:
    head_mm, tip_mm = noisy_plant(22)
    one, other = fit(head_mm, tip_mm), fit(-head_mm, -tip_mm)
    assert other.model[:3] == pytest.approx(one.model[:3], rel=1e-7)
    assert other.model.offset_mm == pytest.approx(-one.model.offset_mm, rel=1e-7)
    assert other.lag_mm == pytest.approx(-one.lag_mm, rel=1e-6)


def test_a_dense_recording_with_many_small_turns_is_not_thinned_wrongly() -> None:
    random = np.random.default_rng(4)
    head_mm = cosine(20_000) + 3.0 * np.sin(np.linspace(0.0, 4000.0, 20_000))
    tip_mm = simulate(PUBLISHED, head_mm, 2.0) + random.normal(0.0, 0.1, head_mm.size)
    found = fit(head_mm, tip_mm)
    # Five standard errors at 20,000 samples are near 0.2 % of each.
    assert found.model[:3] == pytest.approx(PUBLISHED[:3], rel=3e-3)


def test_a_flat_ridge_is_reported() -> None:
    # Cycles of 1 mm around a decay of 50 mm show only that slope minus gain is .1 or so.
    head_mm = cosine(2000, stroke_mm=1.0)
    tip_mm = simulate(ModifiedDahl(0.9677, 0.5, 0.02, 0.0), head_mm, 0.0)
    tip_mm += np.random.default_rng(1).normal(0.0, 0.01, tip_mm.size)
    found = fit(head_mm, tip_mm)
    assert not found.determined
    assert found.rmse_mm == pytest.approx(0.01, rel=0.1)


def test_a_reversal_too_sharp_to_see_is_reported() -> None:
    head_mm = cosine(2000)
    gain = 1.0e4  # all of a gap of 2 mm within a micrometre
    tip_mm = simulate(ModifiedDahl(0.9677, gain, 1.0e4, 0.0), head_mm, 0.0)
    assert not fit(head_mm, tip_mm).determined


@pytest.mark.parametrize("noise_mm", [0.0, 0.1])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_recording_without_hysteresis_gives_the_line(noise_mm: float, seed: int) -> None:
    head_mm = cosine(2000)
    noise = np.random.default_rng(seed).normal(0.0, noise_mm, head_mm.size)
    found = fit(head_mm, 0.9 * head_mm + 1.0 + noise)
    assert not found.determined
    reach_mm = simulate(found.model, head_mm, found.lag_mm) - 0.9 * head_mm - 1.0
    assert np.abs(reach_mm).max() <= 1e-9 + 0.3 * noise_mm


def test_a_tip_that_leads_its_head_gets_no_negative_gain() -> None:
    head_mm = cosine(2000)
    found = fit(play.simulate(10.0, head_mm, 0.0), head_mm)
    assert found.model.velocity_gain == 0.0
    assert not found.determined


HEAD = cosine(200)
TIP = simulate(PUBLISHED, HEAD, 0.0)


def spoilt(record: Array, place: int, value: float) -> Array:
    copy = record.copy()
    copy[place] = value
    return copy


@pytest.mark.parametrize(
    ("head_mm", "tip_mm", "says"),
    [
        (spoilt(HEAD, 7, math.nan), TIP, r"head_mm: sample 7 is nan \(1 such in 200\)"),
        (HEAD, spoilt(TIP, 3, math.inf), "tip_mm: sample 3 is inf"),
        (HEAD[:5], TIP[:5], "head_mm: 5 samples, at least 12"),
        (HEAD, TIP[:-1], "head_mm has 200 samples, tip_mm 199"),
        (HEAD.reshape(2, 100), TIP, r"head_mm: shape \(2, 100\)"),
        (np.full(200, 4.0), TIP, "head_mm: constant at 4"),
        (HEAD, np.zeros(200), "tip_mm: constant at 0"),
        (np.linspace(0.0, 50.0, 200), TIP, "head_mm: reverses by 0 of a range of 50"),
        (HEAD, -TIP, r"tip_mm: moves against head_mm \(slope -.*negate one"),
        (["a"] * 200, TIP, "head_mm: not a row of numbers"),
    ],
)
def test_bad_recordings_are_refused_in_one_line(head_mm: Array, tip_mm: Array, says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        fit(head_mm, tip_mm)
    assert "\n" not in str(refused.value)


def test_the_recording_is_not_changed_and_may_be_a_slice_or_whole_numbers() -> None:
    head_mm, tip_mm = HEAD.copy(), TIP.copy()
    strided = np.stack([head_mm, tip_mm], axis=1)
    assert fit(strided[:, 0], strided[:, 1]) == fit(head_mm, tip_mm)
    assert np.array_equal(head_mm, HEAD)
    assert np.array_equal(tip_mm, TIP)
    counts = [round(value) for value in head_mm.tolist()]
    assert fit(counts, tip_mm).model.slope == pytest.approx(PUBLISHED.slope, rel=0.05)
