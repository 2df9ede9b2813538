import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.patient import gas_exchange, patient_preset
from opensuction.twin.patient.gas_exchange import LungState
from tests.settled import settled

DT_S = 0.01
step = settled(gas_exchange.step_lung)
ARDS = patient_preset.patient("adult-ards", 0, nominal=True).lung
OPEN = LungState(volume_ml=ARDS.relaxed_ml + 12.0 * ARDS.compliance_ml_per_cmh2o, closed_ml=0.0)


def held_at(pressure_cmh2o: float, start: LungState, seconds: float) -> LungState:
    """State after a time at one elastic pressure: as much gas goes out as units close."""
    state = start
    for _ in range(round(seconds / DT_S)):
        volume = ARDS.relaxed_ml - state.closed_ml + pressure_cmh2o * ARDS.compliance_ml_per_cmh2o
        state = step(ARDS, state._replace(volume_ml=volume), 0.0, DT_S)
    return state


def test_at_peep_nothing_closes() -> None:
    assert gas_exchange.pressure_cmh2o(ARDS, OPEN) == pytest.approx(12.0)
    assert held_at(12.0, OPEN, 60.0).closed_ml == 0.0


def test_closing_takes_seconds_and_reopening_minutes() -> None:
    lost = held_at(0.0, OPEN, 60.0).closed_ml
    assert held_at(0.0, OPEN, 1.0).closed_ml == pytest.approx(0.63 * lost, rel=0.01)
    closed = held_at(0.0, OPEN, 60.0)
    assert held_at(12.0, closed, 150.0).closed_ml == pytest.approx(0.368 * lost, rel=0.01)


def test_half_of_what_can_close_does_so_at_the_half_closing_pressure() -> None:
    pressure = ARDS.closing_cmh2o - ARDS.half_closing_cmh2o
    assert held_at(pressure, OPEN, 60.0).closed_ml == pytest.approx(0.5 * ARDS.closable_ml)


def test_closed_units_raise_the_pressure_of_the_same_gas() -> None:
    """So closing drives gas out through the airway: none vanishes."""
    closed = OPEN._replace(closed_ml=100.0)
    rise = gas_exchange.pressure_cmh2o(ARDS, closed) - gas_exchange.pressure_cmh2o(ARDS, OPEN)
    assert rise == pytest.approx(100.0 / ARDS.compliance_ml_per_cmh2o)


@given(volume=st.floats(0.0, 5000.0), suction=st.floats(-100.0, 1e5), dt_s=st.floats(1e-3, 0.1))
def test_no_suction_empties_a_lung(volume: float, suction: float, dt_s: float) -> None:
    state = LungState(volume_ml=volume, closed_ml=0.0)
    taken = gas_exchange.removable_ml_per_s(ARDS, state, suction, dt_s)
    assert 0.0 <= taken <= max(suction, 0.0)
    assert volume - taken * dt_s >= min(volume, gas_exchange.SEALED * ARDS.residual_ml) - 1e-9


def test_above_residual_volume_suction_takes_what_it_asks_for() -> None:
    assert gas_exchange.removable_ml_per_s(ARDS, OPEN, 250.0, DT_S) == 250.0
