"""The result of a trial, and its JSON object, whose keys are a contract."""

import json
import math

from opensuction.evidence.trial import trial, trial_summary
from opensuction.evidence.trial.judged_cycle import Case
from opensuction.evidence.trial.trial import PlayedPart
from opensuction.evidence.trial.trial_summary import Effort
from opensuction.result.plain import to_json
from opensuction.result.trial_result import LateFaults, Trial, TrialResult
from opensuction.twin.fault.fault import Fault
from tests.evidence.trial.example import BREACH, HARM, STAYS, case

EFFORT = Effort(workers=2, wall_s=60.04, cycles=0, date_utc="2026-11-23")
SINGLE = Trial()
PAIR = (Fault.PUMP_LOST, Fault.LINE_LEAK)


def summarise(*cases: Case) -> TrialResult:
    heading = trial.make_heading(SINGLE, len(cases))
    return trial_summary.summarise(heading, [PlayedPart(0, cases, ())], EFFORT)


def test_violations_are_listed_by_number_then_by_bound() -> None:
    both = case(3, *PAIR)._replace(breaches=(HARM,), commands=(BREACH,))
    other = case(2)._replace(breaches=(HARM,))
    command, force = trial_summary.list_violations(SINGLE, [both])
    assert (command.number, command.bound, command.is_command) == (3, "a bound", True)
    assert (force.faults, force.bound, force.is_command) == (("line-leak", "pump-lost"), "force", 0)
    assert (force.counted, force.worst, force.limit) == (2, 0.4, 0.3)
    assert force.play == "opensuction trial --play 3 --faults single"
    listed = trial_summary.list_violations(SINGLE, [both, other])
    assert [one.number for one in listed] == [2, 3, 3]


def test_left_inside_is_one_object_with_its_total_in_it() -> None:
    stays = case(1, Fault.MOTOR_STALLED)._replace(left_inside=STAYS._replace(told_s=3.5))
    late = stays._replace(number=2, left_inside=STAYS._replace(told_s=9.0, in_time=False))
    needless = case(3, *PAIR)._replace(left_inside=STAYS._replace(unavoidable=""))
    found = to_json(summarise(stays, late, needless))["left_inside"]
    assert list(found) == ["count", "unavoidable", "told", "by_faults", "slowest_told_s", "because"]
    assert (found["count"], found["unavoidable"], found["told"]) == (3, 2, 2)
    assert found["by_faults"]["double"] == {"count": 1, "unavoidable": 0, "told": 1}
    assert found["slowest_told_s"] == 3.5
    assert found["because"][0] == {
        "unavoidable": "it is held fast",
        "person": "Draw it out.",
        "count": 2,
        "faults": {"motor-stalled": 2},
    }
    assert found["because"][1]["faults"] == {"line-leak + pump-lost": 1}


def test_bounds_stand_side_by_side_whatever_they_are_of() -> None:
    broken = case(2, Fault.PUMP_LOST)._replace(breaches=(HARM,))
    found = to_json(summarise(case(1), broken, case(3, *PAIR)))["bounds"]
    assert list(found) == ["commands", "none", "single", "double", "false_alarms"]
    assert [found[name]["cycles"] for name in found] == [3, 1, 1, 1, 1]
    assert found["single"] == {"cycles": 1, "broken": 1, "upper_percent": 100.0}


def test_an_endpoint_that_no_cycle_has_is_left_out_of_the_json() -> None:
    dry = case(1).endpoints._replace(removed_percent=None)
    found = to_json(summarise(case(1)._replace(endpoints=dry)))["endpoints"]["adult-icu"]
    assert (found["cycles"], found["completed"]) == (1, 1)
    assert "removed_percent" not in found
    assert found["suction_s"] == {"median": 12.0, "p5": 12.0, "p95": 12.0}


def test_faults_that_came_too_late_are_not_counted() -> None:
    pair = case(1, *PAIR)
    late = pair._replace(faults=(pair.faults[0], pair.faults[1]._replace(counts=False)))
    found = summarise(late, late._replace(number=2))
    assert found.not_counted == LateFaults(2, {"line-leak": 2})
    assert found.counted == (0, 2, 0)


def test_a_trial_that_played_nothing_itself_has_no_rate() -> None:
    found = to_json(summarise(case(1)))
    assert (found["wall_s"], found["cycles_per_s"]) == (60.0, None)
    assert found["trial"] == {
        "faults": "single",
        "cohort": "presets",
        "seed": 1,
        "compensation": "preview",
        "preoxygenation": "confirmed",
    }


def test_what_has_no_number_in_a_cycle_is_null_in_its_json() -> None:
    """JSON has no NaN and no Infinity."""
    cycle = case(4, Fault.PUMP_LOST)._replace(
        breaches=(HARM._replace(worst=math.nan),),
        commands=(BREACH._replace(worst=math.inf),),
        left_inside=STAYS._replace(told_s=math.nan, in_time=False),
        endpoints=case(4).endpoints._replace(removed_percent=None),
    )
    found = to_json(trial_summary.summarise_case(SINGLE, cycle))
    assert [one["worst"] for one in found["violations"]] == [None, None]
    assert found["left_inside"]["told_s"] is None
    assert found["endpoints"]["removed_percent"] is None
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_a_cycle_with_its_tip_outside_has_nothing_left_inside() -> None:
    found = to_json(trial_summary.summarise_case(SINGLE, case(4)))
    assert found["left_inside"] is None
    assert found["endpoints"]["force_peak_n"] == 0.1
    assert list(found) == [
        "number",
        "play",
        "counted",
        "told",
        "false_alarms",
        "true_alarms",
        "left_inside",
        "violations",
        "endpoints",
        "watched_s",
    ]
