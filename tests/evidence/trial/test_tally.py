"""A trial is counted by how many of its faults could matter."""

import pytest

from opensuction.evidence.trial import trial_summary
from opensuction.result.cycle_result import LeftInsideCount
from opensuction.result.trial_result import EndpointSpread, LateFaults
from opensuction.twin.fault.fault import Fault
from tests.evidence.trial.example import BREACH, HARM, STAYS, case

ALONE, PAIR = (Fault.PUMP_LOST,), (Fault.PUMP_LOST, Fault.LINE_LEAK)


def test_left_inside_is_counted_by_how_many_faults_came() -> None:
    alone = case(1, Fault.MOTOR_STALLED)._replace(left_inside=STAYS)
    late = alone._replace(left_inside=STAYS._replace(in_time=False))
    unneeded = alone._replace(left_inside=STAYS._replace(unavoidable=""))
    found = trial_summary.by_faults(
        [alone, late, unneeded, case(2, *ALONE)], trial_summary.left_inside
    )
    assert found.single == LeftInsideCount(count=3, unavoidable=2, told=2)
    assert found.none == found.double == LeftInsideCount(count=0, unavoidable=0, told=0)


def test_what_was_broken_is_counted_by_how_many_faults_came() -> None:
    broken = case(3, *PAIR)._replace(breaches=(HARM,))
    found = trial_summary.count_bounds([case(1), case(2, *ALONE), broken, case(4, *PAIR)])
    assert found.patient.none[:2] == found.patient.single[:2] == (1, 0)
    assert found.patient.double[:2] == (2, 1)
    assert found.commands[:2] == (4, 0)


def test_a_fault_that_came_too_late_does_not_count() -> None:
    pair = case(1, *PAIR)
    late = pair._replace(faults=(pair.faults[0], pair.faults[1]._replace(counts=False)))
    found = trial_summary.count_bounds([late]).patient
    assert (found.single.cycles, found.double.cycles) == (1, 0)
    assert trial_summary.count_too_late([late]) == LateFaults(1, {"line-leak": 1})
    assert trial_summary.title(late) == ("pump-lost",)
    assert trial_summary.unnoticed([late]) == {}  # it did not come alone


def test_a_breach_of_a_command_counts_whatever_came() -> None:
    broken = case(1)._replace(commands=(BREACH,))
    assert trial_summary.count_bounds([broken, case(2, *ALONE)]).commands[:2] == (2, 1)


def test_false_alarms_are_those_of_cycles_without_a_fault() -> None:
    false = case(1)._replace(false_alarms=("LINE_CLOGGED",))
    true = case(2)._replace(true_alarms=("SPO2_LOW",))
    found = trial_summary.count_bounds([false, true, case(3), case(4, *ALONE)]).false_alarms
    assert found[:2] == (3, 1)


def test_the_bound_on_a_share_is_the_exact_one() -> None:
    """With none in n cycles: 1 - 0.05^(1/n)."""
    assert trial_summary.bound(100, 0).upper_percent == pytest.approx(100.0 * (1 - 0.05**0.01))
    assert trial_summary.bound(3, 3).upper_percent == 100.0


def test_endpoints_are_percentiles_of_what_has_a_number() -> None:
    cases = [
        case(number)._replace(
            endpoints=case(0).endpoints._replace(removed_ml=float(number), removed_percent=percent)
        )
        for number, percent in zip(range(101), [None] + [50.0] * 100, strict=True)
    ]
    found = trial_summary.endpoints(cases)
    assert (found.cycles, found.completed) == (101, 101)
    assert found.removed_ml == pytest.approx((50.0, 5.0, 95.0))
    assert found.removed_percent == pytest.approx((50.0, 50.0, 50.0))


def test_an_endpoint_without_a_number_in_any_cycle_has_no_spread() -> None:
    nothing_there = case(1).endpoints._replace(removed_ml=0.0, removed_percent=None)
    found = trial_summary.endpoints([case(1)._replace(endpoints=nothing_there)])
    assert found.removed_percent is None
    assert found.removed_ml == EndpointSpread(0.0, 0.0, 0.0)


def test_what_nobody_was_told_of_is_counted_by_fault() -> None:
    told = case(2, *ALONE)._replace(told=True)
    found = trial_summary.unnoticed([case(1, *ALONE), told, case(3), case(4, *PAIR)])
    assert found == {"pump-lost": (2, 1)}
