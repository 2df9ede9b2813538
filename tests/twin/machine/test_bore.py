import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin import parameter, preset
from opensuction.twin.machine import suction_line
from opensuction.twin.machine.suction_line import EMPTY, Bore, BoreState, SuctionLine, SuctionState
from tests.settled import settled

DT_S = 0.001
BENCH = preset.machine(parameter.nominal(parameter.BENCH))
BORE = BENCH.bore
FREE = BENCH.line.bore_ml_per_s_per_root_mmhg
L_PER_MIN = 0.06


def plug(volume_ml: float, mucus: Bore = BORE, flow_ml_per_s: float = 0.0) -> BoreState:
    drag = suction_line.drag_mmhg_s_per_ml(mucus, volume_ml, flow_ml_per_s)
    return EMPTY._replace(mucus_ml=volume_ml, front_ml=volume_ml, drag_mmhg_s_per_ml=drag)


def settled_flow(mucus: Bore, state: BoreState, vacuum_mmhg: float) -> float:
    """Flow once the viscosity goes with it."""
    flow = 0.0
    for _ in range(200):
        state = plug(state.mucus_ml, mucus, flow)
        lost = lost_mmhg(mucus, state, vacuum_mmhg, FREE)
        flow = FREE * math.sqrt(vacuum_mmhg - lost)
    return flow


@given(
    path=st.lists(
        st.tuples(st.floats(0.0, 0.01), st.floats(0.0, 400.0), st.integers(1, 100)), max_size=12
    )
)
def test_what_comes_in_lies_there_or_is_in_the_canister(
    path: list[tuple[float, float, int]],
) -> None:
    state, entered = EMPTY, 0.0
    for mucus_ml, flow, ticks in path:
        for _ in range(ticks):
            before = state
            state = suction_line.step_bore(BORE, state, mucus_ml, flow, DT_S)
            entered += mucus_ml
            assert state.mucus_ml >= 0.0
            assert state.canister_ml >= before.canister_ml
            assert 0.0 <= state.tail_ml <= state.front_ml <= BORE.volume_ml
    assert state.mucus_ml + state.canister_ml == pytest.approx(entered, rel=1e-9, abs=1e-12)


def test_the_paper_s_bore_holds_19_ml_and_a_millilitre_fills_10_cm() -> None:
    assert BORE.volume_ml == pytest.approx(19.2, abs=0.05)  # [calc-line]
    assert suction_line.plug_mm(BORE, 1.0) == pytest.approx(104.0, abs=0.1)


def test_yield_holds_the_plugs_that_facts_say_it_holds() -> None:
    """At 120 mmHg: 10, 50 and 100 Pa block plugs longer than 1.4, .28 and .14 m."""
    for yield_pa, length_m in ((10.0, 1.4), (50.0, 0.28), (100.0, 0.14)):
        mucus_ml = length_m * 1000.0 / suction_line.plug_mm(BORE, 1.0)
        thick = BORE._replace(yield_pa=yield_pa)
        assert suction_line.holding_mmhg(thick, mucus_ml) == pytest.approx(120.0, rel=0.02)
        assert settled_flow(thick, plug(1.05 * mucus_ml), 120.0) == 0.0
        assert settled_flow(thick, plug(0.9 * mucus_ml), 120.0) > 0.0


def test_drag_at_the_stated_shear_rate_is_hagen_and_poiseuille_s() -> None:
    """A 5 cm plug of 1 Pa s lets 1.2 mL/s through at 120 mmHg, were it Newtonian [calc-plug].

    Beyond the 5 cm that are in the uptake.
    """
    mucus_ml = 100.0 / suction_line.plug_mm(BORE, 1.0)
    speed = suction_line.STATED_PER_S * BORE.diameter_mm / 8.0
    flow = speed * suction_line.area_mm2(BORE) / 1000.0
    drag = suction_line.drag_mmhg_s_per_ml(BORE, mucus_ml, flow) / suction_line.PROFILE
    assert 120.0 / drag == pytest.approx(1.2, abs=0.03)
    # Thinner the faster it flows.
    assert suction_line.drag_mmhg_s_per_ml(BORE, mucus_ml, 10.0 * flow) < 0.3 * drag


