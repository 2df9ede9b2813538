import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import Commands
from opensuction.twin import parameter, preset
from opensuction.twin.machine import machine
from opensuction.twin.machine.machine import MachineState
from tests.budget import simulated
from tests.twin.holding import DT_S, IDLE, hold_machine

VALUES = parameter.nominal(parameter.BENCH)
BENCH = preset.machine(VALUES)


def parked(head_mm: float = 0.0) -> MachineState:
    return preset.park(BENCH, VALUES, head_mm, seed=1, run=2).machine


def run(state: MachineState, commands: Commands, seconds: float) -> MachineState:
    return hold_machine(BENCH, state, commands, round(seconds / DT_S))


def test_a_parked_machine_stays_as_it_is() -> None:
    """But for laser and sensors, which keep reading, and the ticks that the coupling counts."""
    start = parked()
    later = run(start, IDLE, 1.0)
    assert later.coupling == start.coupling._replace(ticks=1000)
    same = later._replace(laser=start.laser, sensed=start.sensed, coupling=start.coupling)
    assert str(same) == str(start)


def test_the_head_waits_for_the_gear_s_play() -> None:
    start = parked()
    state = start
    while state.head_mm == start.head_mm:
        state = hold_machine(BENCH, state, IDLE._replace(insertion_v=12.0), 1)
    travel = state.insertion.position - start.insertion.position
    # One tick at this speed is up to 0.01 mm of it.
    assert travel == pytest.approx(VALUES["gear_backlash_mm"], abs=0.01)


def test_what_the_tip_presses_on_slows_the_head() -> None:
    free = BENCH._replace(airway=BENCH.airway._replace(carina_mm=1000.0))
    push = IDLE._replace(insertion_v=6.0)
    pressed, unhindered = parked(100.0), parked(100.0)
    ticks = 5600  # 4.5 s of them inside the gap
    pressed = hold_machine(BENCH, pressed, push, ticks)
    unhindered = hold_machine(free, unhindered, push, ticks)
    assert pressed.airway.contact_n > 0.2
    assert unhindered.airway.contact_n == 0.0
    # At steady speed each newton takes its voltage: v = k (V - friction - load).
    axis = BENCH.insertion_axis
    load_v = BENCH.load_v_per_n * pressed.airway.contact_n
    expected = axis.speed_per_v * (6.0 - axis.friction_v - load_v)
    # The buckled tip presses harder by only 0.07 N a second; the axis lags it by 20 ms.
    assert pressed.insertion.velocity == pytest.approx(expected, abs=0.1)
    assert unhindered.insertion.velocity == pytest.approx(0.783 * 5.5, rel=1e-3)


def test_contact_outlasts_the_reversal_until_the_gap_is_crossed() -> None:
    """What lets the gap be measured without a tip sensor: the head turns, the tip stays."""
    state = parked(100.0)
    while state.airway.contact_n < 0.15:  # short of buckling
        state = hold_machine(BENCH, state, IDLE._replace(insertion_v=12.0), 1)
    state = run(state, IDLE, 5.0)  # creep and drive come to rest
    turned_at, force = state.head_mm, state.airway.contact_n
    backed = 0.0
    while state.airway.contact_n >= BENCH.switch.open_n:
        if state.airway.contact_n > 0.99 * force:
            backed = turned_at - state.head_mm
        state = hold_machine(BENCH, state, IDLE._replace(insertion_v=-12.0), 1)
    widths = BENCH.transmission.widths_mm
    # Nothing gives way before the narrowest play has; the switch opens before all have.
    assert backed >= min(widths) - 0.1
    assert turned_at - state.head_mm < max(widths)


def test_the_switch_reports_what_presses_on_the_tip() -> None:
    state = parked(130.0)  # the tip is beyond the carina, but for the gap
    state = run(state, IDLE._replace(insertion_v=6.0), 3.0)
    assert state.airway.contact_n > BENCH.switch.close_n
    assert machine.read(BENCH, state).contact_closed
    assert not machine.read(BENCH, run(parked(), IDLE, 0.1)).contact_closed


def test_every_reading_of_a_sound_machine_is_valid() -> None:
    readings = machine.read(BENCH, parked())
    assert readings.head_valid
    assert readings.cam_valid
    assert readings.vacuum_valid
    assert readings.contact_valid


def test_suction_needs_pump_and_valve() -> None:
    pumping = IDLE._replace(pump_on=True, vacuum_mmhg=120.0)
    opened = AT_FULL_STROKE
    for commands, cam_rad, sucks in ((pumping, opened, True), (pumping, 0.0, False)):
        state = parked(80.0)
        state = state._replace(valve=state.valve._replace(position=cam_rad))
        state = run(state, commands._replace(valve_v=HOLDING_V if cam_rad else 0.0), 0.5)
        assert (state.airway.removed_ml > 0.0) is sucks
        assert (state.line.gas_ml > 0.0) is sucks
        assert state.line.vacuum_mmhg > 50.0
    state = parked(80.0)
    state = state._replace(valve=state.valve._replace(position=opened))
    state = run(state, IDLE._replace(valve_v=HOLDING_V), 0.5)
    assert state.airway.removed_ml == 0.0


AT_FULL_STROKE = math.radians(30.0)
HOLDING_V = VALUES["spring_preload_v"] + VALUES["spring_v_per_rad"] * AT_FULL_STROKE
"""Balances the spring at the full stroke; friction holds the rest."""


@simulated
@given(
    script=st.lists(
        st.tuples(
            st.floats(-24.0, 24.0),
            st.booleans(),
            st.floats(-24.0, 24.0),
            st.booleans(),
            st.booleans(),
            st.floats(0.0, 150.0),
        ),
        min_size=1,
        max_size=6,
    )
)
def test_whatever_is_commanded_the_machine_stays_physical(
    script: list[tuple[float, bool, float, bool, bool, float]],
) -> None:
    state = parked(60.0)
    for insertion_v, insertion_on, valve_v, valve_on, pump_on, vacuum in script:
        commands = Commands(0.0, insertion_v, insertion_on, 0.0, valve_v, valve_on, pump_on, vacuum)
        for _ in range(20):
            state = run(state, commands, 0.02)
            truth = machine.truth(BENCH, state)
            assert all(math.isfinite(value) for value in truth)
            assert 0.0 <= truth.valve_open_ratio <= 1.0
            assert 0.0 <= truth.tip_vacuum_mmhg <= state.line.vacuum_mmhg <= 155.0
            assert truth.contact_n >= 0.0
            assert truth.contact_n == 0.0 or truth.tip_mm > BENCH.airway.carina_mm
            slack = abs(state.insertion.position - state.head_mm)
            assert slack <= 0.5 * VALUES["gear_backlash_mm"] + 1e-9
            assert state.valve.position >= -BENCH.valve.stop_rad
