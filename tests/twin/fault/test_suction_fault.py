"""Each fault of the suction line does to the machine what its row says."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.fault.fault import Fault
from opensuction.twin.machine import suction_line
from opensuction.twin.machine.machine import Machine
from opensuction.twin.machine.suction_line import SuctionState
from tests.settled import settled
from tests.twin.fault.broken_machine import HEALTHY, faulty
from tests.twin.holding import DT_S

step = settled(suction_line.step)


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
        state = step(twin.line, state, pump_on, setpoint_mmhg, open_ratio, 0.0, DT_S)
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
