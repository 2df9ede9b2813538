"""Result of a hazard's runs: the worst of them, and its presentation."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from opensuction.evidence.safety_case import hazard, hazard_case, hazard_result, safety_case
from opensuction.evidence.safety_case.hazard_claim import Hazard
from opensuction.evidence.safety_case.hazard_result import HazardResult
from opensuction.evidence.safety_case.safety_case import HazardVerdict, SafetyCase
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import Harm
from opensuction.report import sheet
from opensuction.report.safety_case import safety_case_page
from opensuction.result.cycle_result import LeftInsideCount
from opensuction.result.plain import to_json
from opensuction.result.safety_case_result import (
    HarmSearchResult,
    HarmSearchRun,
    StripChart,
    WorstExposure,
)
from opensuction.simulation.injection.fault_instant import FaultInstant
from opensuction.simulation.injection.run_judgement import LeftInside
from tests.evidence.safety_case.hazard_example import FAULT, ROW, WEAK

GENTLE = PatientExposure(
    inside_at_end=False,
    end_mm=-100.0,
    outside_mm=-80.0,
    piece_mm=0.0,
    in_airway_s=20.0,
    suction_s=8.0,
    vacuum_peak_mmhg=120.0,
    advance_mm=0.1,
    deepest_mm=50.0,
    past_carina_mm=0.0,
    force_peak_n=0.1,
    contact_s=0.0,
    pressure_unsafe_s=0.0,
    airway_pressure_least_cmh2o=4.0,
    lung_volume_loss_ml=100.0,
    spo2_least_percent=95.0,
)
ROWS = 50


def strip() -> StripChart:
    time_s = np.linspace(10.0, 30.0, ROWS, dtype=np.float32)
    still = np.zeros(ROWS, dtype=np.float32)
    return StripChart(
        time_s=time_s,
        head_mm=80.0 - time_s,
        tip_mm=75.0 - time_s,
        vacuum_mmhg=120.0 + still,
        valve_percent=still,
        reaction=still,
        priority=still,
    )


@pytest.fixture
def one(tmp_path: Path) -> Hazard:
    path = tmp_path / "mine.toml"
    path.write_text(ROW + FAULT + WEAK, encoding="utf-8")
    return hazard.load(path)[0]


def result(
    one: Hazard, seed: int, detected_ms: float, safe_ms: float, problem: str = ""
) -> HazardResult:
    case = hazard_case.cases(one, (seed,))[0]._replace(at=FaultInstant(Phase.OPENING, 0.2))
    alarm = "" if math.isnan(detected_ms) else "VACUUM_EXCEEDED"
    return HazardResult(
        case=case,
        alarm=alarm,
        by="controller" if alarm else "",
        priority="high" if alarm else "none",
        at_s=15.0,
        detected_ms=detected_ms,
        detected_bound_ms=2000.0,
        safe_ms=safe_ms,
        safe_bound_ms=10000.0,
        within_limits=False,
        exposure=GENTLE._replace(force_peak_n=0.01 * seed, spo2_least_percent=99.0 - seed),
        harm=(),
        left_inside=None,
        problem=problem,
        strip=strip(),
    )


def test_the_worst_run_is_the_one_nearest_to_a_bound(one: Hazard) -> None:
    # Shares of the bounds 2000 and 10000 ms: 0.5, 0.9, 0.6
    runs = (result(one, 1, 1000, 4000), result(one, 2, 100, 9000), result(one, 3, 1200, 1000))
    assert HazardVerdict(one, runs).worst.case.seed == 2


def test_a_broken_run_is_worse_than_one_that_took_longer(one: Hazard) -> None:
    runs = (result(one, 1, 1900, 9900), result(one, 2, 100, 900, "force 0.40 N, limit 0.3"))
    found = HazardVerdict(one, runs)
    assert found.worst.case.seed == 2
    assert not found.ok


def test_a_run_that_needed_no_alarm_hides_none_that_did(one: Hazard) -> None:
    runs = (result(one, 1, math.nan, 0.0), result(one, 2, 1000, 4000))
    assert HazardVerdict(one, runs).worst.case.seed == 2


def test_the_json_holds_times_bounds_and_every_broken_run(one: Hazard) -> None:
    broken = result(one, 2, math.nan, math.nan, "no expected alarm; safe state not reached")
    found = SafetyCase((1, 2), (HazardVerdict(one, (result(one, 1, 1000, 4000), broken)),))
    data = to_json(safety_case.summarise(found, 1.0))
    (entry,) = data["hazards"]
    assert data["ok"] is entry["ok"] is False
    assert (entry["runs"], entry["broken"]) == (2, 1)
    assert entry["detected_ms"] is None
    assert (entry["detected_bound_ms"], entry["safe_bound_ms"]) == (2000.0, 10000.0)
    assert [problem["seed"] for problem in entry["problems"]] == [2]
    assert entry["exposure"]["force_peak_n"] == 0.02
    assert entry["exposure"]["spo2_least_percent"] == 97.0
    assert entry["harm"] == []
    assert entry["left_inside"] == {"count": 0, "unavoidable": 0, "told": 0}


def test_a_cycle_that_was_refused_leaves_no_number_that_json_does_not_have(one: Hazard) -> None:
    # Its fault was never given an instant, and no patient bore anything.
    unplaced = hazard_case.cases(one, (1,))[0]
    run = hazard_result.refused(unplaced, "the tube is too narrow")
    verdict = HazardVerdict(one, (run,))
    found = safety_case.summarise(SafetyCase((1,), (verdict,)), 1.0)
    data = to_json(found)
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    (problem,) = found.hazards[0].problems
    assert problem.after_s is None
    assert problem.problem == "the cycle cannot be planned: the tube is too narrow"
    assert set(found.hazards[0].exposure) == {None}
    page = safety_case_page.page(found, [safety_case.detail(verdict, found.hazards[0])])
    assert page.sections[-1].plots == ()


def test_every_measure_of_the_patient_stands_in_the_result() -> None:
    places = {"inside_at_end", "outside_mm"}
    assert set(WorstExposure._fields) == set(PatientExposure._fields) - places


SEARCHED = HarmSearchRun(
    fault="pump-weak",
    after_s=12.5,
    strength=0.25,
    approach="travel",
    patient="neonate",
    seed=2,
    spread=2.0,
    bound="force",
    worst=0.21,
    limit=0.3,
    unit="N",
    share=0.704,
    told=False,
    broken=(),
    unavoidable=(),
)


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (HarmSearchResult(0, 0, None, (), ()), "-"),
        (HarmSearchResult(9, 0, SEARCHED, (), ()), "70 % to force"),
        (HarmSearchResult(9, 0, SEARCHED._replace(share=0.004), (), ()), "nothing borne"),
        (HarmSearchResult(9, 0, SEARCHED._replace(share=-0.2), (), ()), "nothing borne"),
        (HarmSearchResult(9, 0, SEARCHED._replace(share=None), (), ()), "beyond force"),
        (
            HarmSearchResult(9, 2, SEARCHED._replace(share=None), (SEARCHED,) * 2, ()),
            "2 of 9 broken",
        ),
        (HarmSearchResult(9, 0, SEARCHED, (), (SEARCHED,)), "70 % to force, 1 too slow"),
    ],
)
def test_a_search_is_told_by_its_broken_runs_or_by_its_nearest(
    found: HarmSearchResult, words: str
) -> None:
    assert safety_case_page.describe_search(found) == words


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (
            SEARCHED,
            "pump-weak@12.5=0.25, neonate by travel, seed 2: force 0.21 N of 0.3; it broke none, "
            "and nobody was told.",
        ),
        (
            SEARCHED._replace(after_s=None, strength=None, told=True, broken=("force", "vacuum")),
            "pump-weak, neonate by travel, seed 2: force 0.21 N of 0.3; it broke force, vacuum, "
            "and people were told.",
        ),
        (
            SEARCHED._replace(worst=None, limit=None),
            "pump-weak@12.5=0.25, neonate by travel, seed 2: force - N of -; it broke none, and "
            "nobody was told.",
        ),
    ],
)
def test_the_page_tells_the_worst_searched_run(one: Hazard, run: HarmSearchRun, words: str) -> None:
    verdict = HazardVerdict(one, (result(one, 1, 1000, 4000),))
    found = safety_case.summarise(SafetyCase((1,), (verdict,)), 1.0)
    searched = found.hazards[0]._replace(searched=HarmSearchResult(40, 0, run, (), ()))
    page = safety_case_page.page(found, [safety_case.detail(verdict, searched)])
    assert page.sections[-1].text[-1] == f"Worst of 40 searched runs: {words}"


def test_left_inside_is_counted_on_its_own_with_its_argument(one: Hazard) -> None:
    harm = Harm("left-inside", 30.0, -80.0, "mm")
    stays = LeftInside("nothing can move it", "Draw it out by hand.", 0.1, in_time=True)
    unneeded = LeftInside("", "Draw the catheter out by hand.", math.nan, in_time=False)
    runs = (
        result(one, 1, 1000, 4000),
        result(one, 2, 100, math.nan)._replace(harm=(harm,), left_inside=stays),
        result(one, 3, 100, math.nan, "left inside")._replace(harm=(harm,), left_inside=unneeded),
    )
    found = safety_case.summarise(SafetyCase((1, 2, 3), (HazardVerdict(one, runs),)), 1.0)
    (entry,) = found.hazards
    assert entry.left_inside == LeftInsideCount(count=2, unavoidable=1, told=1)
    assert found.left_inside == entry.left_inside
    assert entry.unavoidable == ("nothing can move it",)
    assert "Draw it out by hand." in entry.person
    assert entry.harm == ("left-inside",)
    assert not entry.ok


def test_the_page_shows_what_is_broken_and_marks_the_worst_run(one: Hazard) -> None:
    late = result(one, 7, 1900, 12000, "safe after 12000 ms, bound 10000")
    verdict = HazardVerdict(one, (late,))
    found = safety_case.summarise(SafetyCase((1, 7), (verdict,)), 1.0)
    page = safety_case_page.page(found, [safety_case.detail(verdict, found.hazards[0])])
    assert not page.good
    section = page.sections[-1]
    assert section.anchor == "OS-H01"
    assert section.title.endswith("broken")
    marks = [(mark.name, mark.value) for mark in section.plots[0].marks]
    assert marks == [("fault", 15.0), ("alarm", 16.9), ("safe", 27.0)]
    html = sheet.render(page)
    assert "safe after 12000 ms, bound 10000" in html
    assert "pump-runaway@opening+0.2, adult-icu by travel, seed 7" in html
