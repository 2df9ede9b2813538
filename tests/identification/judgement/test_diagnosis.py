"""Diagnosis of a recording: joined recordings, exchanged columns, a gap that was never crossed."""

import numpy as np
import pytest

from opensuction.identification.judgement.diagnosis import (
    Labels,
    check_recording,
    judge_recording,
)
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from tests.identification.plant import cosine

LABELS = Labels("head_mm", "tip_mm")
TIME_S: Array = 0.01 * np.arange(2000, dtype=np.float64)


def play(input_: Array, gap_mm: float = 10.0) -> Array:
    """What follows behind a gap."""
    output = np.empty_like(input_)
    output[0] = input_[0] - 0.5 * gap_mm
    for place in range(1, input_.size):
        least, most = input_[place] - gap_mm, input_[place]
        output[place] = min(max(output[place - 1], least), most)
    return output


HEAD_MM = cosine(1000, cycles=3.0)
TIP_MM = play(HEAD_MM)


def warned(input_: Array, output: Array, word: str, labels: Labels = LABELS) -> list[str]:
    time_s = TIME_S[: input_.size]
    return [one for one in judge_recording(input_, output, time_s, labels) if word in one]


def test_recordings_that_were_joined_are_told_with_the_place() -> None:
    other_mm = 30.0 + 20.0 * np.cos(np.linspace(0.0, 12.0, 1000))
    head_mm = np.concatenate([HEAD_MM, other_mm])
    tip_mm = np.concatenate([TIP_MM, play(other_mm)])
    (said,) = warned(head_mm, tip_mm, "joined")
    assert "at 10 s (sample 1000)" in said
    assert warned(HEAD_MM, TIP_MM, "joined") == []
    # A glitch of one quantity alone is none.
    glitch_mm = TIP_MM.copy()
    glitch_mm[500] += 60.0
    assert warned(HEAD_MM, glitch_mm, "joined") == []


@pytest.mark.parametrize("noise_mm", [0.0, 0.5])
def test_columns_that_were_exchanged_are_told(noise_mm: float) -> None:
    random = np.random.default_rng(1)
    tip_mm = TIP_MM + noise_mm * random.normal(size=TIP_MM.size)
    assert len(warned(tip_mm, HEAD_MM, "swapped")) == 1
    assert warned(HEAD_MM, tip_mm, "swapped") == []


def test_a_force_may_turn_before_what_makes_it() -> None:
    force_n = 3.0 * np.sign(np.gradient(HEAD_MM)) + 0.01 * HEAD_MM
    assert warned(HEAD_MM, force_n, "swapped", LABELS._replace(output_unit="N")) == []


def test_a_line_without_a_loop_is_neither() -> None:
    random = np.random.default_rng(2)
    tip_mm = 0.9 * HEAD_MM + 0.3 * random.normal(size=HEAD_MM.size)
    assert warned(HEAD_MM, tip_mm, "swapped") == []
    assert warned(tip_mm, HEAD_MM, "swapped") == []


@pytest.mark.parametrize("spring", [0.0, 0.01])
def test_a_friction_force_in_the_same_unit_is_not_taken_for_a_position(spring: float) -> None:
    force, state = np.empty_like(HEAD_MM), 0.0
    for place, move_mm in enumerate(np.diff(HEAD_MM, prepend=HEAD_MM[0])):
        state += 0.15 * move_mm * (1.0 - state * np.sign(move_mm))
        force[place] = state
    assert warned(HEAD_MM, 3.0 * force, "swapped") == []
    sliding = 3.0 * np.sign(np.gradient(HEAD_MM)) + spring * HEAD_MM
    assert warned(HEAD_MM, sliding, "swapped") == []


@pytest.mark.parametrize("gap_mm", [5.0, 30.0, 50.0, 70.0])
def test_columns_are_told_as_exchanged_behind_gaps_of_any_size(gap_mm: float) -> None:
    assert len(warned(play(HEAD_MM, gap_mm), HEAD_MM, "swapped")) == 1


def test_without_a_unit_no_sentence_has_one() -> None:
    labels = Labels("x", "y", "input", "output")
    for said in judge_recording(np.round(HEAD_MM, -1), TIP_MM, None, labels):
        assert "0 input" not in said
    (said,) = warned(np.round(HEAD_MM, -1), TIP_MM, "Range too small", labels)
    assert "steps of its resolution (10)," in said
    still = 50.0 + np.random.default_rng(3).normal(size=200)
    with pytest.raises(InputError, match=r"x: trembles within \d\.\d+ but does not travel"):
        check_recording(still, still, labels)
