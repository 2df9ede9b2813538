"""Inputs and speeds that a model was fitted to, and what leaves them."""

import math

import numpy as np
import pytest

from opensuction.identification import workbench
from opensuction.identification.judgement import fitted_range
from opensuction.identification.judgement.diagnosis import Labels
from opensuction.kernel.record import Array

LABELS = Labels("head_mm", "tip_mm", "mm", "mm", "time_s")
PERIOD_S = 0.01


def strokes(ends: list[float], speeds: list[float]) -> tuple[Array, Array]:
    """A path from 0 through the ends, each reached at its speed; and its times."""
    marks = [0.0, *ends]
    seconds = np.cumsum([0.0, *(np.abs(np.diff(marks)) / np.array(speeds))])
    time_s = np.arange(0.0, seconds[-1] + 0.5 * PERIOD_S, PERIOD_S)
    return np.interp(time_s, seconds, marks), time_s


def follow(head: Array) -> Array:
    """A play of 6 mm, with a little noise of a known seed."""
    tip, at = np.empty(head.size), head[0]
    for k, place in enumerate(head):
        at = min(max(at, place - 3.0), place + 3.0)
        tip[k] = at
    return tip + 0.02 * np.random.default_rng(3).standard_normal(head.size)


def test_ends_and_speeds_of_whole_strokes() -> None:
    head, time_s = strokes([40.0, 10.0, 60.0, 20.0, 30.0], [8.0, 5.0, 20.0, 10.0, 1.0])
    found = fitted_range.measure(head, time_s)
    assert (found.lowest, found.highest) == pytest.approx((0.0, 60.0), abs=0.2)
    # The first and the last stroke are parts of some.
    assert (found.slowest, found.fastest) == pytest.approx((5.0, 20.0), rel=0.01)


def test_one_stroke_and_back_has_the_speeds_of_both() -> None:
    head, time_s = strokes([40.0, 0.0], [8.0, 4.0])
    found = fitted_range.measure(head, time_s)
    assert (found.slowest, found.fastest) == pytest.approx((4.0, 8.0), rel=0.01)


def test_without_times_no_speed_is_known() -> None:
    head, _ = strokes([40.0, 0.0], [8.0, 4.0])
    found = fitted_range.measure(head, None)
    assert math.isnan(found.slowest)
    assert math.isnan(found.fastest)
    assert fitted_range.judge_beyond(found, 2.0 * head, None, LABELS)[0].startswith("Beyond the")


@pytest.mark.parametrize(
    ("ends", "speeds", "said"),
    [
        ([40.0, 0.0, 40.0, 0.0], [8.0] * 4, ()),
        ([40.5, -0.5, 40.0, 0.0], [11.0] * 4, ()),
        ([60.0, 0.0, 40.0, 0.0], [8.0] * 4, ("Beyond the fitted range: ",)),
        ([40.0, 0.0, 40.0, 0.0], [13.0] * 4, ("Beyond the fitted speeds: ",)),
        ([40.0, 0.0, 40.0, 0.0], [5.0] * 4, ("Beyond the fitted speeds: ",)),
        ([60.0, 0.0, 60.0, 0.0], [30.0] * 4, ("Beyond the fitted range: ", "Beyond the fitted sp")),
    ],
)
def test_what_leaves_them_is_told_by_name(
    ends: list[float], speeds: list[float], said: tuple[str, ...]
) -> None:
    fitted = fitted_range.measure(*strokes([40.0, 0.0, 40.0, 0.0], [8.0] * 4))
    told = fitted_range.judge_beyond(fitted, *strokes(ends, speeds), LABELS)
    assert len(told) == len(said)
    for sentence, begin in zip(told, said, strict=True):
        assert sentence.startswith(begin)
        assert "mm" in sentence
        assert "\n" not in sentence


def test_a_result_says_them_and_does_not_blame_the_plant() -> None:
    slow, clock = strokes([40.0, 0.0] * 4, [8.0] * 8)
    fast, _ = strokes([60.0, 0.0] * 4, [8.0] * 8)
    head = np.concatenate([slow, fast[1:]])
    time_s = PERIOD_S * np.arange(head.size)
    held = 1.0 - slow.size / head.size
    found = workbench.identify(head, follow(head), time_s, "preisach", None, held, LABELS)
    assert found.fitted_range.highest == pytest.approx(40.0, abs=0.2)
    assert found.fitted_range.fastest == pytest.approx(8.0, rel=0.02)
    told = " ".join(found.warnings)
    assert "Beyond the fitted range: " in told
    assert "the plant changed" not in told
    assert "it leaves what was fitted" in told
    inside = workbench.identify(slow, follow(slow), clock, "modified-dahl", None, 0.5, LABELS)
    assert not any(each.startswith("Beyond") for each in inside.warnings)
