import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.patient import ventilator
from opensuction.twin.patient.ventilator import Airflow, Supply

EXPIRATION = Supply(
    target_cmh2o=6.0, source_cmh2o_s_per_ml=0.014, limit_ml_per_s=500.0, valve_cmh2o_s_per_ml=0.004
)
TUBE = 2e-6
LUNG = 0.009


def suck(ml_per_s: float, lung_cmh2o: float = 6.0) -> Airflow:
    return ventilator.solve(EXPIRATION, TUBE, lung_cmh2o, LUNG, ml_per_s)


@given(
    target=st.floats(0.0, 60.0),
    lung_cmh2o=st.floats(-30.0, 60.0),
    suction=st.floats(0.0, 1000.0),
    tube=st.floats(0.0, 1e-3),
    limit=st.floats(0.0, 3000.0),
)
def test_what_flows_in_flows_out_and_pressures_fit_the_flows(
    target: float, lung_cmh2o: float, suction: float, tube: float, limit: float
) -> None:
    supply = EXPIRATION._replace(target_cmh2o=target, limit_ml_per_s=limit)
    found = ventilator.solve(supply, tube, lung_cmh2o, LUNG, suction)
    flow = found.tube_ml_per_s
    assert found.lung_ml_per_s == pytest.approx(flow - suction, abs=1e-9)
    assert flow <= limit
    across = found.connector_cmh2o - found.trachea_cmh2o
    assert across == pytest.approx(tube * flow * abs(flow), abs=1e-9)
    assert found.trachea_cmh2o == pytest.approx(lung_cmh2o + LUNG * found.lung_ml_per_s, abs=1e-9)
    if flow < limit:  # the ventilator reaches what it wants, less what its flow costs
        gap = supply.source_cmh2o_s_per_ml if flow > 0.0 else supply.valve_cmh2o_s_per_ml
        assert found.connector_cmh2o == pytest.approx(target - gap * flow, abs=1e-7)


def test_without_suction_peep_holds() -> None:
    assert suck(0.0) == ventilator.still(6.0)


def test_compensated_suction_costs_the_droop_and_the_tube() -> None:
    found = ventilator.solve(EXPIRATION, TUBE, 3.12, LUNG, 200.0)
    assert found.tube_ml_per_s == pytest.approx(200.0, abs=0.1)
    assert found.trachea_cmh2o == pytest.approx(6.0 - 0.014 * 200.0 - TUBE * 200.0**2, abs=0.01)


def test_suction_beyond_the_compensation_comes_out_of_the_lung() -> None:
    found = suck(700.0, lung_cmh2o=-5.0)
    assert found.tube_ml_per_s == 500.0
    assert found.lung_ml_per_s == pytest.approx(-200.0)
    assert found.trachea_cmh2o < -5.0
    assert found.connector_cmh2o < 0.0


def test_more_suction_never_raises_the_pressure() -> None:
    pressures = [suck(float(q)).trachea_cmh2o for q in range(0, 1000, 10)]
    assert pressures == sorted(pressures, reverse=True)
