"""Bounds of a patient: closed forms on tracks drawn by hand, and whole cycles without a fault."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.oracle import exposure, harm
from opensuction.oracle.exposure import (
    ADVANCE_MM,
    BOUNDS,
    CLOSING_S,
    FORCE_N,
    SOURCES,
    AgeBounds,
    PatientExposure,
)
from opensuction.oracle.harm import NAMES
from opensuction.session.cycle import cycle_run
from opensuction.simulation import rig as rigs
from opensuction.twin.machine.machine import Machine
from tests.oracle import drawn_machine
from tests.oracle.test_exposure import track

CAP_MM = 40.0
MACHINES = {
    name: rigs.rig("clinical", 1, patient=name).machine
    for name in ("adult-icu", "child-10kg", "neonate")
}
ADULT, CHILD, NEONATE = MACHINES.values()
BENCH = rigs.rig("bench", 1).machine
INSIDE_MM = -5.0
TICKS = 40_000
HEALTHY = {
    "relaxed_pressure_cmh2o": np.full(TICKS, 8.0),
    "spo2_percent": np.full(TICKS, 97.0),
}


def for_s(seconds: float, value: float, otherwise: float = 0.0) -> Array:
    """A value for so long, in two stretches."""
    held = np.full(TICKS, otherwise)
    ticks = round(1000 * seconds)
    held[1000 : 1000 + ticks // 2] = value
    held[TICKS - ticks + ticks // 2 : TICKS] = value
    return held


OUT_MM = -150.0


def broken(machine: Machine, cap_mm: float = CAP_MM, **truth: Array) -> list[str]:
    """Names of the bounds that a track breaks; what is not named is as it should be."""
    columns = track(**{"tip_mm": np.full(TICKS, OUT_MM)} | HEALTHY | truth)
    return [one.name for one in harm.find(machine, exposure.measure(machine, columns), cap_mm)]


@pytest.mark.parametrize("machine", MACHINES.values(), ids=MACHINES)
def test_a_machine_that_stays_out_harms_nobody(machine: Machine) -> None:
    assert broken(machine) == []


@pytest.mark.parametrize("machine", MACHINES.values(), ids=MACHINES)
def test_a_tip_that_stays_is_left_inside(machine: Machine) -> None:
    tip = np.full(TICKS, OUT_MM)
    tip[-1] = INSIDE_MM
    assert broken(machine, tip_mm=tip) == ["left-inside"]
    tip[-2:] = INSIDE_MM, OUT_MM
    assert broken(machine, tip_mm=tip) == []


def test_times_are_sums_and_are_held_against_the_age() -> None:
    """Two stretches of which neither is too long break a bound together."""
    for machine, least in ((ADULT, 30.0), (CHILD, 20.0), (NEONATE, 20.0)):
        inside = [for_s(least + more, INSIDE_MM, OUT_MM) for more in (-0.002, 0.004)]
        assert [broken(machine, tip_mm=np.append(one, OUT_MM)[1:]) for one in inside] == [
            [],
            ["airway-time"],
        ]
    for machine, most_s in ((ADULT, 15.0 + CLOSING_S), (CHILD, 5.0 + CLOSING_S)):
        tip = for_s(18.0, INSIDE_MM, OUT_MM)
        tip[-1] = OUT_MM
        for more, names in ((-0.004, []), (0.004, ["suction-time"])):
            sucked = for_s(most_s + more, 60.0)
            found = broken(machine, tip_mm=tip, tip_vacuum_mmhg=sucked)
            assert found == names


@pytest.mark.parametrize(("name", "most_mmhg"), [("adult-icu", 200), ("child-10kg", 120)])
def test_vacuum_counts_at_a_tip_that_is_inside(name: str, most_mmhg: float) -> None:
    tip = for_s(1.0, INSIDE_MM, OUT_MM)
    tip[-1] = OUT_MM
    machine = MACHINES[name]
    assert broken(machine, tip_mm=tip, tip_vacuum_mmhg=for_s(1.0, most_mmhg)) == []
    too_much = for_s(1.0, most_mmhg + 1.0)
    assert broken(machine, tip_mm=tip, tip_vacuum_mmhg=too_much) == ["vacuum"]
    assert broken(machine, tip_vacuum_mmhg=too_much) == []


def test_a_relief_valve_for_adults_is_none_for_a_neonate() -> None:
    """141 mmHg, as a pump that ran away once drew at a neonate's tip."""
    tip = for_s(1.0, INSIDE_MM, OUT_MM)
    tip[-1] = OUT_MM
    drawn = for_s(1.0, 141.0)
    assert broken(NEONATE, tip_mm=tip, tip_vacuum_mmhg=drawn) == ["vacuum"]
    assert broken(ADULT, tip_mm=tip, tip_vacuum_mmhg=drawn) == []


def test_force_and_contact_are_bounds_of_their_own() -> None:
    assert broken(ADULT, contact_n=for_s(2.9, FORCE_N)) == []
    assert broken(ADULT, contact_n=for_s(3.1, FORCE_N)) == ["contact-time"]
    assert broken(ADULT, contact_n=for_s(0.1, FORCE_N + 0.001)) == ["force"]


def test_small_advances_under_vacuum_add_up() -> None:
    """Three strokes of 0.2 mm, each with the vacuum off between them."""
    tip, vacuum = np.full(TICKS, OUT_MM), np.zeros(TICKS)
    for first in (1000, 3000, 5000):
        tip[first : first + 1000] = INSIDE_MM + np.linspace(0.0, 0.2, 1000)
        vacuum[first : first + 1000] = 80.0
    assert 2 * 0.2 < ADVANCE_MM < 3 * 0.2
    assert broken(ADULT, tip_mm=tip, tip_vacuum_mmhg=vacuum) == ["advance-under-vacuum"]
    vacuum[5000:6000] = 0.0
    assert broken(ADULT, tip_mm=tip, tip_vacuum_mmhg=vacuum) == []


