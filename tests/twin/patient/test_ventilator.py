import numpy as np
import pytest

from opensuction.twin.patient import patient_preset, ventilator
from opensuction.twin.patient.ventilator import Ventilator

DT_S = 0.01
PRESET = patient_preset.patient("adult-icu", 0, nominal=True).ventilator


def targets(machine: Ventilator, steps: int) -> list[float]:
    state = ventilator.at_rest(machine)
    found = []
    for _ in range(steps):
        state = ventilator.step(machine, state, DT_S)
        found.append(state.target_cmh2o)
    return found


@pytest.mark.parametrize("steps", [400, 300, 214, 150])
def test_breaths_repeat_with_the_set_rate(steps: int) -> None:
    machine = PRESET._replace(period_s=steps * DT_S, inspiration_s=0.495)
    wanted = np.array(targets(machine, 200 * steps)).reshape(200, steps)
    # Two hundred breaths later rounding has neither gained nor lost a step.
    assert wanted[-1] == pytest.approx(wanted[1], abs=1e-9)


def test_pressure_rises_smoothly_to_inspiratory_pressure_and_falls_to_peep() -> None:
    steps = round(PRESET.period_s / DT_S)
    wanted = np.array(targets(PRESET, steps))
    top = PRESET.peep_cmh2o + PRESET.driving_cmh2o
    assert wanted.max() == pytest.approx(top, abs=0.01)
    assert wanted[-2] == pytest.approx(PRESET.peep_cmh2o, abs=0.01)  # the last one rises again
    assert np.diff(wanted).max() < 0.1 * PRESET.driving_cmh2o
    high = np.count_nonzero(wanted > PRESET.peep_cmh2o + 0.9 * PRESET.driving_cmh2o)
    assert high * DT_S == pytest.approx(PRESET.inspiration_s - 2.3 * PRESET.rise_s, abs=0.03)


def test_a_step_longer_than_the_rise_does_not_overshoot() -> None:
    machine = PRESET._replace(rise_s=0.001, fall_s=0.001)
    wanted = targets(machine, 800)
    assert min(wanted) >= machine.peep_cmh2o - 1e-12
    assert max(wanted) <= machine.peep_cmh2o + machine.driving_cmh2o + 1e-12


def test_flow_compensation_is_offered_in_expiration_and_free_flow_in_inspiration() -> None:
    state = ventilator.step(PRESET, ventilator.at_rest(PRESET), DT_S)
    assert ventilator.supply(PRESET, state).limit_ml_per_s == pytest.approx(2000.0)
    late = state._replace(breath_s=PRESET.period_s - 1.0)
    offered = ventilator.supply(PRESET, late)
    assert offered.limit_ml_per_s == pytest.approx(500.0)  # 30 L/min
    assert offered.source_cmh2o_s_per_ml == PRESET.droop_cmh2o_s_per_ml
