"""A run of many stays: cut by the truth alone, whatever the pieces are in which it comes."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.record import Array
from opensuction.oracle import exposure, harm
from opensuction.oracle.harm import AIRWAY_TIME, APART_S, FORCE, LEFT_INSIDE, REST_S, LongRun
from opensuction.simulation import rig as rigs

MACHINE = rigs.rig("clinical", 1, patient="child-10kg").machine
OUT_MM = -MACHINE.patient.tube_length_mm - 10.0
DT_S = 0.01
"""Coarse: 100 rows a second."""
HEALTHY = {
    "truth.relaxed_pressure_cmh2o": MACHINE.patient.ventilator.peep_cmh2o,
    "truth.spo2_percent": 97.0,
}


def truth(*spans: tuple[float, float], **others: Array) -> dict[str, Array]:
    """Spans of so many seconds with the tip at a depth each."""
    tip = np.concatenate([np.full(round(seconds / DT_S), mm) for seconds, mm in spans])
    found = {name: np.full(tip.size, HEALTHY.get(name, 0.0)) for name in exposure.COLUMNS}
    named = {f"truth.{name}": values for name, values in others.items()}
    return found | named | {"truth.tip_mm": tip, "time_s": DT_S * np.arange(tip.size)}


def judged(columns: dict[str, Array], ends: list[int] | None = None) -> LongRun:
    """The run in pieces that end there."""
    run = LongRun(MACHINE, math.inf)
    edges = [0, *sorted(ends or []), columns["time_s"].size]
    for first, last in itertools.pairwise(edges):
        run.add({name: column[first:last] for name, column in columns.items()})
    return run


def test_one_stay_is_what_it_is_without_any_cut() -> None:
    columns = truth((4.0, OUT_MM), (8.0, 10.0), (9.0, OUT_MM))
    (found,) = judged(columns).runs
    assert found.borne == exposure.measure(MACHINE, columns)
    assert found.harm == harm.find(MACHINE, found.borne, math.inf)
    assert (found.first_s, found.last_s) == (0.0, columns["time_s"][-1])


def test_three_cycles_of_fifteen_seconds_with_a_rest_between_are_none_of_45() -> None:
    """A child may bear 20 s in a run."""
    cycle = ((5.0, OUT_MM), (15.0, 10.0), (APART_S + 3.0, OUT_MM))
    run = judged(truth(*cycle, *cycle, *cycle))
    assert harm.worst(run.runs) == ()
    stays = [one.borne.in_airway_s for one in run.runs]
    assert stays == pytest.approx([15.0, 15.0, 15.0, 0.0], abs=1e-6)


def test_stays_that_follow_each_other_at_once_are_one() -> None:
    short = ((15.0, 10.0), (APART_S - 1.0, OUT_MM))
    run = judged(truth((5.0, OUT_MM), *short, *short))
    (found,) = harm.worst(run.runs)
    assert found.name == AIRWAY_TIME
    assert found.worst == pytest.approx(30.0, abs=1e-6)


def test_whoever_knows_that_the_patient_has_recovered_may_say_so() -> None:
    short = truth((15.0, 10.0), (2.0, OUT_MM))
    run = LongRun(MACHINE, math.inf)
    run.add(short)
    run.begin()
    run.begin()
    run.add(short | {"time_s": short["time_s"] + 17.0})
    assert len(run.runs) == 2
    assert harm.worst(run.runs) == ()


def test_what_was_broken_in_any_of_them_stays_the_worst_first() -> None:
    force = np.zeros(7000)
    force[1000], force[5000] = 0.5, 0.4
    columns = truth((10.0, 10.0), (20.0, OUT_MM), (10.0, 10.0), (20.0, OUT_MM), (10.0, 12.0))
    run = judged(columns | {"truth.contact_n": force})
    found = {one.name: one for one in harm.worst(run.runs)}
    assert list(found) == [LEFT_INSIDE, FORCE]
    assert found[FORCE].worst == 0.5
    assert found[LEFT_INSIDE].worst == 12.0
    assert run.last_inside_s == columns["time_s"][-1]


def test_a_tip_that_was_inside_where_a_piece_ended_and_came_out_was_not_left() -> None:
    run = LongRun(MACHINE, math.inf)
    first = truth((1.0, OUT_MM), (1.0, 10.0))
    run.add(first)
    assert [one.name for one in harm.worst(run.runs)] == [LEFT_INSIDE]
    run.begin()
    later = truth((1.0, OUT_MM))
    run.add(later | {"time_s": later["time_s"] + 2.0})
    assert harm.worst(run.runs) == ()


def test_a_long_rest_is_judged_piece_by_piece() -> None:
    run = judged(truth((3.5 * REST_S, OUT_MM)))
    lengths = [one.last_s - one.first_s for one in run.runs]
    assert len(lengths) == 4
    assert max(lengths) <= REST_S


@given(
    spans=st.lists(
        st.tuples(st.floats(0.05, 25.0), st.sampled_from([OUT_MM, 10.0, 40.0])), max_size=8
    ),
    ends=st.lists(st.integers(1, 15000), max_size=12, unique=True),
)
def test_how_often_somebody_looks_changes_nothing(
    spans: list[tuple[float, float]], ends: list[int]
) -> None:
    columns = truth((1.0, OUT_MM), *spans)
    whole, cut = judged(columns), judged(columns, [e for e in ends if e < columns["time_s"].size])
    assert whole.runs == cut.runs
    assert whole.last_inside_s == cut.last_inside_s
    total_s = sum(one.borne.in_airway_s for one in whole.runs)
    assert total_s == pytest.approx(exposure.measure(MACHINE, columns).in_airway_s, abs=1e-6)


def test_nothing_seen_is_no_run() -> None:
    run = LongRun(MACHINE, math.inf)
    run.begin()
    run.add(truth((0.0, OUT_MM)))
    assert run.runs == ()
