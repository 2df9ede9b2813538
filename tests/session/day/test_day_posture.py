"""Days of a patient who is moved: the carina comes nearer than the search expects it."""

import numpy as np
import pytest

from opensuction.kernel.vocabulary import Phase
from opensuction.session.choice import CycleChoice, DayChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.day import day_run
from opensuction.session.day.day_run import Day
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns

EVERY_MIN = 30.0


def played(seed: int, cycles: int) -> tuple[Prepared, Day, Columns]:
    """Day, and columns of its last cycle, of a drawn adult by contact without a fault."""
    chosen = CycleChoice(RigChoice(patient="adult-icu", seed=seed), approach="contact")
    begun = cycle_run.prepare(resolution.resolve(chosen))
    seen: list[Columns] = []

    def tell(_: object, __: object, columns: Columns) -> None:
        seen[:] = [columns]

    return begun, day_run.play(begun, DayChoice(cycles, EVERY_MIN), tell), seen[0]


@pytest.mark.parametrize(
    ("seed", "cycles"), [(9102, 5), pytest.param(9105, 13, marks=pytest.mark.soak)]
)
def test_a_cycle_goes_on_from_a_carina_that_a_posture_has_brought_nearer(
    seed: int, cycles: int
) -> None:
    begun, day, columns = played(seed, cycles)
    search = begun.loop.controller.plan.contact
    touching = columns["truth.contact_n"] > 0.0
    touched_mm = columns["truth.tip_mm"][touching].max()
    # It lay before the window: the cycle was ended as with a switch that sticks.
    assert search.nearest_mm < touched_mm < search.window_start_mm
    assert len(day.cycles) == cycles
    assert all(cycle.outcome.completed and cycle.outcome.trips == () for cycle in day.cycles)
    assert not day.cycles[-1].outcome.alarms
    sucking = columns["truth.valve_open_ratio"] > 0.0
    assert not (touching & sucking).any()
    suctioning = columns["phase"] == Phase.SUCTIONING
    sucked_mm = columns["truth.tip_mm"][suctioning].max()
    assert sucked_mm == pytest.approx(touched_mm - search.backoff_mm, abs=2.5)
    assert columns["truth.contact_n"].max() <= 0.3
    assert float(np.sum(touching)) * DT_S < 2.0
