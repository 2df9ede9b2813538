import math

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.identification.estimator.servo import fit_feedforward, velocity_mm_per_s
from opensuction.kernel.errors import InputError

Array = NDArray[np.float64]

VELOCITY = 15.0 * np.sin(np.linspace(0.0, 12.0, 1200))
VOLTS = 1.2 * VELOCITY + 0.8 * np.sign(VELOCITY)


def test_exact_recordings_give_the_exact_feedforward() -> None:
    found = fit_feedforward(VOLTS, VELOCITY, slowest_mm_per_s=0.5, saturation_v=24.0)
    assert found.velocity_v_s_per_mm == pytest.approx(1.2, rel=1e-12)
    assert found.friction_v == pytest.approx(0.8, rel=1e-12)
    assert found.rmse_v < 1e-12
    assert found.samples == int((np.abs(VELOCITY) >= 0.5).sum())


def test_noise_is_averaged_out_and_reported() -> None:
    noise = np.random.default_rng(3).normal(0.0, 0.2, VOLTS.size)
    found = fit_feedforward(VOLTS + noise, VELOCITY, 0.5, 24.0)
    # Four standard errors: 0.2 / sqrt(1100) over a spread of speeds of 4.4 mm/s.
    assert found.velocity_v_s_per_mm == pytest.approx(1.2, abs=0.006)
    assert found.friction_v == pytest.approx(0.8, abs=0.06)
    assert found.rmse_v == pytest.approx(0.2, rel=0.1)


def test_standstill_and_saturation_are_left_out() -> None:
    volts = VOLTS.copy()
    volts[np.abs(VELOCITY) < 2.0] = 3.3  # sticking: any voltage, no motion
    volts[np.abs(VOLTS) > 15.0] = 15.0 * np.sign(VELOCITY[np.abs(VOLTS) > 15.0])
    found = fit_feedforward(volts, VELOCITY, slowest_mm_per_s=2.0, saturation_v=15.0)
    assert found.velocity_v_s_per_mm == pytest.approx(1.2, rel=1e-12)
    assert found.friction_v == pytest.approx(0.8, rel=1e-12)


def test_a_free_axis_gets_no_negative_friction() -> None:
    found = fit_feedforward(VOLTS - 0.9 * np.sign(VELOCITY), VELOCITY, 0.5, 24.0)
    assert found.friction_v == 0.0
    assert found.velocity_v_s_per_mm > 0.0


def test_the_feedforward_of_an_axis_with_inertia_is_found_from_its_positions() -> None:
    # Head time constant 20 ms, no-load speed 18 mm/s at 24 V, friction 0.5 V, at 1 kHz.
    period_s, gain, head_mm, speed = 1e-3, 18.0 / 24.0, 0.0, 0.0
    volts, heads = np.empty(20_000), np.empty(20_000)
    for k in range(volts.size):
        volts[k] = 20.0 * math.sin(2.0 * math.pi * k * period_s / 5.0)
        drive = volts[k] - 0.5 * math.copysign(1.0, volts[k])
        speed += (gain * drive - speed) * (1.0 - math.exp(-period_s / 0.02))
        heads[k] = head_mm
        head_mm += speed * period_s
    velocity = velocity_mm_per_s(np.round(heads / 0.01) * 0.01, period_s, window_s=0.05)
    found = fit_feedforward(volts, velocity, slowest_mm_per_s=1.0, saturation_v=24.0)
    # The lag of 20 ms at 1.26 rad/s turns less than 0.1 % of the voltage.
    assert found.velocity_v_s_per_mm == pytest.approx(24.0 / 18.0, rel=0.005)
    assert found.friction_v == pytest.approx(0.5, abs=0.05)


def test_velocity_is_exact_on_a_parabola_and_does_not_lag() -> None:
    time_s = np.arange(1000) * 1e-3
    velocity = velocity_mm_per_s(3.0 * time_s**2 - 2.0 * time_s, 1e-3, 0.02)
    inner = slice(10, -10)
    assert velocity[inner] == pytest.approx((6.0 * time_s - 2.0)[inner], abs=1e-10)
    # At the ends the window is half as wide and off centre by 5 ms.
    assert velocity[0] == pytest.approx(6.0 * 0.005 - 2.0, abs=1e-10)


@pytest.mark.parametrize(
    ("volts", "velocity", "slowest", "saturation", "says"),
    [
        (VOLTS[:3], VELOCITY[:3], 0.5, 24.0, "volts: 3 samples, at least 10"),
        (VOLTS, VELOCITY[:-1], 0.5, 24.0, "volts has 1200 samples, velocity 1199"),
        (VOLTS, np.full(1200, math.nan), 0.5, 24.0, "velocity: sample 0 is nan"),
        (VOLTS, VELOCITY, 0.0, 24.0, "slowest_mm_per_s 0.0 .* above 0"),
        (VOLTS, VELOCITY, 0.5, math.nan, "saturation_v nan"),
        (VOLTS, VELOCITY, 99.0, 24.0, "0 of 1200 samples are faster than 99 mm/s"),
        (VOLTS, np.full(1200, 9.0), 0.5, 24.0, "usable speeds from 9 to 9 mm/s are too much alike"),
        (-VOLTS, VELOCITY, 0.5, 24.0, "fall with speed"),
    ],
)
def test_bad_recordings_are_refused(
    volts: Array, velocity: Array, slowest: float, saturation: float, says: str
) -> None:
    with pytest.raises(InputError, match=says) as refused:
        fit_feedforward(volts, velocity, slowest, saturation)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("samples", "period_s", "window_s", "says"),
    [
        (100, 0.0, 0.01, "period_s: 0.0 s, should be above 0"),
        (100, math.inf, 0.01, "period_s: inf"),
        (100, 1e-3, 1e-3, "two sampling periods"),
        (100, 1e-3, math.nan, "window_s: nan"),
        (100, 1e-3, 0.5, "length of the record"),
        (2, 1e-3, 0.01, "position_mm: 2 samples"),
    ],
)
def test_windows_that_do_not_fit_are_refused(
    samples: int, period_s: float, window_s: float, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        velocity_mm_per_s(np.arange(samples), period_s, window_s)
