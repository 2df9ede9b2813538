"""More vacuum delivered at the tip, more gas, more lung lost: by the physics of line and lung."""

import math

import pytest

from opensuction.twin import parameter, preset
from opensuction.twin.machine import suction_line
from opensuction.twin.parameter import ParameterValues
from opensuction.twin.patient import patient_preset
from tests.twin.breathing import PATIENTS, closed_suction

PUMP = parameter.nominal(parameter.CLINICAL)
WALL = {**PUMP, "pump_free_l_per_min": 40.0, "pump_occluded_mmhg": 500.0}
"""[K] Wall suction: 40 L/min free flow, some 500 mmHg occluded."""
SECONDS = 15.0


def delivered(values: ParameterValues, setpoint_mmhg: float) -> tuple[float, float]:
    """Vacuum in the line, and L/min through the open catheter, once both have settled."""
    machine = preset.machine(values, PATIENTS["adult-ards"])
    line = machine.line
    state = suction_line.SuctionState(vacuum_mmhg=0.0, gas_ml_per_s=0.0, gas_ml=0.0)
    for _ in range(4000):
        state = suction_line.step(line, state, True, setpoint_mmhg, 1.0, 0.0, 0.001)
    return state.vacuum_mmhg, 0.06 * state.gas_ml_per_s


@pytest.mark.parametrize("name", ["adult-icu", "adult-ards"])
def test_lung_loss_rises_with_the_vacuum_that_is_delivered(name: str) -> None:
    lost = []
    for setpoint_mmhg in (80.0, 120.0, 150.0):
        vacuum_mmhg, l_per_min = delivered(WALL, setpoint_mmhg)
        # The regulator needs some mmHg more for the air that it lets in.
        assert setpoint_mmhg <= vacuum_mmhg < setpoint_mmhg + 6.0
        seen, _ = closed_suction(PATIENTS[name], l_per_min, SECONDS, 4.0, 40.0)
        lost.append(seen["lung_volume_loss_ml"].max())
    assert lost[0] * 1.1 < lost[1]
    assert lost[1] * 1.05 < lost[2]


def test_the_pump_delivers_less_than_is_set_and_the_wall_what_is_set() -> None:
    """The pump's 18 L/min pass through the open bore at some 78 mmHg, whatever is set above."""
    at_pump = [delivered(PUMP, setpoint)[0] for setpoint in (80.0, 120.0, 150.0)]
    assert max(at_pump) - min(at_pump) < 5.0
    assert max(at_pump) < 90.0
    for setpoint in (120.0, 150.0):
        assert delivered(WALL, setpoint)[0] > 1.3 * delivered(PUMP, setpoint)[0]


def test_with_the_wall_s_suction_the_lung_loses_more_at_the_same_setting() -> None:
    person = patient_preset.patient("adult-ards", 0, nominal=True)
    pump, wall = (
        closed_suction(person, delivered(values, 150.0)[1], SECONDS, 4.0, 40.0)[0]
        for values in (PUMP, WALL)
    )
    assert wall["lung_volume_loss_ml"].max() > 1.1 * pump["lung_volume_loss_ml"].max()
    assert math.isfinite(wall["spo2_percent"].min())
