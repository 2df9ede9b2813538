import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin import airway, parameter, preset
from opensuction.twin.airway import AirwayState

DT_S = 0.001
VALUES = parameter.nominal(parameter.BENCH)
AIRWAY = preset.machine(VALUES).airway


def filled(*bins_ml: float) -> AirwayState:
    return AirwayState(
        secretion_ml=np.array(bins_ml), removed_ml=0.0, tip_mm=0.0, contact_n=0.0, free_share=1.0
    )


FULL = filled(*[0.25] * 12)

depths = st.floats(-40.0, 140.0)
vacuums = st.floats(0.0, 150.0)


@given(path=st.lists(st.tuples(depths, vacuums, st.floats(0.001, 2.0)), max_size=20))
def test_secretions_are_moved_never_made_or_lost(path: list[tuple[float, float, float]]) -> None:
    state = FULL
    for depth, vacuum, dt_s in path:
        following = airway.step(AIRWAY, state, depth, vacuum, dt_s)
        assert following.removed_ml >= state.removed_ml
        assert np.all(following.secretion_ml >= 0.0)
        assert np.all(following.secretion_ml <= state.secretion_ml)
        state = following
    # To the rounding of a few dozen subtractions.
    assert state.removed_ml + state.secretion_ml.sum() == pytest.approx(3.0, rel=1e-12)


@given(depth=depths)
def test_nothing_is_taken_up_without_vacuum(depth: float) -> None:
    state = airway.step(AIRWAY, FULL, depth, 0.0, DT_S)
    assert state.removed_ml == 0.0
    assert state.free_share == 1.0
    assert state.secretion_ml.tolist() == FULL.secretion_ml.tolist()


def test_uptake_is_its_rate_times_vacuum_until_nothing_is_left() -> None:
    state = FULL
    for _ in range(100):
        state = airway.step(AIRWAY, state, 30.0, 120.0, DT_S)
    # 1.02 mL/s of a plug of 1 Pa s; FACTS section 3 gives 1.2 mL/s without losses.
    assert state.removed_ml == pytest.approx(0.0085 * 120.0 * 0.1)
    assert state.free_share == pytest.approx(1.0 - AIRWAY.mucus_share)
    for _ in range(2000):
        state = airway.step(AIRWAY, state, 30.0, 120.0, DT_S)
    # From 30 mm to 45 mm it reaches two bins.
    assert state.removed_ml == pytest.approx(0.5)
    assert state.free_share == 1.0
    assert np.flatnonzero(state.secretion_ml == 0.0).tolist() == [3, 4]


def test_a_tip_in_the_tube_reaches_nothing() -> None:
    state = airway.step(AIRWAY, FULL, -AIRWAY.reach_mm - 0.1, 120.0, DT_S)
    assert state.removed_ml == 0.0
    assert state.free_share == 1.0


def test_a_clogged_tip_takes_up_nothing() -> None:
    clogged = AIRWAY._replace(uptake_ml_per_s_per_mmhg=0.0)
    assert airway.step(clogged, FULL, 30.0, 120.0, DT_S).removed_ml == 0.0


def test_the_state_given_is_not_changed() -> None:
    airway.step(AIRWAY, FULL, 30.0, 120.0, DT_S)
    assert FULL.secretion_ml.tolist() == [0.25] * 12


def test_the_carina_stops_the_tip() -> None:
    pressed = airway.step(AIRWAY, FULL, AIRWAY.carina_mm + 0.25, 0.0, DT_S)
    # 0.25 mm against 0.5 and 0.9 N/mm in series closes the switch.
    assert pressed.contact_n == pytest.approx(VALUES["switch_n"], abs=0.001)
    assert pressed.tip_mm == pytest.approx(AIRWAY.carina_mm + pressed.contact_n / 0.5)
    free = airway.step(AIRWAY, pressed, AIRWAY.carina_mm - 0.1, 0.0, DT_S)
    assert (free.tip_mm, free.contact_n) == (AIRWAY.carina_mm - 0.1, 0.0)