def test_a_tip_in_a_bronchus_is_past_what_it_may_reach_whatever_the_cap() -> None:
    """As deep as force presses tissue it may be; deeper it has gone by the carina."""
    carina = ADULT.airway.carina_mm
    pressed = FORCE_N / ADULT.airway.tip.carina_n_per_mm
    for depth, cap, names in (
        (carina + pressed - 0.01, 200.0, []),
        (carina + pressed + 0.01, 200.0, ["tip-past-cap"]),
        (carina - 10.0, carina - 10.1, ["tip-past-cap"]),
        (carina - 10.0, carina - 9.9, []),
    ):
        tip = for_s(1.0, depth, OUT_MM)
        tip[-1] = OUT_MM
        assert broken(ADULT, cap, tip_mm=tip) == names


def test_pressure_lung_and_saturation_are_held_against_the_patient() -> None:
    peep = ADULT.patient.ventilator.peep_cmh2o
    for machine, most_s in ((ADULT, 5.0), (NEONATE, 1.5)):
        for pressure in (peep - 5.1 if machine is ADULT else -0.2, 41.0):
            for more, names in ((-0.01, []), (0.01, ["airway-pressure"])):
                held = for_s(most_s + more, pressure, 8.0)
                assert broken(machine, relaxed_pressure_cmh2o=held) == names
    loss_ml = 11.0 * CHILD.patient.weight_kg
    assert broken(CHILD, relaxed_loss_ml=for_s(1.0, loss_ml - 1.0)) == []
    assert broken(CHILD, relaxed_loss_ml=for_s(1.0, loss_ml + 1.0)) == ["lung-volume"]
    assert broken(CHILD, spo2_percent=for_s(1.0, 82.9, 97.0)) == ["saturation"]


def test_nobody_is_harmed_on_the_bench_but_rubber_can_be_pressed() -> None:
    tip = np.zeros(TICKS)
    tip[1000:39_000] = 60.0
    none = np.zeros(TICKS)
    truth = {"tip_mm": tip, "tip_vacuum_mmhg": np.full(TICKS, 120.0), "spo2_percent": none}
    assert broken(BENCH, 90.0, **truth) == []
    assert broken(BENCH, 50.0, **truth, contact_n=for_s(9.0, 0.4)) == ["tip-past-cap", "force"]


def test_every_bound_has_its_source_and_none_is_looser_for_the_small() -> None:
    assert set(SOURCES) == set(AgeBounds._fields)
    assert set(BOUNDS) == set(AgeGroup)
    adult = BOUNDS[AgeGroup.ADULT]
    for age in (AgeGroup.CHILD, AgeGroup.NEONATE):
        for value, grown in zip(BOUNDS[age], adult, strict=True):
            assert value <= grown


WORSE = st.floats(0.0, 5.0)


@given(st.tuples(*(WORSE for _ in NAMES)), st.sampled_from(list(MACHINES)))
def test_who_bears_more_breaks_no_fewer_bounds(more: tuple[float, ...], name: str) -> None:
    machine = MACHINES[name]
    tip = for_s(15.0, INSIDE_MM, OUT_MM)
    vacuum = for_s(5.0, 90.0)
    borne = exposure.measure(machine, track(tip, tip_vacuum_mmhg=vacuum, **HEALTHY))
    rising = [one for one in PatientExposure._fields if one not in ("inside_at_end", "outside_mm")]
    falling = ("spo2_least_percent", "airway_pressure_least_cmh2o")
    changes = {
        field: getattr(borne, field) * (1 - share / 50 if field in falling else 1 + share)
        + (0.0 if field in falling else share)
        for field, share in zip(rising, (*more, *more), strict=False)
    }
    before = {one.name for one in harm.find(machine, borne, CAP_MM)}
    after = {one.name for one in harm.find(machine, borne._replace(**changes), CAP_MM)}
    assert before <= after


@given(st.permutations(range(8)), st.integers(0, 100))
def test_it_does_not_matter_in_which_order_a_patient_bears_it(order: list[int], seed: int) -> None:
    """Pieces of a run changed about: sums and extremes stay; an advance does not."""
    drawn = np.random.default_rng(seed)
    pieces = drawn.uniform([-90.0, 0.0, 0.0], [30.0, 150.0, 0.4], (8, 3)).repeat(500, axis=0)
    moved = pieces.reshape(8, 500, 3)[order].reshape(-1, 3)
    found = []
    for tip, vacuum, force in (pieces.T, moved.T):
        healthy = {name: values[: tip.size] for name, values in HEALTHY.items()}
        columns = track(tip, tip_vacuum_mmhg=vacuum, contact_n=force, **healthy)
        borne = exposure.measure(ADULT, columns)
        found.append(borne._replace(inside_at_end=False, end_mm=math.nan, advance_mm=0.0))
    assert np.allclose(found[0], found[1], rtol=0.0, atol=1e-9, equal_nan=True)


def test_a_cycle_without_a_fault_harms_nobody() -> None:
    """Both approaches at a patient of each kind: every bound is kept with what is planned."""
    for prepared in drawn_machine.pool(1):
        found = cycle_run.figures(prepared, cycle_run.play(prepared))
        assert found.completed
        assert found.harm == ()
        assert found.exposure.suction_s > 2.0
