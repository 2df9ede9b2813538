"""Coughs: how often, how strong, and what they do to pressure, lung and carina."""

import itertools

import numpy as np
import pytest

from opensuction.kernel import random_stream
from opensuction.twin.behaviour import spontaneous_event
from opensuction.twin.behaviour.spontaneous_event import Cough
from tests.settled import settled
from tests.twin.behaviour import bed

SOURCE = random_stream.stream(3, 9)
DT_S = 0.01
OFTEN = Cough(0.01, 0.2, peak_cmh2o=80.0, push_s=0.3, refractory_s=1.5)


step = settled(spontaneous_event.step)
pressure_cmh2o = settled(spontaneous_event.pressure_cmh2o)


def course(one: Cough, stimulus: float, seconds: float) -> list[float]:
    state, seen = spontaneous_event.silent(SOURCE), []
    for _ in range(round(seconds / DT_S)):
        state = step(one, state, stimulus, DT_S)
        seen.append(pressure_cmh2o(one, state))
    return seen


def starts(pressure: list[float]) -> list[int]:
    return [i for i in range(1, len(pressure)) if pressure[i] > 0.0 >= pressure[i - 1]]


@pytest.mark.parametrize(
    ("stimulus", "per_s"),
    [
        (0.0, 0.01),
        pytest.param(0.5, 0.11, marks=pytest.mark.soak),
        pytest.param(1.0, 0.21, marks=pytest.mark.sweep),
    ],
)
def test_a_catheter_provokes_coughs_by_its_stimulus(stimulus: float, per_s: float) -> None:
    """Within four deviations of a Poisson count, for the time that is left between coughs."""
    seconds = 4000.0
    found = len(starts(course(OFTEN, stimulus, seconds)))
    expected = seconds / (1.0 / per_s + 2.1)
    assert found == pytest.approx(expected, abs=4.0 * np.sqrt(expected))


def test_a_cough_pulls_then_pushes_and_then_rests() -> None:
    pressure = course(OFTEN, 1.0, 600.0)
    found = starts(pressure)
    assert min(b - a for a, b in itertools.pairwise(found)) >= round(2.1 / DT_S)
    for first in found:
        push = pressure[first : first + 40]
        assert max(push) * 1.01 >= 0.6 * 80.0
        assert max(push) <= 1.4 * 80.0
        assert sum(value > 0.0 for value in push) == pytest.approx(30, abs=1)
        assert -0.15 * 80.0 < min(pressure[first - 30 : first]) < -0.05 * 80.0


def test_nobody_who_never_coughs_coughs() -> None:
    assert set(course(OFTEN._replace(spontaneous_per_s=0.0), 0.0, 300.0)) == {0.0}


@pytest.mark.parametrize("name", ["adult-icu", "adult-ards", "child-10kg", "neonate"])
def test_a_cough_raises_pressure_and_blows_gas_out(name: str) -> None:
    """At the connector too, where the ventilator measures; and the carina comes nearer."""
    person = bed.lively(name)
    start = bed.bed(person)
    _, quiet = bed.watch(bed.bed(person, seed=1), 20.0)
    _, seen = bed.watch(start, 120.0, tip_mm=0.4 * person.carina_mm)
    at = int(np.argmax(seen["muscle_cmh2o"]))
    peak = seen["muscle_cmh2o"][at]
    assert peak > 0.4 * person.behaviour.cough.peak_cmh2o
    around = slice(at - 15, at + 15)
    driven = person.ventilator.peep_cmh2o + person.ventilator.driving_cmh2o
    assert seen["airway_pressure_cmh2o"][around].max() > 0.3 * peak
    assert seen["connector_cmh2o"][around].max() > person.ventilator.peep_cmh2o + 0.02 * peak
    blown_ml = seen["lung_volume_ml"][at - 15] - seen["lung_volume_ml"][at + 15]
    assert 2.0 * person.weight_kg < blown_ml < 25.0 * person.weight_kg
    shortening = person.behaviour.shortening_mm_per_cmh2o
    assert seen["carina_shift_mm"].min() == pytest.approx(-shortening * peak, rel=0.1)
    # The lung whose muscles never moved feels nothing of it.
    assert seen["relaxed_pressure_cmh2o"].max() < driven + 1.0
    assert quiet["relaxed_pressure_cmh2o"].min() > person.ventilator.peep_cmh2o - 1.0


def test_the_lung_keeps_its_residual_volume_however_hard_it_is_pressed() -> None:
    person = bed.lively("adult-ards")
    fierce = person.behaviour.cough._replace(peak_cmh2o=250.0, provoked_per_s=2.0)
    person = person._replace(behaviour=person.behaviour._replace(cough=fierce))
    _, seen = bed.watch(bed.bed(person), 60.0, tip_mm=30.0, l_per_min=15.0)
    assert seen["muscle_cmh2o"].max() > 200.0
    assert seen["lung_volume_ml"].min() > 0.0
    assert np.isfinite(seen["airway_pressure_cmh2o"]).all()
