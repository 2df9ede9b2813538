import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.control.servo import Servo, ServoState, step

DT_S = 0.001

PLAIN = Servo(
    proportional_v=10.0,
    derivative_v_s=0.010,
    velocity_v_s=0.0,
    friction_v=0.0,
    time_constant_s=0.0,
    voltage_limit_v=24.0,
    back_emf_v_s=0.0,
    catch_up_v=24.0,
)
"""The paper's insertion axis."""
FED = PLAIN._replace(velocity_v_s=1.28, friction_v=0.5, time_constant_s=0.02)
AT_REST = ServoState(error=0.0, velocity=0.0)


def test_proportional_and_derivative_part() -> None:
    state, volts = step(PLAIN, ServoState(error=0.05, velocity=0.0), 10.0, 9.0, 9.9, DT_S)
    # 10 V/mm on 0.1 mm, 10 mV s/mm on 0.05 mm in 1 ms; the commanded velocity plays no part.
    assert volts == pytest.approx(10.0 * 0.1 + 0.010 * 0.05 / DT_S)
    assert tuple(state) == pytest.approx((0.1, 9.0))


def test_feedforward_at_steady_speed_needs_no_error() -> None:
    _, volts = step(FED, ServoState(error=0.0, velocity=9.0), 10.0, 9.0, 10.0, DT_S)
    assert volts == pytest.approx(1.28 * 9.0 + 0.5)
    _, volts = step(FED, ServoState(error=0.0, velocity=-9.0), 10.0, -9.0, 10.0, DT_S)
    assert volts == pytest.approx(-1.28 * 9.0 - 0.5)


def test_feedforward_leads_a_change_of_speed_by_the_axis_own_lag() -> None:
    _, volts = step(FED, ServoState(error=0.0, velocity=1.0), 0.0, 1.1, 0.0, DT_S)
    assert volts == pytest.approx(1.28 * (1.1 + 0.02 * 0.1 / DT_S) + 0.5)


def test_at_rest_on_target_there_is_no_voltage() -> None:
    assert step(FED, AT_REST, 3.0, 0.0, 3.0, DT_S) == (AT_REST, 0.0)


@given(
    position=st.floats(-1e6, 1e6),
    velocity=st.floats(-1e6, 1e6),
    reading=st.floats(-1e6, 1e6),
    error=st.floats(-1e6, 1e6),
)
def test_the_supply_bounds_the_voltage(
    position: float, velocity: float, reading: float, error: float
) -> None:
    _, volts = step(FED, ServoState(error, 0.0), position, velocity, reading, DT_S)
    assert -24.0 <= volts <= 24.0


@given(
    position=st.floats(-100.0, 100.0),
    velocity=st.floats(-20.0, 20.0),
    reading=st.floats(-100.0, 100.0),
    error=st.floats(-1.0, 1.0),
)
def test_both_directions_are_treated_alike(
    position: float, velocity: float, reading: float, error: float
) -> None:
    _, volts = step(FED, ServoState(error, 0.0), position, velocity, reading, DT_S)
    _, mirrored = step(FED, ServoState(-error, 0.0), -position, -velocity, -reading, DT_S)
    assert mirrored == -volts


@given(velocity=st.floats(-60.0, 60.0), position=st.floats(-100.0, 100.0))
def test_inwards_it_catches_up_no_faster_than_it_may_and_outwards_as_fast_as_it_can(
    velocity: float, position: float
) -> None:
    slow = FED._replace(voltage_limit_v=1e3, back_emf_v_s=0.4, catch_up_v=4.0)
    before = ServoState(position, velocity)
    _, bounded = step(slow, before, position, velocity, 0.0, DT_S)
    _, free = step(slow._replace(catch_up_v=2e3), before, position, velocity, 0.0, DT_S)
    # What it is fed forward for friction comes on top of the speed's volts.
    assert bounded == min(free, 0.5 + 0.4 * max(velocity, 0.0) + 4.0)
