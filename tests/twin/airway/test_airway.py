import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin import parameter, preset
from opensuction.twin.airway import airway
from opensuction.twin.airway.airway import AirwayState

DT_S = 0.001
VALUES = parameter.nominal(parameter.BENCH)
AIRWAY = preset.machine(VALUES).airway
START = AirwayState(taken_ml=0.0, removed_ml=0.0, tip_mm=0.0, contact_n=0.0, free_share=1.0)


@given(
    path=st.lists(
        st.tuples(st.floats(0.0, 150.0), st.floats(0.0, 2.0), st.floats(0.001, 2.0)), max_size=20
    )
)
def test_what_is_removed_is_what_was_taken_and_never_more_than_is_there(
    path: list[tuple[float, float, float]],
) -> None:
    state, total = START, 0.0
    for vacuum, there, dt_s in path:
        state = airway.step(AIRWAY, state, 30.0, vacuum, there, dt_s)
        assert 0.0 <= state.taken_ml <= there
        # To rounding: with next to no vacuum the smallest of numbers are divided.
        assert 1.0 - AIRWAY.mucus_share - 1e-9 <= state.free_share <= 1.0
        total += state.taken_ml
    assert state.removed_ml == pytest.approx(total, rel=1e-12)


def test_nothing_is_taken_up_without_vacuum() -> None:
    state = airway.step(AIRWAY, START, 30.0, 0.0, 1.0, DT_S)
    assert (state.removed_ml, state.free_share) == (0.0, 1.0)


def test_uptake_is_its_rate_times_vacuum_until_nothing_is_left() -> None:
    # 1.02 mL/s of a plug of 1 Pa s; [calc-plug] gives 1.2 mL/s without losses.
    rate = 0.0085 * 120.0
    state = airway.step(AIRWAY, START, 30.0, 120.0, 1.0, 0.1)
    assert state.removed_ml == pytest.approx(0.1 * rate)
    assert state.free_share == pytest.approx(1.0 - AIRWAY.mucus_share)
    state = airway.step(AIRWAY, state, 30.0, 120.0, 0.05 * rate, 0.1)
    assert state.removed_ml == pytest.approx(0.15 * rate)
    assert state.free_share == pytest.approx(1.0 - 0.5 * AIRWAY.mucus_share)
    assert airway.step(AIRWAY, state, 30.0, 120.0, 0.0, 0.1).free_share == 1.0


def test_the_carina_stops_the_tip() -> None:
    pressed = airway.step(AIRWAY, START, AIRWAY.carina_mm + 0.25, 0.0, 1.0, DT_S)
    # 0.25 mm against 0.5 and 0.9 N/mm in series closes the switch.
    assert pressed.contact_n == pytest.approx(VALUES["switch_n"], abs=0.001)
    assert pressed.tip_mm == pytest.approx(AIRWAY.carina_mm + pressed.contact_n / 0.5)
    free = airway.step(AIRWAY, pressed, AIRWAY.carina_mm - 0.1, 0.0, 1.0, DT_S)
    assert (free.tip_mm, free.contact_n) == (AIRWAY.carina_mm - 0.1, 0.0)
