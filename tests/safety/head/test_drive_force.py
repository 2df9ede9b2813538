import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.safety.head import drive_force
from opensuction.safety.head.drive_force import REST, DriveForce
from tests.safety.watchdog import DT_S
from tests.safety.watchdog import LIMITS as GOVERNED
from tests.settled import settled

LIMITS = GOVERNED.drive
SHARE = DT_S / (0.01 + DT_S)
step = settled(drive_force.step)


def pushed(force_n: float, resisted_n: float, seconds: float) -> DriveForce:
    """A head at rest that is pushed by a force against a resistance, both constant."""
    state, speed, averaged = REST, 0.0, 0.0
    for _ in range(round(seconds / DT_S)):
        speed += 1000.0 * (force_n - resisted_n) / LIMITS.moving_mass_kg * DT_S
        gained = SHARE * (speed - averaged)
        current_a = force_n / LIMITS.newton_per_a
        volts = LIMITS.volts_per_a * current_a + averaged / LIMITS.mm_per_s_per_v
        state = step(LIMITS, state, current_a, volts, averaged, gained, SHARE, DT_S)
        averaged += gained
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
    state = step(LIMITS, REST, current_a, 0.0, 0.0, 0.0, SHARE, DT_S)
    assert state == DriveForce(0.0, 0.0, 0.0, 0.0, 0.0)


# What the motor bears out.


def at_rest(current_a: float, volts: float, seconds: float, state: DriveForce = REST) -> DriveForce:
    for _ in range(round(seconds / DT_S)):
        state = step(LIMITS, state, current_a, volts, 0.0, 0.0, SHARE, DT_S)
    return state


def test_what_the_sensor_reads_at_rest_beyond_the_volts_current_is_its_offset() -> None:
    offset_a, force_n = 5.0 / LIMITS.newton_per_a, 0.5
    volts = LIMITS.volts_per_a * force_n / LIMITS.newton_per_a
    state = at_rest(offset_a + force_n / LIMITS.newton_per_a, volts, 5.0)
    assert state.offset_a == pytest.approx(offset_a, rel=1e-3)
    assert state.force_n == pytest.approx(force_n, abs=0.01)
    assert state.borne_n == pytest.approx(force_n, abs=1e-6)
    assert drive_force.rest(state) == DriveForce(0.0, 0.0, 0.0, state.offset_a, 0.0)


def test_without_torque_all_that_a_head_at_rest_reads_is_the_offset() -> None:
    """It was not learnt until the drive held the head: a bench's calibration began without it."""
    offset_a, state = 0.25 * LIMITS.force_n / LIMITS.newton_per_a, REST
    for _ in range(2500):
        state = drive_force.learn(LIMITS, state, offset_a, 0.0, DT_S)
    assert state.offset_a == pytest.approx(offset_a, rel=0.01)
    # Pushed by hand its windings carry what they brake with; and some numbers are none.
    assert drive_force.learn(LIMITS, state, 0.0, 5.0, DT_S) == drive_force.rest(state)
    assert drive_force.learn(LIMITS, state, float("nan"), 0.0, DT_S) == drive_force.rest(state)
    most_a = 1.5 * LIMITS.force_n / LIMITS.newton_per_a
    spike_a = drive_force.learn(LIMITS, state, 1e306, 0.0, DT_S).offset_a - state.offset_a
    assert spike_a <= most_a * DT_S / 0.5


def test_no_offset_is_taken_in_motion_nor_of_a_current_that_is_no_number() -> None:
    state = REST
    for _ in range(2000):
        state = step(LIMITS, state, 0.005, 10.0, 7.8, 0.0, SHARE, DT_S)
    assert state.offset_a == 0.0
    assert at_rest(float("nan"), 0.5, 2.0).offset_a == 0.0
    # A jam at the drive's limit is none either.
    held = at_rest(5.0 / LIMITS.newton_per_a, 24.0, 2.0)
    assert held.offset_a == 0.0
    assert held.resistance_n == pytest.approx(5.0, abs=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_force_counts_as_far_as_the_volts_bear_it_out(sign: float) -> None:
    state = DriveForce(0.0, 0.0, sign * 1.06, 0.0, 0.0)
    assert drive_force.is_above(state, sign * 1.41, 1.4)
    assert not drive_force.is_above(state, sign * 1.4, 1.4)
    assert not drive_force.is_above(state, -sign * 1.41, 1.4)
    assert not drive_force.is_above(state._replace(borne_n=sign * 1.04), sign * 1.41, 1.4)


@pytest.mark.parametrize("pulse_a", [0.02, -0.02, 1.0])
def test_a_pulse_that_no_volts_drive_is_no_jam(pulse_a: float) -> None:
    state = at_rest(pulse_a, 0.3, 0.06)
    assert abs(state.resistance_n) > LIMITS.jam_n
    assert not drive_force.is_above(state, state.resistance_n, LIMITS.jam_n)
    # A spike of any height is over soon.
    after = at_rest(0.0, 0.3, 0.1, state)
    assert abs(after.resistance_n) < LIMITS.jam_n


# What current and volts say of each other.

WAYS = [1.0, -1.0]
MORE = drive_force.AGAINST_N + 0.01
LESS = drive_force.AGAINST_N - 0.01


@pytest.mark.parametrize("sign", WAYS)
@pytest.mark.parametrize(
    ("force_n", "borne_n", "against"),
    [(MORE, -MORE, True), (LESS, -MORE, False), (MORE, -LESS, False), (MORE, MORE, False)],
)
def test_a_force_is_against_its_volts_where_both_are_clear(
    sign: float, force_n: float, borne_n: float, against: bool
) -> None:
    state = REST._replace(force_n=sign * force_n, borne_n=sign * borne_n)
    assert drive_force.is_against(state) == against


@pytest.mark.parametrize(
    ("borne_n", "force_n", "resistance_n", "yields"),
    [
        (-MORE, -MORE, 0.0, True),
        (-MORE, 0.0, 0.0, True),  # a loose contact: no current
        (-MORE, MORE, 0.0, False),  # it pushes
        (-LESS, -MORE, 0.0, False),  # it is hardly told to
        (MORE, -MORE, 0.0, False),
        (-MORE, -MORE, -MORE, False),  # the head goes in although it is pulled
    ],
)
def test_a_motor_yields_that_pulls_as_told_or_has_no_current_while_the_head_slows(
    borne_n: float, force_n: float, resistance_n: float, yields: bool
) -> None:
    state = REST._replace(borne_n=borne_n, force_n=force_n, resistance_n=resistance_n)
    assert drive_force.is_yielding(state) == yields
