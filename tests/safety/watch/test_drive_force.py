import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.safety.limits import DriveLimits
from opensuction.safety.watch import drive_force
from opensuction.safety.watch.drive_force import REST, DriveForce

LIMITS = DriveLimits(newton_per_a=833.0, moving_mass_kg=16.4, jam_n=1.4, force_n=6.0)
DT_S = 0.001
SHARE = DT_S / (0.01 + DT_S)


def pushed(force_n: float, resisted_n: float, seconds: float) -> DriveForce:
    """A head at rest that is pushed by a force against a resistance, both constant."""
    state, speed, averaged = REST, 0.0, 0.0
    for _ in range(round(seconds / DT_S)):
        speed += 1000.0 * (force_n - resisted_n) / LIMITS.moving_mass_kg * DT_S
        gained = SHARE * (speed - averaged)
        averaged += gained
        state = drive_force.step(LIMITS, state, force_n / LIMITS.newton_per_a, gained, SHARE, DT_S)
    return state


@given(force_n=st.floats(-5.0, 5.0), resisted_n=st.floats(-2.0, 2.0))
def test_what_does_not_accelerate_the_mass_is_resistance(force_n: float, resisted_n: float) -> None:
    state = pushed(force_n, resisted_n, 0.5)
    # Both went through the same average; 16 time constants leave a millionth.
    assert state.resistance_n == pytest.approx(resisted_n, abs=1e-4)
    assert state.force_n == pytest.approx(force_n, abs=1e-4)


def test_an_acceleration_alone_is_never_taken_for_a_jam() -> None:
    for ticks in range(1, 200):
        assert abs(pushed(5.0, 0.3, ticks * DT_S).resistance_n) < LIMITS.jam_n


@pytest.mark.requirement("OS-R15")
def test_two_newtons_more_than_friction_are_seen_in_a_twentieth_of_a_second() -> None:
    assert pushed(2.3, 2.3, 0.05).resistance_n > LIMITS.jam_n


@pytest.mark.parametrize("current_a", [float("nan"), float("-inf"), 1e306])
def test_a_current_that_is_no_number_is_none(current_a: float) -> None:
    state = drive_force.step(LIMITS, REST, current_a, 0.0, SHARE, DT_S)
    assert state == DriveForce(0.0, 0.0)
