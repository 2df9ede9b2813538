from typing import Any

from opensuction.report.cycle import page
from opensuction.report.cycle.page import Instant
from tests.report import example


def alarm(condition: str, started_s: float | None) -> dict[str, Any]:
    return {"condition": condition, "started_s": started_s}


def test_faults_come_before_alarms_each_at_its_time() -> None:
    result = example.good(
        faults=[{"name": "pump-weak", "at_s": 5.5}, {"name": "valve-jammed", "at_s": 2.0}],
        alarms=[alarm("vacuum-lost", 14.4)],
    )
    assert page.instants(result) == [
        Instant("Fault: valve jammed", "fault", 2.0),
        Instant("Fault: pump weak", "fault", 5.5),
        Instant("Alarm: vacuum lost", "bad", 14.4),
    ]


def test_what_comes_together_stands_at_one_mark_and_is_named_once() -> None:
    times = {"vacuum-lost": 3.0, "automation-stopped": 3.2, "line-clogged": 3.6}
    alarms = [alarm(name, time_s) for name, time_s in times.items()] + [alarm("vacuum-lost", 3.1)]
    found = page.instants(example.good(alarms=alarms))
    assert [(entry.label, entry.time_s) for entry in found] == [
        ("Alarm: vacuum lost, automation stopped", 3.0),
        ("Alarm: line clogged", 3.6),
    ]


def test_a_fault_that_never_came_is_not_marked_and_a_sound_cycle_has_no_mark() -> None:
    never = example.good(faults=[{"name": "pump-weak", "at_s": None}])
    assert page.instants(never) == []
    assert page.instants(example.good()) == []
