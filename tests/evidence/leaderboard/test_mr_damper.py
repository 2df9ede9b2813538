"""The model of a magnetorheological damper against closed forms and itself."""

import numpy as np
import pytest

from opensuction.evidence.leaderboard import mr_damper
from opensuction.evidence.leaderboard.mr_damper import MrDamper

PERIOD_S = 0.002
SPEED = 8.0 * np.sin(np.linspace(0.0, 20.0, 200))
VOLTAGE = 1.0 + np.sin(np.linspace(0.0, 3.0, 200))
PLAIN = MrDamper(
    damping_per_v=0.0,
    series_damping_per_v=0.0,
    hysteretic_n_per_cm=0.0,
    hysteretic_per_v=0.0,
    stiffness_n_per_cm=0.0,
    accumulator_n_per_cm=0.0,
)


def test_two_dashpots_in_series() -> None:
    force = mr_damper.simulate(PLAIN, SPEED, VOLTAGE, PERIOD_S)
    np.testing.assert_allclose(force, SPEED * 21.0 * 283.0 / (21.0 + 283.0), atol=1e-9)


def test_the_spring_beside_them_is_driven_by_the_way() -> None:
    sprung = PLAIN._replace(accumulator_n_per_cm=5.0, start_cm=-0.5)
    way_cm = np.append(0.0, np.cumsum(0.5 * (SPEED[1:] + SPEED[:-1]) * PERIOD_S))
    added = mr_damper.simulate(sprung, SPEED, VOLTAGE, PERIOD_S) - mr_damper.simulate(
        PLAIN, SPEED, VOLTAGE, PERIOD_S
    )
    np.testing.assert_allclose(added, 5.0 * (way_cm - 0.5), atol=1e-9)


@pytest.mark.sweep
def test_a_damper_is_found_again() -> None:
    truth = MrDamper(
        hysteretic_per_v=100.0, gamma_per_cm2=20.0, beta_per_cm2=30.0, hysteretic_start_cm=1.0
    )
    time_s = PERIOD_S * np.arange(800)
    speed = 8.0 * np.sin(12.0 * time_s) + 3.0 * np.sin(31.0 * time_s)
    voltage = 1.0 + np.sin(5.0 * time_s)
    force = mr_damper.simulate(truth, speed, voltage, PERIOD_S)
    found = mr_damper.fit(speed[:600], voltage[:600], force[:600], PERIOD_S)
    rest = mr_damper.simulate(found, speed, voltage, PERIOD_S) - force
    assert rest[600:].std() < 1e-3 * force.std()
