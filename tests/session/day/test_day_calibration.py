"""The conduit was laid otherwise: contact finds the gap over a day, the governor's bounds stay."""

from functools import cache

import pytest

from opensuction.identification.estimator.gap_measurement import (
    AS_IDENTIFIED,
    MEASURING_ERROR,
    TRUSTED,
)
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning.clinical import TEMPLATES
from opensuction.report import ending, notice, sheet
from opensuction.report.day import day_page
from opensuction.result.plain import to_json
from opensuction.safety.limits import GAP_LEAST, GAP_MOST
from opensuction.session.choice import CycleChoice, DayChoice, RigChoice
from opensuction.session.cycle import cycle_run, cycle_summary, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.day import day_fault, day_run, day_summary
from opensuction.session.day.day_run import Day

EVERY_MIN = 60.0
CYCLES = 3
TRACKED_MM = 0.25
"""Tracking error of a compensated adult by contact: .12 mm, with room for other machines."""


@cache
def began(scale: float) -> Prepared:
    choice = CycleChoice(approach="contact", gap_scale=scale)
    return cycle_run.prepare(resolution.resolve(choice))


@cache
def day(scale: float, self_calibrates: bool) -> Day:
    asked = DayChoice(CYCLES, EVERY_MIN, self_calibrates)
    return day_run.play(began(scale), asked, lambda *_: None)


@pytest.mark.parametrize("scale", [0.75, 1.2])
def test_the_second_cycle_compensates_what_the_first_one_felt(scale: float) -> None:
    errors = [cycle.outcome.rmse_mm for cycle in day(scale, True).cycles]
    assert len(errors) == CYCLES
    assert errors[0] > 1.5
    assert max(errors[1:]) < TRACKED_MM
    for cycle in day(scale, True).cycles:
        assert cycle.outcome.completed
        assert cycle.learned is not None
        assert cycle.learned.new.scale == pytest.approx(scale, abs=MEASURING_ERROR)


def test_without_self_calibration_nothing_is_learned() -> None:
    found = day(1.2, False)
    assert all(cycle.outcome.rmse_mm > 1.5 for cycle in found.cycles)
    assert all(cycle.learned is None for cycle in found.cycles)
    assert day_page.gap_sections(day_summary.summary(found).cycles) == ()


@pytest.mark.parametrize("scale", [0.75, 1.2])
def test_no_bound_of_the_governor_moves_inwards(scale: float) -> None:
    """Only where a forced withdrawal ends may change, and only farther out."""
    first = began(scale).loop.controller.limits
    last = day(scale, True).last.loop.controller.limits
    assert last._replace(park_head_mm=first.park_head_mm) == first
    assert last.park_head_mm <= first.park_head_mm


@pytest.mark.parametrize("scale", [0.75, 1.2])
def test_the_head_parks_anew_without_an_event(scale: float) -> None:
    found = day(scale, True)
    settings = found.last.loop.controller
    assert found.refusal is None
    assert found.last.start.controller.compensation.head_mm == pytest.approx(
        settings.parked.head_mm, abs=0.01
    )
    identified_mm = began(scale).loop.controller.parked.head_mm
    if scale > 1.0:
        assert settings.parked.head_mm < identified_mm - 1.0
    else:  # never farther in: the tip parks farther out instead
        assert settings.parked.head_mm == pytest.approx(identified_mm, abs=0.05)
        assert settings.plan.motion.park_mm < began(scale).rig.site.park_mm - 1.0
    assert all(cycle.outcome.trips == () for cycle in found.cycles)


def test_a_gap_out_of_its_range_lets_no_further_cycle_begin() -> None:
    found = day(0.6, True)
    assert len(found.cycles) == 1
    assert found.refusal is not None
    assert "0.67 to 1.33" in found.refusal
    change = found.cycles[0].learned
    assert change is not None
    assert (change.in_range, change.new) == (False, AS_IDENTIFIED)
    (alarm,) = day_summary.gap_alarms(found, 40.0)
    assert alarm.condition == "calibration-out-of-range"
    assert alarm.priority == "medium"
    assert ending.alarm(notice.gather([alarm], None)[0]).startswith(
        "Medium alarm, from 40.0 s on: "
    )
    (note,) = day_summary.gap_notes(found)
    assert "Cycle 2 of 3 was refused" in note
    last = cycle_summary.summary(found.last, found.columns)
    assert not day_page.page(last, day_summary.summary(found), found.samples).good