def test_more_mucus_lets_less_through() -> None:
    flows = [settled_flow(BORE, plug(ml), 120.0) for ml in (0.0, 0.55, 0.7, 1.2, 3.0)]
    assert flows[0] == pytest.approx(FREE * math.sqrt(120.0))
    assert all(b < 0.8 * a for a, b in itertools.pairwise(flows))


def test_a_plug_travels_before_it_arrives_and_stays_when_nothing_flows() -> None:
    state = suction_line.step_bore(BORE, EMPTY, 0.5, 0.0, DT_S)
    assert (state.mucus_ml, state.front_ml) == (0.5, 0.5)
    flow, ticks = 50.0, 0
    while state.canister_ml == 0.0:
        state = suction_line.step_bore(BORE, state, 0.0, flow, DT_S)
        ticks += 1
    assert ticks * DT_S == pytest.approx((BORE.volume_ml - 0.5) / flow, abs=2.0 * DT_S)
    held = suction_line.step_bore(BORE, state, 0.0, 0.0, 60.0)
    assert held._replace(drag_mmhg_s_per_ml=state.drag_mmhg_s_per_ml) == state
    # At rest it is as thick as at the slowest shear.
    assert held.drag_mmhg_s_per_ml > state.drag_mmhg_s_per_ml > 0.0
    for _ in range(20):
        state = suction_line.step_bore(BORE, state, 0.0, flow, DT_S)
    assert state.mucus_ml == 0.0
    assert state.canister_ml == pytest.approx(0.5, rel=1e-9)


step = settled(suction_line.step)
lost_mmhg = settled(suction_line.lost_mmhg)


def signature(
    line: SuctionLine = BENCH.line, mucus: Bore = BORE, clogged_ml: float = 0.0
) -> tuple[float, float]:
    """Line vacuum and flow (L/min) after 20 s with the valve open at a set point of 120 mmHg."""
    state = SuctionState(vacuum_mmhg=0.0, gas_ml_per_s=0.0, gas_ml=0.0)
    for _ in range(20_000):
        clog = plug(clogged_ml, mucus, state.gas_ml_per_s)
        lost = lost_mmhg(mucus, clog, state.vacuum_mmhg, FREE)
        state = step(line, state, True, 120.0, 1.0, lost, DT_S)
    return state.vacuum_mmhg, L_PER_MIN * state.gas_ml_per_s


def test_every_fault_of_the_line_has_a_signature_of_its_own() -> None:
    """In vacuum and flow: a clog keeps its vacuum without flow, the others lose both."""
    sound_mmhg, sound_l = signature()
    clog_mmhg, clog_l = signature(mucus=BORE._replace(yield_pa=100.0), clogged_ml=2.0)
    assert clog_l == 0.0
    assert 120.0 < clog_mmhg < 125.0 < 1.7 * sound_mmhg
    # The pump's inlet closed: no vacuum is made, nothing flows.
    full_mmhg, full_l = signature(BENCH.line._replace(pump_free_ml_per_s=0.0))
    assert (full_mmhg, full_l) == (0.0, 0.0)
    leak = BENCH.line._replace(leak_ml_per_s_per_mmhg=3.0)
    weak = BENCH.line._replace(pump_free_ml_per_s=100.0, pump_occluded_mmhg=120.0)
    for line in (leak, weak):
        mmhg, litres = signature(line)
        assert 5.0 < mmhg < 0.7 * sound_mmhg
        assert 2.0 < litres < 0.9 * sound_l
    # With the valve closed a leak and a weak pump part: the pump reaches its own vacuum.
    closed = {}
    for name, line in (("leak", leak), ("weak", weak)):
        state = SuctionState(vacuum_mmhg=0.0, gas_ml_per_s=0.0, gas_ml=0.0)
        for _ in range(20_000):
            state = step(line, state, True, 120.0, 0.0, 0.0, DT_S)
        closed[name] = state.vacuum_mmhg
    assert closed["leak"] < 90.0 < closed["weak"]
