import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.interface import Commands
from opensuction.twin import coupling, parameter, preset
from opensuction.twin.patient import patient_preset
from opensuction.twin.plant import PlantState
from tests.budget import simulated
from tests.twin.holding import hold

VALUES = parameter.nominal(parameter.BENCH)
BENCH = preset.machine(VALUES)


def parked(head_mm: float) -> PlantState:
    return preset.park(BENCH, VALUES, head_mm, seed=1, run=2)


def secretion_ml(state: PlantState) -> float:
    """All there is: in the trachea, less what the tip took since, in bore and canister."""
    trachea = float(np.sum(state.bedside.secretion_ml)) - state.machine.coupling.mucus_ml
    return trachea + state.machine.bore.mucus_ml + state.machine.bore.canister_ml


scripts = st.lists(
    st.tuples(st.floats(-24.0, 24.0), st.floats(-24.0, 24.0), st.booleans(), st.floats(0.0, 150.0)),
    min_size=1,
    max_size=6,
)


@simulated
@given(script=scripts)
def test_secretions_are_moved_never_made_or_lost(
    script: list[tuple[float, float, bool, float]],
) -> None:
    state = parked(60.0)
    for insertion_v, valve_v, pump_on, vacuum in script:
        commands = Commands(0.0, insertion_v, True, 0.0, valve_v, True, pump_on, vacuum)
        state = hold(BENCH, state, commands, 405)  # not a multiple of the bedside's ten
        assert np.all(state.bedside.secretion_ml >= 0.0)
        # To the rounding of a few thousand subtractions.
        out = state.machine.bore.mucus_ml + state.machine.bore.canister_ml
        assert out == pytest.approx(state.machine.airway.removed_ml, rel=1e-10, abs=1e-12)
        assert secretion_ml(state) == pytest.approx(VALUES["secretion_ml"], rel=1e-10)


def test_the_bedside_steps_with_every_tenth_tick() -> None:
    state = parked(0.0)
    idle = Commands(0.0, 0.0, True, 0.0, 0.0, True, False, 0.0)
    for tick in range(1, 101):
        state = hold(BENCH, state, idle, 1)
        assert state.machine.coupling.ticks == tick % coupling.TICKS


def test_the_tip_finds_what_the_bedside_says_is_there() -> None:
    """Nothing but bins and reach decides how much a still tip can take."""
    state = parked(80.0)
    body = state.machine
    opened = body._replace(valve=body.valve._replace(position=math.radians(30.0)))
    state = state._replace(machine=opened)
    there = state.machine.coupling.reachable_ml
    holding_v = VALUES["spring_preload_v"] + VALUES["spring_v_per_rad"] * math.radians(30.0)
    sucking = Commands(0.0, 0.0, True, 0.0, holding_v, True, True, 120.0)
    state = hold(BENCH, state, sucking, 6000)
    assert there > 0.5
    assert state.machine.airway.removed_ml == pytest.approx(there, rel=1e-9)
    assert state.machine.coupling.reachable_ml == pytest.approx(0.0, abs=1e-12)


def test_what_is_produced_adds_to_what_there_is() -> None:
    """At a patient, sucking: trachea, bore and canister hold what was there and what came."""
    values = parameter.nominal(parameter.CLINICAL)
    person = patient_preset.patient("adult-icu", 0, nominal=True)
    busy = person._replace(secretion=person.secretion._replace(production_ml_per_h=720.0))
    twin = preset.machine(values, busy)
    state = preset.park(twin, values, 45.0, seed=1, run=2)
    there = secretion_ml(state)
    body = state.machine
    opened = body._replace(valve=body.valve._replace(position=math.radians(30.0)))
    state = state._replace(machine=opened)
    holding_v = values["spring_preload_v"] + values["spring_v_per_rad"] * math.radians(30.0)
    sucking = Commands(0.0, 0.0, True, 0.0, holding_v, True, True, 120.0)
    state = hold(twin, state, sucking, 5000)
    assert state.machine.bore.canister_ml > 0.5
    # 0.2 mL/s for 5 s.
    assert secretion_ml(state) == pytest.approx(there + 1.0, rel=1e-9)
