"""Messages that are the last one again and again, by sensors with noise and without."""

import numpy as np
import pytest

from opensuction.safety.watch import bus_watch
from opensuction.safety.watch.bus_watch import DEAD_TICKS, STALE_TICKS, START, BusWatch
from tests.settled import settled

DT_S = 0.001


step = settled(bus_watch.step)


def heard(vacuum_mmhg: np.ndarray) -> list[BusWatch]:
    """State after each reading of the line's vacuum, all other sensors at rest."""
    state, states = START, []
    for change in np.diff(vacuum_mmhg):
        state = step(state, float(change), bool(change == 0.0), DT_S)
        states.append(state)
    return states


def noisy(sigma_mmhg: float, step_mmhg: float, ticks: int, seed: int = 7) -> np.ndarray:
    """A vacuum that is held, through a converter."""
    noise = np.random.default_rng(seed).normal(100.0, sigma_mmhg, ticks)
    return step_mmhg * np.round(noise / step_mmhg)


@pytest.mark.parametrize(("sigma_mmhg", "step_mmhg"), [(1.0, 0.125), (0.1, 0.125), (0.06, 0.125)])
def test_a_bus_that_repeats_itself_is_dead_where_there_was_noise(
    sigma_mmhg: float, step_mmhg: float
) -> None:
    sound = noisy(sigma_mmhg, step_mmhg, 5000)
    states = heard(np.concatenate([sound, np.full(400, sound[-1])]))
    assert not any(bus_watch.is_dead(one) for one in states[: sound.size])
    dead = next(i for i, one in enumerate(states) if bus_watch.is_dead(one))
    assert sound.size - 40 + DEAD_TICKS <= dead <= sound.size + DEAD_TICKS
    assert all(bus_watch.is_dead(one) for one in states[dead:])


def test_noise_never_looks_dead() -> None:
    """A minute of each, from noise far above a converter's step to half of it."""
    for seed, sigma_mmhg in enumerate((3.0, 1.0, 0.3, 0.1, 0.06)):
        states = heard(noisy(sigma_mmhg, 0.125, 60_000, seed))
        assert max(one.stale_ticks for one in states) < DEAD_TICKS


@pytest.mark.parametrize("per_s", [0.0, 0.2, 2.0, 20.0])
def test_a_sensor_without_noise_is_not_dead_for_resting(per_s: float) -> None:
    """Its line rests, leaks slowly in a converter's steps, or settles without any."""
    time_s = DT_S * np.arange(8000)
    stepped = 0.125 * np.round((100.0 - per_s * time_s) / 0.125)
    settling = 100.0 + 20.0 * np.exp(-time_s / 0.02)
    for vacuum in (stepped, settling):
        assert not any(bus_watch.is_dead(one) for one in heard(vacuum))


def test_what_a_head_that_should_move_repeats_is_stale_with_and_without_noise() -> None:
    states = heard(np.full(STALE_TICKS + 2, 100.0))
    assert [bus_watch.is_stale(one) for one in states].index(True) == STALE_TICKS - 1
    assert not bus_watch.is_stale(bus_watch.step(states[-1], 0.5, False, DT_S))
