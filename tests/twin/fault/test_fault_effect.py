"""Each fault does to the machine what its row says."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel import random_stream
from opensuction.kernel.commands import Commands
from opensuction.twin import preset
from opensuction.twin.airway import tip
from opensuction.twin.fault import fault_effect
from opensuction.twin.fault.fault import Fault
from opensuction.twin.machine import (
    contact_switch,
    machine,
    suction_line,
    transmission,
    valve_mechanism,
)
from opensuction.twin.machine.machine import Machine, MachineState
from opensuction.twin.machine.suction_line import SuctionState
from opensuction.twin.parameter import BENCH, nominal

DT_S = 0.001
VALUES = nominal(BENCH)
HEALTHY = preset.machine(VALUES)
IDLE = Commands(
    head_mm=0.0,
    insertion_v=0.0,
    insertion_on=True,
    cam_rad=0.0,
    valve_v=0.0,
    valve_on=False,
    pump_on=False,
    vacuum_mmhg=0.0,
)
OPENING = IDLE._replace(valve_v=24.0, valve_on=True)
PUSHING = IDLE._replace(insertion_v=12.0)


def parked(head_mm: float = 0.0) -> MachineState:
    return preset.parked(HEALTHY, VALUES, head_mm, seed=1, run=2).machine


def run(twin: Machine, state: MachineState, commands: Commands, seconds: float) -> MachineState:
    for _ in range(round(seconds / DT_S)):
        state = machine.step(twin, state, commands, DT_S)
    return state


def faulty(fault: Fault, strength: float = 0.0, twin: Machine = HEALTHY) -> Machine:
    return fault_effect.faulty(twin, fault, strength)


def readings_of_the_switch(twin: Machine, forces_n: list[float]) -> list[bool]:
    state = contact_switch.released(random_stream.stream(1, 1))
    seen = []
    for force_n in forces_n:
        state = contact_switch.step(twin.switch, state, force_n, DT_S)
        seen.append(bool(state.reading))
    return seen


TOUCH = [0.0] * 100 + [0.2] * 200 + [0.0] * 200
"""Nothing, a firm touch, nothing."""


def test_a_switch_stuck_open_sees_no_touch() -> None:
    assert any(readings_of_the_switch(HEALTHY, TOUCH))
    assert not any(readings_of_the_switch(faulty(Fault.SWITCH_STUCK_OPEN), TOUCH))


def test_a_switch_stuck_closed_sees_one_everywhere() -> None:
    latency = math.ceil(HEALTHY.switch.latency_s / DT_S) + 1
    assert all(readings_of_the_switch(faulty(Fault.SWITCH_STUCK_CLOSED), TOUCH)[latency:])


@given(st.floats(0.05, 0.95))
def test_a_bridged_switch_is_closed_for_its_share_of_the_time(share: float) -> None:
    seen = readings_of_the_switch(faulty(Fault.SWITCH_BRIDGED, share), [0.0] * 1000)
    # Four standard deviations of a thousand draws.
    assert np.mean(seen) == pytest.approx(share, abs=4.0 * math.sqrt(share * (1.0 - share) / 1000))


def test_a_sticking_switch_does_not_open_again() -> None:
    seen = readings_of_the_switch(faulty(Fault.SWITCH_STICKING), TOUCH)
    assert not any(seen[:100])
    assert all(seen[-200:])


def test_a_bouncing_switch_chatters_for_its_time_and_then_rests() -> None:
    seen = readings_of_the_switch(faulty(Fault.SWITCH_BOUNCING, 0.1), TOUCH)
    latency = round(HEALTHY.switch.latency_s / DT_S)
    chatter, rest = seen[100 + latency : 200 + latency], seen[201 + latency : 300 + latency]
    assert 20 < sum(chatter) < 80  # half of the time
    assert all(rest)


def test_a_stiff_switch_needs_its_force() -> None:
    stiff = faulty(Fault.SWITCH_STIFF, 0.25)
    assert not any(readings_of_the_switch(stiff, [0.24] * 100))
    assert any(readings_of_the_switch(stiff, [0.25] * 100))


def test_a_late_switch_is_read_after_its_delay() -> None:
    seen = readings_of_the_switch(faulty(Fault.SWITCH_LATE, 0.05), TOUCH)
    assert not any(seen[:150])
    assert any(seen[150:160])


def force_n(twin: Machine, free_tip_mm: float) -> float:
    return float(tip.touch(twin.airway.tip, twin.airway.carina_mm, free_tip_mm).force_n)


def test_a_tip_that_misses_the_carina_meets_nothing_until_deeper() -> None:
    carina_mm = HEALTHY.airway.carina_mm
    missed = faulty(Fault.CARINA_MISSED, 40.0)
    assert force_n(HEALTHY, carina_mm + 0.5) > 0.0
    assert force_n(missed, carina_mm + 39.9) == 0.0
    assert force_n(missed, carina_mm + 40.5) == pytest.approx(force_n(HEALTHY, carina_mm + 0.5))


def test_a_displaced_tube_brings_the_carina_nearer() -> None:
    carina_mm = HEALTHY.airway.carina_mm
    assert force_n(faulty(Fault.TUBE_DISPLACED, 20.0), carina_mm - 19.0) > 0.0


@given(st.floats(0.0, 50.0))
def test_a_buckling_tip_never_presses_enough_to_close_the_switch(overlap_mm: float) -> None:
    soft = faulty(Fault.TIP_BUCKLING, 0.03)
    assert force_n(soft, soft.airway.carina_mm + overlap_mm) <= 0.03 < soft.switch.close_n


def test_a_detached_tip_leaves_a_shorter_catheter_without_a_switch() -> None:
    short = faulty(Fault.TIP_DETACHED, 5.0)
    behind_mm = 40.0
    whole_mm = transmission.depth_mm(HEALTHY.transmission, behind_mm)
    assert transmission.depth_mm(short.transmission, behind_mm) == pytest.approx(whole_mm - 5.0)
    assert not any(readings_of_the_switch(short, TOUCH))


def test_a_kink_narrows_the_bore_rubs_and_gives_way() -> None:
    """Turbulent flow goes with the bore to the power 19/7 (Blasius), mucus with its fourth."""
    kinked = faulty(Fault.CATHETER_KINKED, 0.5)
    flows = [suction_line.bore_flow_ml_per_s(m.line, 100.0, 1.0) for m in (kinked, HEALTHY)]
    assert flows[0] / flows[1] == pytest.approx(0.5 ** (19.0 / 7.0))
    uptakes = [m.airway.uptake_ml_per_s_per_mmhg for m in (kinked, HEALTHY)]
    assert uptakes[0] / uptakes[1] == pytest.approx(0.5**4)
    added_v = kinked.insertion_axis.friction_v - HEALTHY.insertion_axis.friction_v
    assert added_v == pytest.approx(0.5 * fault_effect.KINK_N * HEALTHY.load_v_per_n)
    moved = [
        transmission.step(m.transmission, parked().transmission, 20.0, DT_S).tip_mm
        for m in (kinked, HEALTHY)
    ]
    assert moved[0] < moved[1]


def test_a_jam_holds_the_head_and_raises_the_current() -> None:
    free = run(HEALTHY, parked(), PUSHING, 0.5)
    held = run(faulty(Fault.CATHETER_JAMMED, 8.0), parked(), PUSHING, 0.5)
    assert free.insertion.position > 3.0
    assert held.insertion.position == 0.0
    currents = [machine.read(HEALTHY, state).insertion_current_a for state in (held, free)]
    assert currents[0] > 5.0 * currents[1]
    most_a = HEALTHY.amperes_per_v * min(12.0, HEALTHY.insertion_axis.force_v)
    assert currents[0] == pytest.approx(most_a)


def test_a_jam_weaker_than_the_drive_only_slows_it() -> None:
    slowed = run(faulty(Fault.CATHETER_JAMMED, 1.0), parked(), PUSHING, 0.5)
    free = run(HEALTHY, parked(), PUSHING, 0.5)
    assert 0.0 < slowed.insertion.position < free.insertion.position


def test_another_route_of_the_conduit_has_another_gap() -> None:
    """Head travel from a turn until the last play has taken hold."""
    other = faulty(Fault.CONDUIT_REROUTED, 1.5)
    widths = np.divide(other.transmission.widths_mm, HEALTHY.transmission.widths_mm)
    np.testing.assert_allclose(widths, 1.5)
    assert other.transmission.stretch_mm == pytest.approx(1.5 * HEALTHY.transmission.stretch_mm)


def test_a_seized_motor_stops_where_it_is_and_draws_its_full_current() -> None:
    moving = run(HEALTHY, parked(), PUSHING, 0.3)
    seized = faulty(Fault.MOTOR_STALLED)
    at_once = machine.step(seized, moving, PUSHING, DT_S)
    assert at_once.insertion.velocity == 0.0
    # It stops within the tick: less than a tick's way at full speed.
    assert abs(at_once.insertion.position - moving.insertion.position) < 0.02
    later = run(seized, at_once, PUSHING, 0.2)
    assert later.insertion.position == at_once.insertion.position
    assert later.insertion.drive_v == min(12.0, HEALTHY.insertion_axis.force_v)


def test_a_broken_winding_lets_the_motor_run_out() -> None:
    moving = run(HEALTHY, parked(), PUSHING, 0.3)
    later = run(faulty(Fault.MOTOR_LOST), moving, PUSHING, 0.5)
    assert later.insertion.velocity == 0.0
    assert later.insertion.drive_v == 0.0
    assert later.insertion.position > moving.insertion.position


def test_a_weak_drive_gives_less_force() -> None:
    weak = faulty(Fault.MOTOR_WEAK, 0.6)
    held = run(faulty(Fault.MOTOR_STALLED, twin=weak), parked(), PUSHING, 0.1)
    assert held.insertion.drive_v == pytest.approx(0.4 * HEALTHY.insertion_axis.force_v)


def test_swapped_wires_turn_the_motor_the_other_way() -> None:
    forth = run(HEALTHY, parked(), PUSHING, 0.3).insertion
    back = run(faulty(Fault.MOTOR_REVERSED), parked(), PUSHING, 0.3).insertion
    assert back.position == pytest.approx(-forth.position)
    assert back.drive_v == pytest.approx(-forth.drive_v)


def test_without_its_gear_the_head_stays_while_the_motor_turns() -> None:
    moving = run(HEALTHY, parked(), PUSHING, 0.3)
    later = run(faulty(Fault.GEAR_LOST), moving, PUSHING, 0.5)
    assert later.head_mm == moving.head_mm
    assert later.insertion.position > moving.insertion.position + 3.0
    seen = machine.read(HEALTHY, later)
    assert seen.head_mm - seen.carriage_mm > 3.0


def test_a_worn_gear_loses_more_at_each_turn() -> None:
    worn = faulty(Fault.GEAR_WORN, 4.0)
    forth = run(worn, parked(), PUSHING, 1.0)
    travelled = forth.insertion.position - parked().insertion.position
    lost = travelled - (forth.head_mm - parked().head_mm)
    # Parked after a retract: the whole play lies before it.
    assert lost == pytest.approx(worn.gear_backlash_mm, abs=4.0)
    assert lost > HEALTHY.gear_backlash_mm


def test_a_rack_ends_where_it_ends() -> None:
    ended = preset.racked(HEALTHY, 0.0)
    pulled = run(ended, parked(), IDLE._replace(insertion_v=-24.0), 1.5)
    assert pulled.insertion.position == -preset.BEHIND_PARK_MM
    assert pulled.insertion.velocity == 0.0


def opened(twin: Machine, state: MachineState) -> float:
    return float(valve_mechanism.open_ratio(twin.valve, state.valve.position))


def test_a_slide_that_sticks_does_not_answer_to_the_cam() -> None:
    full = run(HEALTHY, parked(), OPENING, 3.0)
    assert opened(HEALTHY, full) == 1.0
    for ratio in (0.3, 1.0):
        stuck = faulty(Fault.VALVE_STUCK_OPEN, ratio)
        shut = run(stuck, full, IDLE, 3.0)
        assert shut.valve.position <= 0.0  # the cam is back, and its encoder says so
        assert opened(stuck, shut) == ratio
    parted = faulty(Fault.VALVE_STUCK_CLOSED, 0.0)
    assert opened(parted, run(parted, parked(), OPENING, 3.0)) == 0.0


def test_a_slow_valve_takes_as_much_longer_as_it_has_lost_speed() -> None:
    slow = faulty(Fault.VALVE_SLOW, 0.75)
    brief = 0.3
    quick = run(HEALTHY, parked(), OPENING, brief).valve
    # Slowed fourfold in speed and in time to reach it, it gets there in four times the time... of
    # steady motion; its way is a quarter but for what the start takes.
    tau_s = HEALTHY.valve_axis.time_constant_s
    late = run(slow, parked(), OPENING, brief).valve
    assert late.position / quick.position == pytest.approx(0.25, rel=2.0 * tau_s / brief)


def test_a_seized_cam_stays_where_it_is() -> None:
    half = run(HEALTHY, parked(), OPENING, 0.2)
    jammed = faulty(Fault.VALVE_JAMMED)
    at_once = machine.step(jammed, half, OPENING, DT_S)
    later = run(jammed, at_once, IDLE, 2.0)
    assert later.valve.position == at_once.valve.position > 0.0


def test_a_valve_motor_without_current_leaves_the_valve_to_its_spring() -> None:
    full = run(HEALTHY, parked(), OPENING, 3.0)
    shut = run(faulty(Fault.VALVE_MOTOR_LOST), full, OPENING, 3.0)
    assert opened(HEALTHY, shut) == 0.0


def test_without_its_spring_the_valve_stays_open_when_its_torque_is_off() -> None:
    full = run(HEALTHY, parked(), OPENING, 3.0)
    assert opened(HEALTHY, run(HEALTHY, full, IDLE, 3.0)) == 0.0
    broken = faulty(Fault.VALVE_SPRING_BROKEN)
    assert opened(broken, run(broken, full, IDLE, 3.0)) == 1.0


def line_after(
    twin: Machine,
    seconds: float,
    pump_on: bool = True,
    setpoint_mmhg: float = 100.0,
    from_mmhg: float = 0.0,
    open_ratio: float = 0.0,
) -> SuctionState:
    state = SuctionState(vacuum_mmhg=from_mmhg, gas_ml_per_s=0.0, gas_ml=0.0)
    for _ in range(round(seconds / DT_S)):
        state = suction_line.step(twin.line, state, pump_on, setpoint_mmhg, open_ratio, 0.0, DT_S)
    return state


def test_a_runaway_pump_obeys_neither_switch_nor_set_point() -> None:
    """It ends where the relief valve lets in what it draws."""
    line = HEALTHY.line
    wild = faulty(Fault.PUMP_RUNAWAY)
    ended = line_after(wild, 30.0, pump_on=False, setpoint_mmhg=0.0).vacuum_mmhg
    drawn = line.pump_free_ml_per_s * (1.0 - ended / line.pump_occluded_mmhg)
    let_in = line.relief_ml_per_s_per_mmhg * (ended - line.relief_mmhg)
    assert drawn == pytest.approx(let_in + line.leak_ml_per_s_per_mmhg * ended, rel=1e-3)
    assert line.relief_mmhg < ended < 1.1 * line.relief_mmhg


def test_without_relief_a_runaway_pump_reaches_what_it_can() -> None:
    both = faulty(Fault.RELIEF_FAILED, twin=faulty(Fault.PUMP_RUNAWAY))
    line = both.line
    ended = line_after(both, 60.0).vacuum_mmhg
    slope = line.pump_free_ml_per_s / line.pump_occluded_mmhg
    most = line.pump_free_ml_per_s / (slope + line.leak_ml_per_s_per_mmhg)
    assert ended == pytest.approx(most, rel=1e-3)
    assert ended > 400.0


def test_a_failed_regulator_neither_limits_nor_vents() -> None:
    failed = faulty(Fault.REGULATOR_FAILED)
    assert line_after(failed, 20.0).vacuum_mmhg > HEALTHY.line.relief_mmhg
    vented = line_after(HEALTHY, 2.0, pump_on=False, setpoint_mmhg=0.0, from_mmhg=100.0)
    held = line_after(failed, 2.0, pump_on=False, setpoint_mmhg=0.0, from_mmhg=100.0)
    assert vented.vacuum_mmhg < 5.0
    assert held.vacuum_mmhg > 50.0


@given(st.floats(0.05, 0.99))
def test_a_weak_pump_moves_its_share(lost: float) -> None:
    weak = faulty(Fault.PUMP_WEAK, lost)
    assert weak.line.pump_free_ml_per_s == pytest.approx(
        (1.0 - lost) * HEALTHY.line.pump_free_ml_per_s
    )
    assert weak.line.pump_occluded_mmhg == HEALTHY.line.pump_occluded_mmhg


def test_a_lost_pump_draws_nothing() -> None:
    assert line_after(faulty(Fault.PUMP_LOST), 5.0).vacuum_mmhg == 0.0


@given(st.floats(0.02, 10.0))
def test_a_leak_lets_vacuum_decay_exponentially(leak: float) -> None:
    leaky = faulty(Fault.LINE_LEAK, leak)
    rate = leaky.line.leak_ml_per_s_per_mmhg * leaky.line.mmhg_per_ml
    ended = line_after(leaky, 0.2, pump_on=False, from_mmhg=100.0).vacuum_mmhg
    assert leaky.line.leak_ml_per_s_per_mmhg == HEALTHY.line.leak_ml_per_s_per_mmhg + leak
    # Backward Euler of a millisecond: each step is off by half a square of rate times step.
    assert math.log(ended / 100.0) == pytest.approx(-0.2 * rate, rel=rate * DT_S)


def test_a_clog_lets_through_its_share() -> None:
    clogged = faulty(Fault.LINE_CLOGGED, 0.9)
    flows = [suction_line.bore_flow_ml_per_s(m.line, 100.0, 1.0) for m in (clogged, HEALTHY)]
    assert flows[0] / flows[1] == pytest.approx(0.1)


def test_a_full_canister_shuts_the_pump_off_and_leaves_little_gas() -> None:
    full, half = faulty(Fault.CANISTER_FULL, 1.0), faulty(Fault.CANISTER_FULL, 0.5)
    assert line_after(full, 5.0).vacuum_mmhg == 0.0
    assert half.line.mmhg_per_ml == pytest.approx(2.0 * HEALTHY.line.mmhg_per_ml)
    assert half.line.pump_free_ml_per_s == HEALTHY.line.pump_free_ml_per_s
    losses = [
        100.0 - line_after(m, 0.005, pump_on=False, from_mmhg=100.0, open_ratio=1.0).vacuum_mmhg
        for m in (half, HEALTHY)
    ]
    assert losses[0] / losses[1] == pytest.approx(2.0, rel=0.1)
