"""Units of a machine on a bus."""

import math

from hypothesis import given
from hypothesis import strategies as st

from opensuction.machine.canopen import device, objects
from opensuction.machine.canopen.device import (
    Analogue,
    AxisMode,
    AxisMotor,
    DriveAxis,
    Encoder,
    Homing,
    Identity,
)
from opensuction.machine.canopen.objects import AbortConnection

ANY = Identity(0, 0, 0)


def axis(counts_per_unit: float, zero: int) -> DriveAxis:
    return DriveAxis(
        node=1,
        identity=ANY,
        mode=AxisMode.POSITION,
        encoder=Encoder(
            counts_per_turn=1,
            gear_ratio=abs(counts_per_unit),
            travel_per_turn=1.0,
            reversed=counts_per_unit < 0.0,
        ),
        zero_counts=zero,
        lowest=-5.0,
        highest=400.0,
        most_per_s=80.0,
        rated_current_a=1.0,
        most_torque=1.0,
        motor=AxisMotor(rated_v=24.0, back_emf_v_s=1.0, speed_lag_s=0.01),
        lost_host=AbortConnection.WITHDRAW,
        velocity_offset=True,
        following_window=0.0,
        homing=Homing(method=0, at=0.0, per_s=1.0, slow_per_s=1.0, per_s2=1.0),
    )


@given(
    position=st.floats(-5.0, 400.0),
    scale=st.floats(10.0, 1e5),
    sign=st.sampled_from([1.0, -1.0]),
    zero=st.integers(-(1 << 31), (1 << 31) - 1),
)
def test_a_position_comes_back_across_the_wrap_at_32_bits(
    position: float, scale: float, sign: float, zero: int
) -> None:
    one = axis(sign * scale, zero)
    counts = device.counts_of(one, position)
    assert -(1 << 31) <= counts < 1 << 31
    assert abs(device.position_of(one, counts) - position) <= 0.5001 / scale


def test_nothing_is_sent_beyond_the_axis_range() -> None:
    one = axis(100.0, 0)
    assert device.counts_of(one, 1e9) == 40_000
    assert device.counts_of(one, -1e9) == -500


def test_an_analogue_channel_that_is_not_there_has_no_value() -> None:
    assert math.isnan(device.value_of(Analogue(0, 1.0, 0), 5))
    assert device.value_of(Analogue(2, 200.0, 100), 20_100) == 100.0
    assert device.output_of(Analogue(1, 200.0, 100), 1e9) == 0x7FFF
    assert device.output_of(Analogue(1, 200.0, 100), -1e9) == -0x8000


@given(
    st.integers(0, 0xFFFF),
    st.integers(-(1 << 31), (1 << 31) - 1),
    st.integers(-(1 << 15), (1 << 15) - 1),
)
def test_a_frame_holds_its_values_and_says_where_they_belong(
    word: int, position: int, torque: int
) -> None:
    frame = objects.AXIS_STATUS
    data = frame.pack(word, position, torque)
    assert len(data) == sum(bits for _, _, bits in frame.objects) // 8 <= 8
    assert frame.unpack(data) == (word, position, torque)


def test_every_frame_is_as_long_as_what_is_mapped_into_it() -> None:
    frames = [one for one in vars(objects).values() if isinstance(one, objects.Frame)]
    for one in [*frames, *objects.MODULE_ANALOGUE]:
        bits = [bits for _, _, bits in one.objects]
        assert one.layout.size * 8 == sum(bits) <= 64
        assert [entry & 0xFF for entry in one.entries] == bits


@given(scale=st.floats(10.0, 1e5), sign=st.sampled_from([1.0, -1.0]))
def test_a_following_window_is_in_counts_and_none_is_all_bits(scale: float, sign: float) -> None:
    one = axis(sign * scale, 0)
    assert device.window_of(one) == 0xFFFFFFFF
    assert device.window_of(one._replace(following_window=2.0)) == round(2.0 * scale)
