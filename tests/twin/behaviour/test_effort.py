"""Own breaths: at their rate, at no time of the ventilator's, and dips of the pressure."""

import numpy as np
import pytest

from opensuction.kernel import random_stream
from opensuction.kernel.record import Array
from opensuction.twin.behaviour import spontaneous_event
from opensuction.twin.behaviour.spontaneous_event import Effort
from tests.settled import settled
from tests.twin.behaviour import bed

SOURCE = random_stream.stream(3, 9)
DT_S = 0.01


step_effort = settled(spontaneous_event.step_effort)
pressure_cmh2o = settled(spontaneous_event.pressure_cmh2o_effort)


def course(one: Effort, seconds: float) -> Array:
    state, seen = spontaneous_event.silent_effort(one, SOURCE), []
    for _ in range(round(seconds / DT_S)):
        state = step_effort(one, state, DT_S)
        seen.append(pressure_cmh2o(one, state))
    return np.array(seen)


def test_breaths_pull_at_their_rate_and_within_their_strength() -> None:
    seen = course(Effort(per_s=0.2, peak_cmh2o=6.0), 1000.0)
    assert bed.count_starts(seen < 0.0) == pytest.approx(200, rel=0.05)
    assert seen.max() == 0.0
    assert 1.3 * 6.0 < -seen.min() <= 1.4 * 6.0


def test_quick_breaths_do_not_run_into_one_another() -> None:
    seen = course(Effort(per_s=1.3, peak_cmh2o=4.0), 200.0)
    assert bed.count_starts(seen < 0.0) == pytest.approx(260, rel=0.06)


def test_nobody_breathes_at_no_rate() -> None:
    assert set(course(Effort(per_s=0.0, peak_cmh2o=6.0), 60.0)) == {0.0}


@pytest.mark.parametrize("name", ["adult-icu", "neonate"])
def test_own_breaths_dip_the_pressure_and_are_not_the_ventilator_s(name: str) -> None:
    person = bed.lively(name)
    still = person.behaviour.cough._replace(spontaneous_per_s=0.0)
    person = person._replace(behaviour=person.behaviour._replace(cough=still))
    _, seen = bed.watch(bed.bed(person), 180.0)
    peep = person.ventilator.peep_cmh2o
    pulled = seen["muscle_cmh2o"] < -2.0
    assert seen["airway_pressure_cmh2o"][pulled].min() < peep - 1.0
    assert seen["relaxed_pressure_cmh2o"].min() > peep - 0.7
    began = np.flatnonzero(np.diff(pulled.astype(int)) == 1) * bed.STEP_S
    phase = began % person.ventilator.period_s / person.ventilator.period_s
    # Spread over the ventilator's breath: each third of it has some.
    assert set(np.floor(3.0 * phase)) == {0.0, 1.0, 2.0}
