import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.machine import dc_axis
from opensuction.twin.machine.dc_axis import AxisMotion, DcAxis

DT_S = 0.001
FREE = DcAxis(
    speed_per_v=0.75,
    time_constant_s=0.02,
    voltage_limit_v=24.0,
    friction_v=0.0,
    force_v=1e9,
    encoder_step=0.005,
    brakes_when_off=False,
    polarity=1.0,
)
"""No friction, no current limit: linear."""
REAL = FREE._replace(friction_v=0.5, force_v=8.0)
AT_REST = AxisMotion(position=0.0, velocity=0.0, drive_v=0.0)

volts = st.floats(-30.0, 30.0)
speeds = st.floats(-18.0, 18.0)


def run(
    axis: DcAxis, motion: AxisMotion, volt: float, seconds: float, on: bool = True
) -> AxisMotion:
    for _ in range(round(seconds / DT_S)):
        motion = dc_axis.step(axis, motion, volt, on, 0.0, DT_S)
    return motion


@pytest.mark.parametrize("seconds", [0.001, 0.02, 0.3])
def test_step_response_is_the_analytic_one(seconds: float) -> None:
    motion = run(FREE, AT_REST, 10.0, seconds)
    final, tau = 7.5, 0.02
    decay = math.exp(-seconds / tau)
    # Exact but for the rounding of at most 300 additions.
    assert motion.velocity == pytest.approx(final * (1.0 - decay), rel=1e-12)
    assert motion.position == pytest.approx(final * (seconds - tau * (1.0 - decay)), rel=1e-9)


@given(volt=volts, speed=speeds, seconds=st.floats(1e-4, 0.05))
def test_one_tick_equals_two_halves(volt: float, speed: float, seconds: float) -> None:
    start = AxisMotion(position=3.0, velocity=speed, drive_v=0.0)
    whole = dc_axis.step(FREE, start, volt, True, 0.3, seconds)
    half = dc_axis.step(FREE, start, volt, True, 0.3, 0.5 * seconds)
    halves = dc_axis.step(FREE, half, volt, True, 0.3, 0.5 * seconds)
    if whole.velocity != 0.0 and halves.velocity != 0.0 and speed * halves.velocity > 0.0:
        assert halves.velocity == pytest.approx(whole.velocity, rel=1e-9, abs=1e-12)
        assert halves.position == pytest.approx(whole.position, rel=1e-9, abs=1e-12)


def test_no_load_speed_is_that_of_the_supply() -> None:
    assert run(FREE, AT_REST, 1000.0, 1.0).velocity == pytest.approx(18.0)
    # Friction takes its voltage off the supply.
    assert run(REAL, AT_REST, 1000.0, 1.0).velocity == pytest.approx(0.75 * 23.5)


@given(volt=st.floats(-0.5, 0.5))
def test_friction_holds_what_does_not_overcome_it(volt: float) -> None:
    assert run(REAL, AT_REST, volt, 0.05)[:2] == (0.0, 0.0)


@given(load_v=st.floats(-0.5, 0.5))
def test_friction_holds_a_load_without_torque(load_v: float) -> None:
    assert dc_axis.step(REAL, AT_REST, 9.0, False, load_v, DT_S)[:2] == (0.0, 0.0)


@given(speed=speeds, volt=st.floats(-0.45, 0.45))
def test_friction_stops_an_axis_but_never_turns_it_round(speed: float, volt: float) -> None:
    motion = AxisMotion(position=0.0, velocity=speed, drive_v=0.0)
    for _ in range(400):
        motion = dc_axis.step(REAL, motion, volt, True, 0.0, DT_S)
        assert motion.velocity * speed >= 0.0
    # Back electromotive force and friction brake 18 mm/s within 0.4 s.
    assert motion.velocity == 0.0


@given(volt=volts, speed=speeds, on=st.booleans())
def test_the_drive_never_works_against_its_voltage(volt: float, speed: float, on: bool) -> None:
    """Current flows towards the voltage that drives it, within supply, limit and switch."""
    motion = AxisMotion(position=0.0, velocity=speed, drive_v=0.0)
    moved = dc_axis.step(REAL, motion, volt, on, 0.0, DT_S)
    supply = min(max(volt, -24.0), 24.0)
    assert abs(moved.drive_v) <= REAL.force_v
    assert moved.drive_v * (supply - speed / 0.75) >= 0.0
    assert on or moved.drive_v == 0.0


def test_the_current_limit_bounds_acceleration() -> None:
    moved = dc_axis.step(REAL, AT_REST, 24.0, True, 0.0, DT_S)
    expected = 0.75 * (8.0 - 0.5) / 0.02
    assert moved.velocity / DT_S == pytest.approx(expected)
    assert moved.position == pytest.approx(0.5 * expected * DT_S * DT_S)


def test_without_torque_an_axis_coasts_to_the_energy_it_has() -> None:
    # Stops within a tick, not at the end of one.
    start = AxisMotion(position=0.0, velocity=9.01, drive_v=0.0)
    braking = 0.75 * 0.5 / 0.02
    # The friction does the work: v^2 / 2a, to the rounding of 480 ticks.
    coasted = run(REAL, start, 24.0, 1.0, on=False)
    assert coasted.velocity == 0.0
    assert coasted.position == pytest.approx(9.01 * 9.01 / (2.0 * braking), rel=1e-9)


def test_a_load_above_friction_moves_an_axis_without_torque() -> None:
    moved = dc_axis.step(REAL, AT_REST, 0.0, False, 1.5, DT_S)
    assert moved.velocity == pytest.approx(-0.75 * 1.0 / 0.02 * DT_S)


@given(position=st.floats(-200.0, 200.0))
def test_the_encoder_rounds_to_its_step(position: float) -> None:
    reading = dc_axis.encoder(REAL, AxisMotion(position=position, velocity=0.0, drive_v=0.0))
    assert abs(reading - position) <= 0.0025 + 1e-9
    assert reading / 0.005 == pytest.approx(round(reading / 0.005), abs=1e-6)


def test_shorted_windings_stop_an_axis_within_its_time_constant() -> None:
    braking = REAL._replace(brakes_when_off=True)
    start = AxisMotion(position=0.0, velocity=18.0, drive_v=0.0)
    open_mm = run(REAL, start, 24.0, 1.0, on=False).position
    shorted_mm = run(braking, start, 24.0, 1.0, on=False).position
    # Back-EMF alone gives v * tau = 0.36 mm; the current limit lets it grow a little, friction not.
    assert shorted_mm < 0.75
    assert open_mm > 5.0
