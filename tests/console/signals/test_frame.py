"""Values that a client decodes from a frame are those of the rows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from opensuction.console.signals.channel import CHANNELS, Picker, decode, with_missed
from tests.console.signals.block import PERIOD_S, block_of, find, rows_of

HEAD, VACUUM = "inputs.readings.head_mm", "inputs.readings.line_vacuum_mmhg"
REFERENCE = "outputs.demand.reference_mm"


def picker(*names: str) -> Picker:
    return Picker([CHANNELS[name] for name in names])


@given(
    arrays.arrays(
        np.float32, st.integers(1, 60), elements=st.floats(-1e6, 1e6, width=32, allow_nan=False)
    ),
    st.integers(0, 2**53 - 100),
    st.integers(0, 2**32 - 1),
)
def test_values_ticks_and_times_come_back(values: np.ndarray, tick: int, missed: int) -> None:
    rows = rows_of(len(values), tick, reference_mm=values.astype(float))
    found = decode(picker(REFERENCE, "outputs.phase").encode(block_of(rows, missed, 7)))
    assert (found.source, found.missed, found.first_tick) == (7, missed, tick)
    assert found.values.shape == (2, len(values))
    np.testing.assert_array_equal(found.values[0], values)
    assert not found.values[1].any()
    np.testing.assert_allclose(found.times_s, rows[:, find("time_s")], atol=1e-9, rtol=0)


def test_a_column_is_rounded_to_single_precision_and_no_more() -> None:
    rows = rows_of(3, reference_mm=np.array([0.1, 88.123456789, -1e39]))
    found = decode(picker(REFERENCE).encode(block_of(rows)))
    np.testing.assert_array_equal(
        found.values[0], np.array([0.1, 88.123456789, -np.inf], np.float32)
    )


def test_ticks_that_were_missed_leave_a_hole_in_time() -> None:
    rows = rows_of(4)
    rows[2:, find("time_s")] += 7 * PERIOD_S
    found = decode(picker(REFERENCE).encode(block_of(rows)))
    np.testing.assert_allclose(np.diff(found.times_s), [0.001, 0.008, 0.001], atol=1e-9)


def test_a_reading_whose_flag_is_down_is_no_value() -> None:
    rows = rows_of(3, head_mm=12.0, head_valid=np.array([1.0, 0.0, 1.0]))
    rows[:, find("readings.head_mm")] = 12.0
    found = decode(picker(HEAD, REFERENCE).encode(block_of(rows)))
    np.testing.assert_array_equal(found.values[0], np.array([12.0, np.nan, 12.0], np.float32))
    assert np.isfinite(found.values[1]).all()


def test_a_patient_without_a_monitor_has_no_values() -> None:
    rows = rows_of(2, spo2_valid=1.0)
    rows[:, find("readings.monitor.spo2_percent")] = 97.0
    rows[1, find("monitor.connected")] = 1.0
    found = decode(picker("inputs.readings.monitor.spo2_percent").encode(block_of(rows)))
    np.testing.assert_array_equal(found.values[0], np.array([np.nan, 97.0], np.float32))


def test_the_tip_is_worked_out_by_the_transmission() -> None:
    rows = rows_of(1)
    rows[:, find("tip.foremost_mm")], rows[:, find("tip.rearmost_mm")] = 40.0, 20.0
    names = ("tip.high_mm", "tip.middle_mm", "tip.low_mm")
    found = decode(picker(*names).encode(block_of(rows)))
    np.testing.assert_allclose(found.values[:, 0], [17.0, 12.0, 7.0])


def test_what_a_client_lacks_beside_is_added() -> None:
    message = picker(HEAD).encode(block_of(rows_of(5), missed=3))
    told = with_missed(message, 40)
    assert decode(told).missed == 43
    np.testing.assert_array_equal(decode(told).values, decode(message).values)
    assert len(told) == len(message)


@pytest.mark.parametrize("cut", [0, 20, 47, 60])
def test_what_is_cut_off_is_no_frame(cut: int) -> None:
    message = picker(HEAD).encode(block_of(rows_of(5)))
    with pytest.raises(ValueError, match="bytes"):
        decode(message[:cut])
