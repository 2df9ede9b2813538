"""The drives' own watchdog: patient with short silences, and out with the catheter after long."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import Commands
from opensuction.twin import preset
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine import fail_safe, machine
from opensuction.twin.machine.fail_safe import (
    BRAKING_MM_PER_S2,
    INWARDS_MM,
    LISTENING,
    SILENCE_S,
    SPEED_SHARE,
    WatchdogState,
)
from opensuction.twin.machine.machine import Machine, MachineState
from opensuction.twin.parameter import BENCH, CLINICAL, nominal
from tests.settled import settled
from tests.twin.holding import hold_machine

DT_S = 0.001
VALUES = nominal(BENCH)
MACHINE = preset.machine(VALUES)
WATCHDOG = fail_safe.of(MACHINE, 0.0)
FAST_VALUES = nominal(CLINICAL)
FAST = preset.machine(FAST_VALUES)
FAST_WATCHDOG = fail_safe.of(FAST, 0.0)
SILENCE_TICKS = round(SILENCE_S / DT_S)
VALVE_OPEN = Commands(
    head_mm=0.0,
    insertion_v=0.0,
    insertion_on=True,
    cam_rad=0.0,
    valve_v=24.0,
    valve_on=True,
    pump_on=True,
    vacuum_mmhg=100.0,
)


step = settled(fail_safe.step)
commands = settled(fail_safe.commands)
read = settled(machine.read)


def after(silences: list[int]) -> WatchdogState:
    """State after silences of so many ticks, a command after each."""
    state = LISTENING
    for ticks in silences:
        for heard in (*[False] * ticks, True):
            state = step(WATCHDOG, state, heard, True, 40.0, DT_S)
    return state


@given(st.lists(st.integers(0, SILENCE_TICKS), max_size=20))
def test_short_silences_are_ridden_out(silences: list[int]) -> None:
    assert not after(silences).alone


@pytest.mark.requirement("OS-R39")
def test_a_longer_silence_is_acted_on_and_later_commands_change_nothing() -> None:
    assert not after([SILENCE_TICKS]).alone
    assert after([SILENCE_TICKS + 1]).alone
    assert after([SILENCE_TICKS + 1, 0, 0, 0]).alone


def test_a_loss_of_mains_is_acted_on_at_once() -> None:
    assert fail_safe.step(WATCHDOG, LISTENING, True, False, 40.0, DT_S).alone


def alone(
    powered: bool, seconds: float, driven: Machine = MACHINE
) -> tuple[MachineState, Commands]:
    """A machine left to its drives at full suction, the head at 40 mm. driven: as its drives are
    then.
    """
    body = preset.park(MACHINE, VALUES, 40.0, seed=1, run=2).machine
    body = hold_machine(MACHINE, body, VALVE_OPEN, 3000)
    assert body.line.vacuum_mmhg > 50.0
    state = LISTENING
    orders = VALVE_OPEN
    for _ in range(round(seconds / DT_S)):
        head_mm = read(driven, body).head_mm
        state = step(WATCHDOG, state, False, powered, head_mm, DT_S)
        orders = VALVE_OPEN
        if state.alone:
            orders = commands(WATCHDOG, state, powered, head_mm, 0.0)
        body = hold_machine(driven, body, orders, 1)
    return body, orders


@pytest.mark.requirement("OS-R39")
def test_with_energy_the_head_comes_home_the_valve_shuts_and_the_line_is_vented() -> None:
    body, orders = alone(powered=True, seconds=40.0 / WATCHDOG.out_mm_per_s + 2.0)
    assert abs(body.insertion.position) < 1.0
    assert not orders.insertion_on
    truth = machine.truth(MACHINE, body)
    assert truth.valve_open_ratio == 0.0
    assert truth.line_vacuum_mmhg < 5.0


def test_without_energy_the_head_stays_and_nothing_sucks() -> None:
    body, orders = alone(powered=False, seconds=4.0)
    assert body.insertion.position == pytest.approx(40.0, abs=0.1)
    assert not orders.insertion_on
    truth = machine.truth(MACHINE, body)
    assert truth.valve_open_ratio == 0.0
    assert truth.line_vacuum_mmhg < 5.0


@pytest.mark.requirement("OS-R39")
def test_a_head_that_the_motor_drives_in_instead_of_out_is_let_go() -> None:
    reversed_motor = ROWS[Fault.MOTOR_REVERSED].change_machine(MACHINE, 0.0)
    body, orders = alone(powered=True, seconds=3.0, driven=reversed_motor)
    assert INWARDS_MM < body.insertion.position - 40.0 < 2.0 * INWARDS_MM
    assert not orders.insertion_on


@given(st.lists(st.floats(40.0, 40.0 + INWARDS_MM), max_size=30))
def test_a_head_that_coasts_is_drawn_out_all_the_same(coasting_mm: list[float]) -> None:
    state = step(WATCHDOG, LISTENING, False, False, 40.0, DT_S)
    for head_mm in coasting_mm:
        state = step(WATCHDOG, state, False, False, head_mm, DT_S)
    assert fail_safe.commands(WATCHDOG, state, True, 40.0, 0.0).insertion_on


@pytest.mark.requirement("OS-R39")
@pytest.mark.parametrize("speed_mm_per_s", [10.0, 30.0, 40.0, 50.0, 60.0])
def test_a_head_at_any_speed_coasts_and_is_drawn_out(speed_mm_per_s: float) -> None:
    """A sound drive: however fast it moved in as the controller died, it is not let go."""
    body = preset.park(FAST, FAST_VALUES, 0.0, seed=1, run=2).machine
    state, wanted_mm = LISTENING, 0.0
    for tick in range(4000):
        head_mm = read(FAST, body).head_mm
        heard = tick < 1000
        state = step(FAST_WATCHDOG, state, heard, True, head_mm, DT_S)
        if state.alone:
            orders = commands(FAST_WATCHDOG, state, True, head_mm, 0.0)
        elif heard:
            wanted_mm += speed_mm_per_s * DT_S
            volts = FAST.insertion_axis.voltage_limit_v
            lag_v = 10.0 * (wanted_mm - head_mm)
            orders = VALVE_OPEN._replace(insertion_v=min(max(lag_v, -volts), volts), valve_on=False)
        body = hold_machine(FAST, body, orders, 1)
        assert not state.astray
    assert machine.read(FAST, body).head_mm < 1.0


@pytest.mark.parametrize("speed_mm_per_s", [0.0, 30.0, 60.0])
def test_a_head_that_goes_further_than_its_speed_carries_it_is_let_go(
    speed_mm_per_s: float,
) -> None:
    """Pushed in on and on: by twice the way that a sound drive needs, and by 3 mm at least."""
    state, head_mm, gone_mm = LISTENING, 0.0, 0.0
    for tick in range(2000):
        heard = tick < 500
        head_mm += max(speed_mm_per_s, 5.0 * (not heard)) * DT_S
        state = step(FAST_WATCHDOG, state, heard, True, head_mm, DT_S)
        if state.astray:
            gone_mm = head_mm - state.from_mm
            break
    fastest_mm_per_s = FAST_WATCHDOG.out_mm_per_s / SPEED_SHARE
    coasts_mm = min(speed_mm_per_s, fastest_mm_per_s) ** 2 / (2.0 * BRAKING_MM_PER_S2)
    assert gone_mm == pytest.approx(max(INWARDS_MM, coasts_mm), rel=0.05)


@given(st.floats(-50.0, 200.0), st.floats(-300.0, 300.0))
def test_the_drives_never_push_in(head_mm: float, ramp_mm: float) -> None:
    before = LISTENING._replace(silent_s=1.0, alone=True, alone_s=1.0, ramp_mm=ramp_mm)
    state = step(WATCHDOG, before, False, True, head_mm, DT_S)
    assert fail_safe.commands(WATCHDOG, state, True, head_mm, 0.0).insertion_v <= 0.0
