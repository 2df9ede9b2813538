"""The contact switch: threshold, hysteresis, chatter and the delay of its line."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel import random_stream
from opensuction.twin import parameter, preset
from opensuction.twin.machine import tip_sensor
from opensuction.twin.machine.tip_sensor import ContactSwitch, SwitchState

DT_S = 0.001
SWITCH = preset.machine(parameter.nominal(parameter.BENCH)).switch
SILENT = SWITCH._replace(bounce_s=0.0)
PROMPT = SWITCH._replace(latency_s=0.0)
PRESSED_N = 1.01 * SWITCH.close_n
BETWEEN_N = 0.5 * (SWITCH.close_n + SWITCH.open_n)

BOUNCE_TICKS = round(SWITCH.bounce_s / DT_S)
LATENCY_TICKS = round(SWITCH.latency_s / DT_S)


def readings(
    switch: ContactSwitch, forces_n: list[float], seed: int = 1
) -> tuple[list[bool], SwitchState]:
    """What is read after each tick, and the state at the end."""
    state = tip_sensor.released(random_stream.stream(seed, 7))
    read = []
    for force_n in forces_n:
        state = tip_sensor.step(switch, state, force_n, DT_S)
        read.append(state.reading)
    return read, state


def test_it_closes_at_its_force_after_its_latency() -> None:
    below, _ = readings(SILENT, [0.999 * SWITCH.close_n] * 50)
    assert not any(below)
    pressed, _ = readings(SILENT, [SWITCH.close_n] * 50)
    assert pressed == [False] * LATENCY_TICKS + [True] * (50 - LATENCY_TICKS)


def test_it_opens_a_little_below_the_force_that_closed_it() -> None:
    touching, _ = readings(SILENT, [PRESSED_N] * 20 + [BETWEEN_N] * 50)
    assert touching[-1]
    # The same force from below leaves it open.
    assert not any(readings(SILENT, [BETWEEN_N] * 50)[0])
    leaving, _ = readings(SILENT, [PRESSED_N] * 20 + [0.99 * SWITCH.open_n] * 20)
    assert leaving == ([False] * LATENCY_TICKS + [True] * 20 + [False] * (20 - LATENCY_TICKS))


@given(seed=st.integers(0, 2**32 - 1))
def test_it_bounces_no_longer_than_its_time_and_settles_closed(seed: int) -> None:
    read, _ = readings(PROMPT, [PRESSED_N] * 50, seed)
    assert all(read[BOUNCE_TICKS:])
    # The line delays the chatter, it does not swallow it.
    delayed, _ = readings(SWITCH, [PRESSED_N] * 50, seed)
    assert delayed == [False] * LATENCY_TICKS + read[:-LATENCY_TICKS]


def test_some_closings_bounce_and_some_do_not() -> None:
    first = [readings(PROMPT, [PRESSED_N] * 3, seed)[0] for seed in range(1, 101)]
    share_open = sum(not level for levels in first for level in levels) / 300
    # Three standard deviations of 300 draws.
    assert share_open == pytest.approx(SWITCH.bounce_open_ratio, abs=0.08)


def test_only_a_closing_draws_random_numbers_and_a_stream_repeats_itself() -> None:
    script = [0.0] * 5 + [PRESSED_N] * 10 + [0.0] * 5 + [PRESSED_N] * 10
    assert readings(SWITCH, script, seed=3) == readings(SWITCH, script, seed=3)
    assert readings(SWITCH, [0.0] * 50)[1].stream == random_stream.stream(1, 7)
