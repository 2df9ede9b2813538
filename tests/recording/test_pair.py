import numpy as np
import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording import array_column
from opensuction.recording.array_column import Pair

RAMP = np.arange(20.0)


def test_time_must_rise() -> None:
    array_column.check_time("t_s", RAMP)
    with pytest.raises(InputError, match=r"sample 3 is at 0 s, before the sample above at 1 s"):
        array_column.check_time("t_s", np.array([0.0, 1.0, 0.0, 2.0]))
    with pytest.raises(InputError, match=r"sample 2 is at 0 s, the same as .* \(2 such in 4\)"):
        array_column.check_time("t_s", np.array([0.0, 0.0, 1.0, 1.0]))


def test_a_time_that_is_no_number_of_seconds_is_refused() -> None:
    epoch_ms = 1764000000000.0 + RAMP
    with pytest.raises(InputError, match=r"sample 1 is at 1.764e\+12 s.* give it by --time-unit"):
        array_column.check_time("time", epoch_ms)
    array_column.check_time("time", epoch_ms / 1000.0)


def test_a_span_keeps_both_of_its_ends() -> None:
    inside = array_column.cut(Pair(RAMP, 2.0 * RAMP, 0.5 * RAMP), 1.0, 2.0)
    assert inside.time_s is not None
    assert inside.time_s.tolist() == [1.0, 1.5, 2.0]
    assert inside.answer.tolist() == [4.0, 6.0, 8.0]


def test_a_span_without_samples_is_refused() -> None:
    with pytest.raises(InputError, match=r"from 50 to inf s; the recording is from 0 to 19 s"):
        array_column.cut(Pair(RAMP, RAMP, RAMP), 50.0, None)


def test_constant_or_short_records_are_refused() -> None:
    array_column.check(Pair(RAMP, RAMP, None), "head_mm", "tip_mm")
    still = np.full(20, 3.0)
    with pytest.raises(InputError, match="'head_mm' is constant at 3 in all 20"):
        array_column.check(Pair(still, RAMP, None), "head_mm", "tip_mm")
    with pytest.raises(InputError, match="'tip_mm' is constant"):
        array_column.check(Pair(RAMP, still, None), "head_mm", "tip_mm")
    with pytest.raises(InputError, match="1 sample, at least 12"):
        array_column.check(Pair(RAMP[:1], RAMP[:1], None), "head_mm", "tip_mm")


def test_an_end_of_a_span_that_cuts_nothing_is_told() -> None:
    epoch_s = 1764000000.0 + RAMP
    assert array_column.find_idle_ends(epoch_s, 5.0, None) == (
        "--from 5 cuts nothing: the recording begins at 1764000000 s.",
    )
    assert array_column.find_idle_ends(RAMP, 0.0, 30.0) == (
        "--to 30 cuts nothing: the recording ends at 19 s.",
    )
    assert array_column.find_idle_ends(RAMP, 0.0, 19.0) == ()
    assert array_column.find_idle_ends(RAMP, None, None) == ()
