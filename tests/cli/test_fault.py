"""``cycle --fault`` as its users meet it."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.cli.command import opensuction, unrecorded
from tests.cli.test_cycle import PAPER_CYCLE, assert_refused

CYCLE = (*PAPER_CYCLE, "--compensation", "none")

BAD = [
    (("--fault", "valve-stuk"), "did you mean 'valve-stuck-open'"),
    (("--fault", "nonsense"), "unknown fault 'nonsense'; all 103 are in 'opensuction cycle"),
    (("--fault", "line-leak=900"), "0.02 to 50 mL/s/mmHg"),
    (("--fault", "line-leak@-3"), "-3 s"),
    (("--fault", "line-leak@1..2"), "'1..2' is not a number"),
    (("--fault", "line-leak@teaching+1"), "Known: checking"),
    (("--fault", "line-leak@200"), "200 s: an instant is from 0 s to less than 180 s"),
    (("--fault", "line-leak", "--fault", "pump-lost", "--fault", "valve-slow"), "at most 2"),
]


@pytest.mark.parametrize(("arguments", "named"), BAD, ids=[" ".join(a) for a, _ in BAD])
def test_a_fault_that_cannot_be_is_one_plain_line(
    arguments: tuple[str, ...], named: str, tmp_path: Path
) -> None:
    ran = opensuction("cycle", *arguments, "--json", cwd=tmp_path)
    assert_refused(ran, named, tmp_path)


def faulty_cycle(folder: Path, *faults: str) -> tuple[int, dict[str, Any]]:
    chosen = [argument for fault in faults for argument in ("--fault", fault)]
    ran = unrecorded(*CYCLE, *chosen, "--json", "--out", "run", cwd=folder)
    assert ran.stdout, ran.stderr
    return ran.returncode, json.loads(ran.stdout)


def test_json_says_what_was_injected_and_what_noticed_it(tmp_path: Path) -> None:
    status, data = faulty_cycle(tmp_path, "pump-runaway@suctioning+2", "line-clogged@3=0.5")
    assert status == 1
    assert data["outcome"] == "aborted"
    pump, clog = data["faults"]
    assert (pump["name"], pump["strength"]) == ("pump-runaway", None)
    assert (clog["name"], clog["strength"], clog["at_s"]) == ("line-clogged", 0.5, 3.0)
    noticed = pump["noticed"]
    assert noticed["by"] == "trip"
    assert noticed["name"] == "vacuum-exceeded"
    assert noticed["time_s"] == pytest.approx(pump["at_s"] + noticed["after_s"])
    assert json.loads((tmp_path / "run" / "cycle.json").read_text())["faults"] == data["faults"]
    report = (tmp_path / "run" / "report.html").read_text()
    assert "Injected fault: pump-runaway at" in report


@pytest.mark.parametrize(
    ("seed", "deeper_mm"),
    [
        ("30010", "20"),
        *(
            pytest.param(seed, deeper, marks=pytest.mark.soak)
            for seed, deeper in (("30010", "13"), ("30001", "13"), ("30003", "20"))
        ),
    ],
)
def test_a_carina_nearer_than_taught_is_told_while_the_tip_does_no_harm(
    tmp_path: Path, seed: str, deeper_mm: str
) -> None:
    """By travel no carina is expected: whatever was taught, a contact that lasts is told."""
    adult = ("--patient", "adult-icu", "--approach", "travel", "--seed", seed)
    taught = ("--fault", f"taught-too-deep={deeper_mm}")
    ran = unrecorded("cycle", *adult, *taught, "--json", "--out", "run", cwd=tmp_path)
    data = json.loads(ran.stdout)
    assert data["carina_force_peak_n"] > 0.0
    assert data["told"][0]["what"] == "contact-time"
    assert data["harm"] == data["broken_bounds"] == []
    assert not data["tip"]["inside_at_end"]


def test_a_harmless_fault_lets_the_cycle_complete_and_is_still_named(tmp_path: Path) -> None:
    status, data = faulty_cycle(tmp_path, "current-sensor-dead")
    assert status == 0
    (fault,) = data["faults"]
    assert fault["at_s"] == 0.0
    assert fault["noticed"] is None


def test_a_cycle_without_faults_has_none(tmp_path: Path) -> None:
    assert faulty_cycle(tmp_path)[1]["faults"] == []


def test_a_refused_start_is_an_aborted_cycle_that_says_why(tmp_path: Path) -> None:
    status, data = faulty_cycle(tmp_path, "catheter-expired=30")
    assert status == 1
    (fault,) = data["faults"]
    assert fault["noticed"]["by"] == "refusal"
    assert "used for 24 h" in fault["noticed"]["sentence"]


def test_an_instant_after_the_cycle_is_refused(tmp_path: Path) -> None:
    ran = opensuction(*CYCLE, "--fault", "pump-lost@150", "--json", cwd=tmp_path)
    assert_refused(ran, "never comes", tmp_path)


def test_a_controller_that_stops_is_told_as_such(tmp_path: Path) -> None:
    """Nobody asked for it; its catheter is in the airway until the drives have brought it out."""
    status, data = faulty_cycle(tmp_path, "power-lost@suctioning+2")
    assert status == 1
    (fault,) = data["faults"]
    assert fault["noticed"]["by"] == "drive"
    assert data["abort"] is None
    assert data["phases"][-1]["name"] == "halted"
    assert not data["tip"]["inside_at_end"]
    # Insertion, the valve's stroke, two seconds of suction: 13 s; the drives' withdrawal 8 s more.
    assert data["timing"]["in_airway_s"] == pytest.approx(21.0, abs=2.0)


def test_a_catheter_left_inside_is_what_is_said_first(tmp_path: Path) -> None:
    """The mains and the reserve are gone: the patient lies with it, however long one watches."""
    status, data = faulty_cycle(tmp_path, "power-lost-without-reserve@suctioning+1")
    assert status == 1
    tip, timing = data["tip"], data["timing"]
    assert tip["inside_at_end"]
    assert tip["end_mm"] > 50.0
    # By phases it was over as soon as no controller ran.
    assert timing["in_airway_s"] > 30.0
    report = (tmp_path / "run" / "report.html").read_text()
    said = f"CATHETER IS STILL IN THE AIRWAY, {tip['end_mm']:.1f} mm below the tube"
    assert said in report
    assert '<p class="outcome bad"' in report
