"""What the runs of a hazard come to: the worst of them, and what is shown of it."""

import math
from pathlib import Path

import numpy as np
import pytest

from opensuction.evidence.safety_case import hazard, hazard_case, hazard_detail, safety_case
from opensuction.evidence.safety_case.hazard import Hazard
from opensuction.evidence.safety_case.hazard_result import STRIP, Exposure, HazardResult, Strip
from opensuction.evidence.safety_case.safety_case import HazardVerdict, SafetyCase
from opensuction.report import sheet
from opensuction.report.safety_case import safety_case_page
from tests.evidence.safety_case.hazard_example import FAULT, ROW, WEAK

GENTLE = Exposure(
    contact_n=0.1, beyond_cap_mm=-5.0, vacuum_mmhg=120.0, suction_s=8.0, in_airway_s=20.0
)
ROWS = 50


def strip() -> Strip:
    time_s = np.linspace(10.0, 30.0, ROWS, dtype=np.float32)
    still = np.zeros(ROWS, dtype=np.float32)
    return dict.fromkeys(STRIP, still) | {
        "time_s": time_s,
        "head_mm": 80.0 - time_s,
        "tip_mm": 75.0 - time_s,
        "vacuum_mmhg": 120.0 + still,
    }


@pytest.fixture
def one(tmp_path: Path) -> Hazard:
    path = tmp_path / "mine.toml"
    path.write_text(ROW + FAULT + WEAK, encoding="utf-8")
    return hazard.load(path)[0]


def result(
    one: Hazard, seed: int, detected_ms: float, safe_ms: float, problem: str = ""
) -> HazardResult:
    case = hazard_case.cases(one, (seed,))[0]
    alarm = "" if math.isnan(detected_ms) else "VACUUM_EXCEEDED"
    return HazardResult(
        case=case,
        alarm=alarm,
        priority="high" if alarm else "none",
        at_s=15.0,
        detected_ms=detected_ms,
        safe_ms=safe_ms,
        within_limits=False,
        exposure=GENTLE._replace(contact_n=0.01 * seed),
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
    data = safety_case.plain(found, 1.0)
    (entry,) = data["hazards"]
    assert data["ok"] is entry["ok"] is False
    assert (entry["runs"], entry["broken"]) == (2, 1)
    assert entry["detected_ms"] is None
    assert (entry["detected_bound_ms"], entry["safe_bound_ms"]) == (2000.0, 10000.0)
    assert [problem["seed"] for problem in entry["problems"]] == [2]
    assert entry["harm"]["contact_n"] == 0.02


def test_the_page_shows_what_is_broken_and_marks_the_worst_run(one: Hazard) -> None:
    late = result(one, 7, 1900, 12000, "safe after 12000 ms, bound 10000")
    verdict = HazardVerdict(one, (late,))
    data = safety_case.plain(SafetyCase((1, 7), (verdict,)), 1.0)
    page = safety_case_page.page(data, [hazard_detail.detail(verdict)])
    assert not page.good
    section = page.sections[1]
    assert section.title.endswith("broken")
    marks = [(mark.name, mark.value) for mark in section.plots[0].marks]
    assert marks == [("fault", 15.0), ("alarm", 16.9), ("safe", 27.0)]
    html = sheet.render(page)
    assert "safe after 12000 ms, bound 10000" in html
    assert "pump-runaway@opening+0.2, seed 7" in html
