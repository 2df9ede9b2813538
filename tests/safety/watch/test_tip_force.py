"""The force at the tip, from current and volts of a drive at one speed."""

import random

import pytest

from opensuction.safety.head.drive_force import REST, DriveForce
from opensuction.safety.watch import tip_force
from opensuction.safety.watch.tip_force import PRESSED_N, START, TipForce
from tests.settled import settled

DT_S = 0.001
FRICTION_N, ASKED_N = 0.9, 1.4
"""Of the drive, by its current and by its volts."""
SEARCH_MM_PER_S = 10.0
step = settled(tip_force.step)


def driven(
    state: TipForce,
    duration_s: float,
    measured_n: float = 0.0,
    asked_n: float = 0.0,
    speed_mm_per_s: float = SEARCH_MM_PER_S,
    touching: bool = False,
    may_touch: bool = True,
    noise: tuple[float, float] = (0.0, 0.0),
    seed: int = 1,
) -> TipForce:
    """Drawn so long, with so much on top of friction. noise: standard deviations, N."""
    chance = random.Random(seed)
    for _ in range(round(duration_s / DT_S)):
        drive: DriveForce = REST._replace(
            resistance_n=FRICTION_N + measured_n + chance.gauss(0.0, noise[0]),
            borne_n=ASKED_N + asked_n + chance.gauss(0.0, noise[1]),
        )
        state = step(state, drive, speed_mm_per_s, touching, may_touch, DT_S)
    return state


def pressing(force_n: float, after_s: float, free_s: float = 2.0) -> TipForce:
    return driven(driven(START, free_s), after_s, force_n, force_n)


@pytest.mark.requirement("OS-R17")
@pytest.mark.parametrize("force_n", [0.1, 0.15, 0.3])
def test_what_the_tip_presses_with_is_what_comes_on_top_of_friction(force_n: float) -> None:
    found = pressing(force_n, 0.5)
    assert tip_force.force_n(found) == pytest.approx(force_n, abs=0.03)
    assert tip_force.is_pressing(found)


def test_a_buckling_catheter_is_told_within_what_the_head_goes_in_two_millimetres() -> None:
    assert tip_force.is_pressing(pressing(0.125, 2.0 / SEARCH_MM_PER_S))
    assert not tip_force.is_pressing(pressing(0.125, 0.02))


def test_less_than_a_catheter_buckles_at_is_none_for_as_long_as_a_search_lasts() -> None:
    assert not tip_force.is_pressing(pressing(0.9 * PRESSED_N, 10.0))


def test_friction_that_grows_slowly_is_none_of_the_tip() -> None:
    state = driven(START, 2.0)
    for part in range(100):
        state = driven(state, 0.1, 0.003 * part, 0.003 * part)
        assert not tip_force.is_pressing(state)


@pytest.mark.parametrize("noise", [(4.0, 0.0), (0.0, 4.0)], ids=["current", "volts"])
def test_a_sensor_that_is_noisy_presses_on_nothing(noise: tuple[float, float]) -> None:
    state = driven(START, 2.0, noise=noise)
    for seed in range(20):
        state = driven(state, 0.5, noise=noise, seed=seed)
        assert not tip_force.is_pressing(state)


def test_an_offset_of_one_alone_presses_on_nothing() -> None:
    free = driven(START, 2.0)
    assert not tip_force.is_pressing(driven(free, 1.0, measured_n=2.0))
    assert not tip_force.is_pressing(driven(free, 1.0, asked_n=2.0))


def test_another_speed_has_another_friction() -> None:
    free = driven(START, 1.0, 0.5, 0.5, speed_mm_per_s=30.0)
    slower = driven(free, 1.0)
    assert tip_force.force_n(slower) == pytest.approx(0.0, abs=0.01)
    faster = driven(slower, 1.0, 0.5, 0.5, speed_mm_per_s=30.0)
    assert tip_force.force_n(faster) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("speed_mm_per_s", [0.0, 3.0, -10.0])
def test_a_head_that_does_not_go_in_tells_nothing(speed_mm_per_s: float) -> None:
    still = driven(driven(START, 2.0), 1.0, 0.2, 0.2, speed_mm_per_s=speed_mm_per_s)
    assert tip_force.force_n(still) == 0.0
    assert not tip_force.is_pressing(still)


def test_a_switch_that_closes_tells_by_itself() -> None:
    assert not tip_force.is_pressing(driven(driven(START, 2.0), 1.0, 0.2, 0.2, touching=True))


def test_where_no_carina_may_be_it_is_friction() -> None:
    assert not tip_force.is_pressing(driven(driven(START, 2.0), 1.0, 0.2, 0.2, may_touch=False))
