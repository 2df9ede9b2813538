"""Nothing is wrong, and nothing says so: drawn machines and patients, both approaches."""

import json
from pathlib import Path

import pytest

from opensuction.evidence.trial import false_alarm, fault_tally
from opensuction.evidence.trial.false_alarm import Quiet
from opensuction.evidence.trial.fault_campaign import APPROACHES, BASKET

KINDS = len(BASKET) * len(APPROACHES)


def loud(cases: list[Quiet]) -> list[Quiet]:
    return [case for case in cases if not case.ok]


@pytest.mark.parametrize(
    ("compensation", "first"),
    [("preview", 0), pytest.param("exact-inverse", KINDS, marks=pytest.mark.sweep)],
)
def test_a_sound_cycle_trips_nothing_and_tells_nothing(compensation: str, first: int) -> None:
    """Every patient by both approaches, each on a machine of its own."""
    cases, refused = false_alarm.campaign(range(first, first + KINDS), compensation, KINDS)
    assert refused == []
    assert {(case.patient, case.approach) for case in cases} == {
        (patient, approach) for _, patient in BASKET for approach in APPROACHES
    }
    assert loud(cases) == []


def test_what_is_told_without_a_reason_is_counted() -> None:
    quiet = Quiet(1, "neonate", "travel", True, (), (), ())
    assert quiet.ok
    assert quiet._replace(true_alarms=("SPO2_LOW",)).ok
    assert not quiet._replace(alarms=("LINE_CLOGGED",)).ok
    assert not quiet._replace(trips=("HEAD_STALLED",)).ok
    assert not quiet._replace(completed=False).ok


@pytest.mark.soak
def test_a_thousand_sound_cycles_trip_nothing_and_tell_nothing() -> None:
    """800 under the chosen compensation and 200 under the one it is held against."""
    chosen = false_alarm.campaign(range(1_000, 1_900), "preview", 800)
    other = false_alarm.campaign(range(2_000, 2_300), "exact-inverse", 200)
    cases, refused = chosen.cases + other.cases, chosen.refused + other.refused
    found = loud(cases)
    folder = Path("runs") / "soak"
    folder.mkdir(parents=True, exist_ok=True)
    result = {
        "in_silico": True,
        **fault_tally.bound(len(cases), len(found))._asdict(),
        "true_alarms": sum(bool(case.true_alarms) for case in cases),
        "refused": refused,
        "loud": [case._asdict() for case in found],
    }
    (folder / "false-alarm.json").write_text(json.dumps(result, indent=2) + "\n")
    assert len(cases) == 1_000
    assert found == []
