import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel import random_stream
from opensuction.twin import parameter
from opensuction.twin.parameter import SENSORS
from opensuction.twin.sensor import sensor
from opensuction.twin.sensor.sensor import Measured, Sensors, SensorState

DT_S = 0.001
SOLD = sensor.sensors(parameter.nominal(SENSORS))
EXACT = sensor.exact_sensors(SOLD)
TRUTH = Measured(head_mm=12.345, carriage_mm=12.3, cam_rad=0.25, vacuum_mmhg=97.3, current_a=0.004)


def begun(sensors: Sensors, seed: int = 1) -> SensorState:
    return sensor.begin(sensors, TRUTH, random_stream.stream(seed, 3))


def read(
    sensors: Sensors, ticks: int, truth: Measured = TRUTH, seed: int = 1
) -> dict[str, np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """What all registers hold, tick by tick."""
    state, rows = begun(sensors, seed), []
    for _ in range(ticks):
        state = sensor.step(sensors, state, truth, DT_S)
        rows.append(state[:9])
    return dict(zip(SensorState._fields, np.array(rows).T, strict=False))


def test_exact_sensors_tell_the_truth_to_their_step() -> None:
    state = sensor.step(EXACT, begun(EXACT), TRUTH, DT_S)
    assert state.head_mm == TRUTH.head_mm
    assert state.carriage_mm == pytest.approx(TRUTH.carriage_mm, abs=EXACT.carriage.step / 2)
    assert state.cam_rad == pytest.approx(TRUTH.cam_rad, abs=EXACT.cam.step / 2)
    assert state.vacuum_mmhg == TRUTH.vacuum_mmhg
    assert state.current_a == TRUTH.current_a


@pytest.mark.parametrize(
    ("part", "register"),
    [
        ("carriage", "carriage_mm"),
        ("cam", "cam_rad"),
        ("vacuum", "vacuum_mmhg"),
        ("current", "current_a"),
    ],
)
def test_noise_has_its_rms_and_the_offset_stays(part: str, register: str) -> None:
    true = getattr(TRUTH, register)
    chosen = getattr(EXACT, part)._replace(noise=0.02 * true, offset=0.1 * true, step=0.0)
    seen = read(EXACT._replace(**{part: chosen}), 4000)[register]
    # Of 4,000 samples the RMS is known to 1.1 %, the mean to a sixtieth of it: three times that.
    assert np.std(seen) == pytest.approx(0.02 * true, rel=0.035)
    assert np.mean(seen) == pytest.approx(1.1 * true, abs=0.05 * 0.02 * true)
    # New in each reading: neighbours know nothing of one another.
    off = seen - np.mean(seen)
    assert abs(np.mean(off[1:] * off[:-1])) < 0.05 * np.var(seen)


def test_two_sensors_err_apart() -> None:
    parts = {
        name: getattr(EXACT, name)._replace(noise=1.0, step=0.0)
        for name in ("carriage", "cam", "vacuum", "current")
    }
    seen = read(EXACT._replace(**parts), 3000)
    columns = np.array(
        [seen[name] for name in ("carriage_mm", "cam_rad", "vacuum_mmhg", "current_a")]
    )
    among = np.corrcoef(columns) - np.eye(4)
    assert np.max(np.abs(among)) < 0.08


def test_an_offset_wanders_as_far_as_its_drift_and_comes_back() -> None:
    drifting = EXACT._replace(vacuum=EXACT.vacuum._replace(drift=2.0))
    ends = []
    for seed in range(400):
        state = begun(drifting, seed)
        ends.append(state.vacuum_mmhg - TRUTH.vacuum_mmhg)
    assert np.std(ends) == pytest.approx(2.0, rel=0.1)
    # Within a minute hardly at all, whatever the noise: 2 * sqrt(2 * 60 s / 300 s) = 1.26.
    state = begun(drifting)
    first = state.vacuum_drift
    for _ in range(6000):
        state = sensor.step(drifting, state, TRUTH, 0.01)
    assert 0.0 < abs(state.vacuum_drift - first) < 3.0 * math.sqrt(2.0 * 60.0 / sensor.DRIFT_S)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5])
def test_so_many_messages_come_a_tick_late_and_no_later(share: float) -> None:
    late = EXACT._replace(late_share=share)
    state, drive, node = begun(late), 0, 0
    waited = 0
    for tick in range(1, 3001):
        truth = TRUTH._replace(head_mm=float(tick), carriage_mm=float(tick))
        state = sensor.step(late, state, truth, DT_S)
        drive += state.head_mm != tick
        node += state.carriage_mm != pytest.approx(tick)
        waited = waited + 1 if state.head_mm != tick else 0
        if share < 0.1:
            assert waited <= 2
    deviation = math.sqrt(3000 * share * (1.0 - share))
    assert drive == pytest.approx(3000 * share, abs=4.0 * deviation)
    assert node == pytest.approx(3000 * share, abs=4.0 * deviation)


def test_a_sensor_lags_by_its_bandwidth() -> None:
    slow = EXACT._replace(vacuum=EXACT.vacuum._replace(lag_s=0.02))
    state = begun(slow)
    stepped = TRUTH._replace(vacuum_mmhg=TRUTH.vacuum_mmhg + 10.0)
    for _ in range(20):
        state = sensor.step(slow, state, stepped, DT_S)
    # Backward Euler: (20 / 21) ** 20 of the step is still to come.
    assert stepped.vacuum_mmhg - state.vacuum_mmhg == pytest.approx(10.0 * (20 / 21) ** 20)


@given(value=st.floats(-1e3, 1e3), step=st.floats(1e-4, 2.0))
def test_a_value_in_steps_is_a_step_near_it(value: float, step: float) -> None:
    told = sensor.quantise(value, step)
    assert abs(told - value) <= 0.5 * step * (1.0 + 1e-9)
    assert told / step == pytest.approx(round(told / step))
    assert sensor.quantise(value, 0.0) == value


def test_a_seed_is_repeated_and_another_run_is_another() -> None:
    one, same, other = (read(SOLD, 50, seed=seed)["vacuum_mmhg"] for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
