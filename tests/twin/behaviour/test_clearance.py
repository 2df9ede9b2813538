"""Secretions move by themselves: up, out with a cough, loose in time; none is lost."""

import numpy as np
import pytest

from opensuction.kernel.record import Array
from opensuction.twin import bedside, coupling
from opensuction.twin.behaviour import behaviour
from opensuction.twin.behaviour.behaviour import Clearance, Store
from tests.settled import settled
from tests.twin.behaviour import bed

CARINA_MM = 65.0
USUAL = Clearance(
    cilia_mm_per_s=0.05,
    cough_mm_per_s_per_cmh2o=1.5,
    expelled_share=0.5,
    adherent_share=0.2,
    loosening_s=7200.0,
    deep_share=0.15,
    resistance_share=0.15,
    usual_ml=3.0,
)
LYING = np.array([0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0])
NOTHING = np.zeros(12)


step_clearance = settled(behaviour.step_clearance)


def go_on(
    loose: Array, store: Store, seconds: float, muscle: float = 0.0, made: Array = NOTHING
) -> tuple[Array, Store]:
    for _ in range(round(seconds / 0.1)):
        loose, store = step_clearance(
            USUAL, loose + 0.1 * made, store, made, CARINA_MM, muscle, 0.1
        )
    return loose, store


def whole_ml(loose: Array, store: Store) -> float:
    return float(loose.sum() + store.adherent_ml + store.deep_ml + store.expelled_ml)


def middle(loose: Array) -> float:
    return float(np.sum(loose * np.arange(12)) / loose.sum())


def test_none_is_lost_whatever_moves_it() -> None:
    loose, store = behaviour.part(USUAL, LYING)
    assert loose.sum() == pytest.approx(0.65 * 3.0)
    assert whole_ml(loose, store) == pytest.approx(3.0)
    for muscle in (0.0, 80.0, -5.0):
        loose, store = go_on(loose, store, 20.0, muscle, 0.001 * LYING)
    assert whole_ml(loose, store) == pytest.approx(3.0 + 0.06 * 3.0, rel=1e-9)
    assert min(loose.min(), store.adherent_ml, store.deep_ml) >= 0.0


def test_cilia_carry_them_to_the_tube_and_no_further() -> None:
    """3 mm a minute: a centimetre, one bin, in 200 s; after an hour all is at the top."""
    loose, store = behaviour.part(USUAL._replace(deep_share=0.0), LYING)
    later, _ = go_on(loose, store, 200.0)
    assert middle(loose) - middle(later) == pytest.approx(1.0, abs=0.1)
    late, after = go_on(loose, store, 3600.0)
    assert late[0] > 0.9 * loose.sum()
    assert after.expelled_ml == 0.0


def test_a_cough_brings_them_up_by_centimetres_and_some_of_them_out() -> None:
    loose, store = behaviour.part(USUAL, LYING)
    once, _ = go_on(loose, store, 0.3, muscle=45.0)
    assert 1.0 < middle(loose) - middle(once) < 3.0
    many, after = go_on(loose, store, 3.0, muscle=45.0)
    assert after.expelled_ml > 0.3
    assert many.sum() < loose.sum() + 0.45 - after.expelled_ml + 1e-9


def test_what_sticks_comes_loose_in_hours() -> None:
    loose, store = behaviour.part(USUAL, LYING)
    _, later = go_on(loose, store, 7200.0)
    ratio = later.adherent_ml / store.adherent_ml
    assert ratio == pytest.approx(np.exp(-1.0), rel=0.01)


def test_resistance_is_as_stated_with_the_usual_ones_and_grows_with_what_gathers() -> None:
    loose, store = behaviour.part(USUAL, LYING)
    assert behaviour.resistance_ratio(USUAL, loose, store) == pytest.approx(1.0)
    assert behaviour.resistance_ratio(USUAL, NOTHING, behaviour.EMPTY) == pytest.approx(0.85)
    assert behaviour.resistance_ratio(USUAL, loose + LYING, store) == pytest.approx(1.15)
    assert behaviour.resistance_ratio(USUAL, 1000.0 * LYING, store) == 4.0


def test_gathered_secretions_cost_tidal_volume() -> None:
    person = bed.lively("child-10kg")
    quietened = person.behaviour.cough._replace(spontaneous_per_s=0.0)
    still = person.behaviour.effort._replace(per_s=0.0)
    habits = person.behaviour._replace(cough=quietened, effort=still)
    start = bed.bed(person._replace(behaviour=habits))

    def swing_ml(times: float) -> float:
        fuller = start.state._replace(secretion_ml=times * start.state.secretion_ml)
        _, seen = bed.watch(start._replace(state=fuller), 30.0)
        return float(np.ptp(seen["lung_volume_ml"][-1000:]))

    assert swing_ml(1.0) > swing_ml(8.0) + 1.0


def test_suction_reaches_only_what_is_loose() -> None:
    """The tip lies among them and takes all it is given: a third of them is left."""
    start = bed.bed(bed.lively())
    state = start.state
    began_ml = bedside.sum_secretion_ml(state)
    assert began_ml == pytest.approx(3.0)
    for tip_mm in np.repeat(np.arange(60.0, -1.0, -10.0), 20):
        reached = bedside.couple(start.machine, state, tip_mm)
        taking = reached._replace(mucus_ml=reached.reachable_ml, ticks=coupling.TICKS)
        state = bedside.step(start.machine, state, taking, float(tip_mm), bed.DT_S)
    left_ml = bedside.sum_secretion_ml(state)
    assert left_ml == pytest.approx(0.35 * began_ml, rel=0.05)
    assert state.secretion_ml.sum() < 0.02
