"""What is wrong with a recording as a whole: joined ones, exchanged columns, a gap never seen."""

import numpy as np
import pytest

from opensuction.identification.judgement.diagnosis import Labels, judge_recording
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
