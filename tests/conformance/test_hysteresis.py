"""Properties of every hysteresis model; compiled code equals plain Python."""

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.hysteresis import modified_dahl, play
from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl
from tests.conformance.plain import run_plain
from tests.hysteresis import distributed_play

Array = NDArray[np.float64]

WIDTHS_MM = np.array([14.0, 18.5, 20.0, 21.5, 26.0])
MONOTONE = ModifiedDahl(slope=0.95, velocity_gain=0.3, decay_per_mm=0.1, offset_mm=-2.0)


class Model(NamedTuple):
    """A hysteresis model from two starts at head 0: after a long retract, and a long advance."""

    after_retract: Callable[[Array], Array]
    after_advance: Callable[[Array], Array]
    forgetting_mm: float
    """Head travel in one direction that leaves less than 1e-9 mm of the start."""


def _dahl(model: ModifiedDahl) -> Model:
    saturation_mm = model.velocity_gain / model.decay_per_mm
    return Model(
        lambda head_mm: modified_dahl.simulate(model, head_mm, saturation_mm),
        lambda head_mm: modified_dahl.simulate(model, head_mm, -saturation_mm),
        # The difference of the lags decays with alpha from 22 mm at most: ln(22/1e-9) = 23.8.
        24.0 / model.decay_per_mm,
    )


MODELS = {
    "modified_dahl, published": _dahl(PUBLISHED),
    "modified_dahl, monotone": _dahl(MONOTONE),
    "play": Model(
        lambda head_mm: play.simulate(20.0, head_mm, 10.0),
        lambda head_mm: play.simulate(20.0, head_mm, -10.0),
        20.0,
    ),
    "distributed play": Model(
        lambda head_mm: distributed_play.simulate(
            WIDTHS_MM, 0.95, -6.2, head_mm, distributed_play.retracted_positions_mm(WIDTHS_MM, 0.0)
        ),
        lambda head_mm: distributed_play.simulate(WIDTHS_MM, 0.95, -6.2, head_mm, -0.5 * WIDTHS_MM),
        26.0,
    ),
}

every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS.keys())

paths = st.lists(st.floats(-150.0, 150.0), min_size=2, max_size=12).map(
    lambda turns: np.array([0.0, *turns])
)


@every_model
@given(path_mm=paths, parts=st.integers(2, 9))
def test_how_finely_a_move_is_sampled_does_not_matter(
    model: Model, path_mm: Array, parts: int
) -> None:
    fine_mm = np.concatenate(
        [np.linspace(a, b, parts, endpoint=False) for a, b in pairwise(path_mm)] + [path_mm[-1:]]
    )
    # A few roundings of numbers around 150.
    assert model.after_retract(fine_mm)[::parts] == pytest.approx(
        model.after_retract(path_mm), abs=1e-11
    )


@every_model
@given(path_mm=paths)
def test_standing_still_changes_nothing(model: Model, path_mm: Array) -> None:
    waiting = model.after_retract(np.repeat(path_mm, 3))
    assert np.array_equal(waiting, np.repeat(model.after_retract(path_mm), 3))


@every_model
@given(path_mm=paths)
def test_a_long_stroke_forgets_the_start(model: Model, path_mm: Array) -> None:
    stroke_mm = np.append(path_mm, path_mm[-1] + model.forgetting_mm)
    tips_mm = model.after_retract(stroke_mm)[-1], model.after_advance(stroke_mm)[-1]
    assert tips_mm[0] == pytest.approx(tips_mm[1], abs=2e-9)


@every_model
@given(path_mm=paths)
def test_a_start_after_a_retract_lies_on_or_above_one_after_an_advance(
    model: Model, path_mm: Array
) -> None:
    apart_mm = model.after_retract(path_mm) - model.after_advance(path_mm)
    assert apart_mm.min() >= -1e-11
    assert apart_mm[0] > 0.0


@every_model
def test_the_record_given_is_not_changed(model: Model) -> None:
    path_mm = np.array([0.0, 30.0, -10.0])
    model.after_retract(path_mm)
    assert path_mm.tolist() == [0.0, 30.0, -10.0]


def results() -> dict[str, list[float]]:
    """Every public function of the room over a spread of arguments."""
    path_mm = 50.0 * (1.0 - np.cos(np.linspace(0.0, 12.0, 240)))
    values: dict[str, list[float]] = {
        name: [*model.after_retract(path_mm), *model.after_advance(path_mm)]
        for name, model in MODELS.items()
    }
    for name, model in (("published", PUBLISHED), ("monotone", MONOTONE)):
        values[name] = [
            modified_dahl.saturation_mm(model),
            modified_dahl.gap_mm(model),
            modified_dahl.reversal_slope(model),
            float(modified_dahl.is_monotone(model)),
        ]
        for lag_mm in (-15.0, -11.0, 0.0, 3.0, 11.0):
            for direction in (-1.0, 1.0):
                values[name] += [
                    modified_dahl.step(model, lag_mm, direction * 0.37),
                    modified_dahl.output_mm(model, 12.5, lag_mm),
                    modified_dahl.advance_slope(model, lag_mm, direction),
                    modified_dahl.gap_move(model, lag_mm, direction),
                    *(
                        modified_dahl.move_to(model, 12.5, lag_mm, target_mm, direction)
                        for target_mm in (-40.0, 4.0, 9.0, 60.0)
                    ),
                ]
    values["play"] += [play.step(20.0, 3.0, head_mm) for head_mm in (-40.0, 4.0, 40.0)]
    positions_mm = np.zeros(5)
    values["play"] += [distributed_play.step(WIDTHS_MM, positions_mm, 13.0), *positions_mm]
    return {name: [float(value) for value in row] for name, row in values.items()}


def test_compiled_equals_plain_python() -> None:
    plain = run_plain("tests.conformance.test_hysteresis", "results")
    assert isinstance(plain, dict)
    compiled = results()
    assert plain.keys() == compiled.keys()
    for name, row in compiled.items():
        # Same library functions; a fused multiply-add may differ in the last bit and then add up.
        assert row == pytest.approx(plain[name], rel=1e-12, abs=1e-12), name