def test_a_patient_who_moves_at_the_carina_stops_no_day_and_is_told_of() -> None:
    """The contact of cycle 2 says a gap of .06: the conduit is as it was identified."""
    choice = CycleChoice(rig=RigChoice(seed=212), approach="contact")
    asked = DayChoice(CYCLES, every_min=30.0, self_calibrates=True)
    found = day_run.play(cycle_run.prepare(resolution.resolve(choice)), asked, lambda *_: None)
    assert found.refusal is None
    assert len(found.cycles) == CYCLES
    gap = day_summary.summary(found).cycles[1].gap
    assert gap is not None
    assert gap.contact_scale is not None
    assert gap.contact_scale < 0.67
    assert gap.contact_spoilt
    assert gap.finding == "learned"  # by the barrier
    assert gap.next_scale == pytest.approx(1.0, abs=0.1)
    assert any("the contact told nothing of the gap" in note for note in day_summary.notes(found))
    (section,) = day_page.gap_sections(day_summary.summary(found).cycles)
    assert gap.contact_spoilt in section.tables[0].rows[1]


def test_a_gap_that_the_cap_leaves_no_head_for_is_refused_with_the_arithmetic() -> None:
    """A wider gap needs more head; the cap does not grow with it."""
    found = day(1.3, True)
    assert len(found.cycles) == 1
    change = found.cycles[0].learned
    assert change is not None
    assert change.in_range
    assert found.refusal is not None
    assert "cap_mm" in found.refusal
    assert day_summary.gap_alarms(found, 40.0)


def test_the_json_and_the_page_show_each_scale_with_its_bounds() -> None:
    found = day(1.2, True)
    rows = day_summary.summary(found).cycles
    gaps = [to_json(row)["gap"] for row in rows]
    assert gaps[0]["used_scale"] == 1.0
    assert gaps[1]["used_scale"] == gaps[0]["next_scale"]
    assert {gap["least_scale"] for gap in gaps} == {TRUSTED.least}
    (section,) = day_page.gap_sections(rows)
    drawn = sheet.to_plain(section.plots[0])
    bounds = {curve["label"]: set(curve["y"]) for curve in drawn["curves"]}
    # The same in every cycle; a page rounds what it draws.
    assert [*bounds["least"], *bounds["most"]] == pytest.approx([TRUSTED.least, TRUSTED.most])
    assert drawn["x"] == [1.0, 2.0, 3.0]


def test_what_is_trusted_is_what_the_governor_allows_for() -> None:
    assert pytest.approx((GAP_LEAST, GAP_MOST), abs=1.01 * MEASURING_ERROR) == TRUSTED[:2]


@pytest.mark.parametrize(
    ("compensation", "approach", "repeat", "words"),
    [
        ("preview", "contact", 1, "--repeat 2"),
        ("none", "travel", 3, "'none' uses neither"),
    ],
)
def test_self_calibration_that_could_learn_nothing_is_refused(
    compensation: str, approach: str, repeat: int, words: str
) -> None:
    resolved = resolution.resolve(CycleChoice(approach=approach, compensation=compensation))
    every_min = EVERY_MIN if repeat > 1 else None
    with pytest.raises(InputError, match=words):
        day_fault.check(DayChoice(repeat, every_min, self_calibrates=True), resolved)


def test_a_contact_without_a_reversal_is_refused() -> None:
    resolved = resolution.resolve(CycleChoice(approach="contact"))
    without = resolved._replace(protocol=TEMPLATES["adult"]._replace(backoff_mm=0.0))
    with pytest.raises(InputError, match="backoff_mm is 0 mm"):
        day_fault.check(DayChoice(CYCLES, EVERY_MIN, self_calibrates=True), without)
