import math

import numpy as np
import pytest

from opensuction.safety.watch import vacuum_signature
from opensuction.safety.watch.vacuum_signature import FILTER_START, LineFilter
from tests.safety.watchdog import DT_S, NAN, sound


def filtered(state: LineFilter, values: list[float], *, vented: bool = False) -> LineFilter:
    for value in values:
        read = sound(0.0)._replace(line_vacuum_mmhg=value)
        state = vacuum_signature.step_filter(state, read, vented, DT_S)
    return state


def test_the_first_reading_is_believed_at_once() -> None:
    assert vacuum_signature.vacuum_mmhg(filtered(FILTER_START, [120.0])) == 120.0


def test_of_a_step_a_third_is_left_after_the_time_constant() -> None:
    state = filtered(FILTER_START, [100.0] + [50.0] * 20)
    assert vacuum_signature.vacuum_mmhg(state) == pytest.approx(50.0 + 50.0 * (20 / 21) ** 20)


def test_of_white_noise_a_sixth_is_left() -> None:
    noise = np.random.default_rng(5).normal(0.0, 1.0, 20_000)
    state, seen = filtered(FILTER_START, [100.0]), []
    for off in noise:
        state = filtered(state, [100.0 + off])
        seen.append(vacuum_signature.vacuum_mmhg(state))
    share = DT_S / (vacuum_signature.FILTER_S + DT_S)
    expected = math.sqrt(share / (2.0 - share))
    assert np.std(seen[500:]) == pytest.approx(expected, rel=0.1)
    assert expected == pytest.approx(1 / 6.4, rel=0.01)


@pytest.mark.parametrize("value", [NAN, math.inf, 1e9])
def test_what_is_no_number_changes_nothing(value: float) -> None:
    before = filtered(FILTER_START, [100.0, 90.0])
    assert filtered(before, [value]) == before
    hidden = sound(0.0)._replace(line_vacuum_mmhg=5.0, vacuum_valid=False)
    assert vacuum_signature.step_filter(before, hidden, True, DT_S) == before


@pytest.mark.parametrize("offset", [-6.9, -3.0, 0.0, 6.9])
def test_what_a_vented_line_reads_is_the_sensor_s_offset(offset: float) -> None:
    learnt = filtered(FILTER_START, [offset] * 1000, vented=True)
    assert vacuum_signature.vacuum_mmhg(learnt) == pytest.approx(0.0, abs=0.05)
    # It is taken off what is read under vacuum, and not learnt there.
    working = filtered(learnt, [100.0 + offset] * 1000)
    assert vacuum_signature.vacuum_mmhg(working) == pytest.approx(100.0, abs=0.05)
    assert working.zero_mmhg == learnt.zero_mmhg


@pytest.mark.parametrize("offset", [-7.1, 7.1, 40.0])
def test_more_than_a_sound_sensor_s_offset_stays_in_the_reading(offset: float) -> None:
    assert (
        vacuum_signature.vacuum_mmhg(filtered(FILTER_START, [offset] * 2000, vented=True)) == offset
    )


def test_the_vacuum_that_is_being_vented_is_no_offset() -> None:
    """It passes through what an offset may be in some hundredths of a second."""
    held = filtered(filtered(FILTER_START, [0.0] * 500, vented=True), [120.0] * 500)
    falling = [120.0 * math.exp(-i / 25.0) for i in range(150)]
    assert abs(filtered(held, falling, vented=True).zero_mmhg) < 1.0
