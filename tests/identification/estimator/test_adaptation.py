"""Two witnesses of a changed transmission: weighed by their errors, bounded, never forced."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from opensuction.identification.estimator import adaptation
from opensuction.identification.estimator.adaptation import (
    AdaptationChange,
    Evidence,
    Finding,
    Spoilt,
)
from opensuction.identification.estimator.gap_measurement import (
    AS_IDENTIFIED,
    TRUSTED,
    UNKNOWN,
    Missed,
    Shift,
)
from opensuction.safety import limits
from opensuction.safety.limits import GAP_LEAST, GAP_MOST

NAN = float("nan")
GAP_MM = 19.7
OLD = Shift(1.05, 0.4)
GOVERNED = TRUSTED._replace(least=GAP_LEAST, most=GAP_MOST)
"""Without the error of a measurement."""


def seen(contact: float = NAN, mouth: Shift = UNKNOWN, spoilt: Spoilt = Spoilt.NOTHING) -> Evidence:
    return Evidence(contact, mouth, Missed.NOTHING, spoilt)


def begun(shift: Shift = AS_IDENTIFIED) -> AdaptationChange:
    return adaptation.unchanged(TRUSTED)._replace(new=shift)


def learn(*evidence: Evidence, shift: Shift = AS_IDENTIFIED) -> AdaptationChange:
    """What came of the last of these cycles."""
    change = begun(shift)
    for one in evidence:
        change = adaptation.update(change, one, GAP_MM)
    return change


def test_one_witness_is_taken_as_it_is() -> None:
    mouth = learn(seen(mouth=Shift(0.9, 1.2)), shift=OLD)
    assert (mouth.new, mouth.finding) == (Shift(0.9, 1.2), Finding.LEARNED)
    contact = learn(seen(contact=0.9), shift=OLD)
    assert contact.new == Shift(0.9, OLD.offset_mm)  # a contact says nothing of the offset


def test_both_are_weighed_by_their_errors() -> None:
    change = learn(seen(1.15, Shift(1.1, 0.2)))
    assert change.new.offset_mm == 0.2
    assert change.new.scale == pytest.approx(1.105)  # .01 against .03: nine to one


@pytest.mark.parametrize("contact", [0.0, 0.3, 0.8, 1.13, 1.38, 1.6])
def test_a_patient_who_moves_at_the_carina_spoils_the_contact_and_not_the_day(
    contact: float,
) -> None:
    """The barrier says, and the cycles before say, that the gap is what it was."""
    change = learn(seen(1.0, Shift(1.0, 0.1)), seen(contact, Shift(1.01, 0.1)))
    assert (change.finding, change.in_range) == (Finding.LEARNED, True)
    assert change.seen.spoilt == Spoilt.MOVED
    assert change.seen.contact_scale == contact  # it stays on record
    assert change.new.scale == pytest.approx(1.01, abs=0.01)


@pytest.mark.parametrize("spoilt", [Spoilt.COUGHED, Spoilt.UNSTEADY])
def test_a_contact_with_a_cough_in_it_counts_for_nothing(spoilt: Spoilt) -> None:
    assert learn(seen(1.05, spoilt=spoilt)).finding == Finding.NOTHING_SEEN
    change = learn(seen(1.15, Shift(1.1, 0.0), spoilt))
    assert change.new.scale == pytest.approx(1.1)


def test_a_barrier_that_leaves_the_course_against_a_sound_contact_is_not_believed_either() -> None:
    change = learn(seen(1.0, Shift(1.2, 0.2)), shift=OLD)
    assert (change.new, change.finding, change.in_range) == (OLD, Finding.CONTRADICTION, True)
    assert math.isnan(change.found.scale)


def test_both_witnesses_out_of_range_are_told_at_once() -> None:
    change = learn(seen(0.61, Shift(0.6, 0.0)))
    assert (change.new, change.finding) == (AS_IDENTIFIED, Finding.OUT_OF_RANGE)
    assert not change.in_range


ALONE = [
    seen(contact=1.4),
    seen(contact=0.6),
    seen(mouth=Shift(1.4, 0.0)),
    seen(mouth=Shift(1.0, 3.5)),
    seen(mouth=Shift(1.0, -3.5)),
    seen(mouth=Shift(1.2, 2.0)),
    seen(contact=1.0, mouth=Shift(1.0, 5.0)),
]
"""Out of range by one witness."""


@pytest.mark.parametrize("evidence", ALONE)
def test_what_one_witness_has_out_of_range_is_dropped_once_and_told_the_second_time(
    evidence: Evidence,
) -> None:
    once = learn(evidence)
    assert (once.new, once.finding, once.in_range) == (AS_IDENTIFIED, Finding.DOUBTED, True)
    twice = adaptation.update(once, evidence, GAP_MM)
    assert (twice.new, twice.finding) == (AS_IDENTIFIED, Finding.OUT_OF_RANGE)


@pytest.mark.parametrize("evidence", ALONE)
def test_a_wrong_value_now_and_then_stops_no_day(evidence: Evidence) -> None:
    sound = seen(1.0, Shift(1.0, 0.0))
    assert learn(evidence, sound, evidence).finding == Finding.DOUBTED
    assert learn(evidence, sound, evidence, sound).new.scale == pytest.approx(1.0)


def test_a_contact_alone_is_believed_far_off_when_it_says_so_again() -> None:
    once = learn(seen(contact=1.3))
    assert (once.new, once.finding) == (AS_IDENTIFIED, Finding.DOUBTED)
    twice = adaptation.update(once, seen(contact=1.29), GAP_MM)
    assert (twice.finding, twice.new.scale) == (Finding.LEARNED, 1.29)


@pytest.mark.parametrize("scale", [0.75, 0.9, 1.1, 1.25])
@pytest.mark.parametrize("contact", [NAN, 0.0, 1.4])
def test_a_conduit_that_was_laid_otherwise_is_found_in_one_cycle(
    scale: float, contact: float
) -> None:
    """Also where the patient moves at the carina in that very cycle."""
    assert learn(seen(contact, Shift(scale, 0.0))).new.scale == pytest.approx(scale)
    # The same in the middle of a day on a quiet patient.
    quiet = [seen(mouth=Shift(1.0, 0.0))] * 10
    change = learn(*quiet, seen(mouth=Shift(scale, 0.0)))
    assert change.new.scale == pytest.approx(scale)


def day_errors(seed: int, still: float) -> tuple[float, float, float]:
    """RMS error of the scale over 30 cycles: as identified, by the last one, by the course.

    A patient who is moved between two cycles, but for a share ``still`` of them.
    """
    rng, change, scale = np.random.default_rng(seed), begun(), 1.0
    errors, last = [], 1.0
    for _ in range(30):
        errors.append((scale - 1.0, scale - last, scale - change.new.scale))
        last = scale + 0.005 * rng.normal()
        change = adaptation.update(change, seen(mouth=Shift(last, 0.0)), GAP_MM)
        if rng.random() > still:
            scale = 1.0 + 0.04 * float(np.clip(rng.normal(), -3.3, 3.3))
    identified, latest, course = np.sqrt(np.mean(np.square(errors), axis=0))
    return float(identified), float(latest), float(course)


@pytest.mark.parametrize("still", [0.1, 0.37, 0.6])
def test_a_patient_who_is_moved_is_not_tracked_worse_than_by_the_identified_gap(
    still: float,
) -> None:
    """.9 mm of tracking error are 10 % of the gap; asked for are .1 mm a day at most."""
    days = np.array([day_errors(seed, still) for seed in range(200)])
    identified, latest, course = days.T
    assert np.mean(course) < 1.08 * np.mean(identified)
    assert np.mean(course) < np.mean(latest)
    # 59 of 60 days; .13 mm in the worst of 600, and .22 mm by the last measurement alone.
    assert np.percentile(course - identified, 98.3) < 0.011


def test_a_contact_is_held_with_the_offset_in_use() -> None:
    """It says nothing of the offset, but what would be used must be in range as a whole."""
    assert learn(seen(contact=1.12)).finding == Finding.LEARNED
    deeper = Shift(1.0, 2.2)
    change = learn(seen(contact=1.12), seen(contact=1.12), shift=deeper)
    assert (change.new, change.finding) == (deeper, Finding.OUT_OF_RANGE)
    assert change.found == Shift(1.12, 2.2)
    # A barrier that saw the offset shrink goes before the one in use.
    both = learn(seen(1.12, Shift(1.11, 0.5)), shift=deeper)
    assert both.finding == Finding.LEARNED


def test_nothing_seen_changes_nothing_and_is_no_alarm() -> None:
    change = learn(adaptation.NO_EVIDENCE, shift=OLD)
    assert (change.new, change.finding, change.in_range) == (OLD, Finding.NOTHING_SEEN, True)


@given(
    scale=st.floats(0.6, 1.4),
    offset_mm=st.floats(-4.0, 4.0),
    ways=st.lists(st.floats(-150.0, 100.0), min_size=1, max_size=6),
)
def test_the_governor_bounds_every_tip_that_is_trusted(
    scale: float, offset_mm: float, ways: list[float]
) -> None:
    """A single play of the learned gap, over any way: where it is both extremes of the gap allow.

    That is why the offset's bound depends on the gap's: an offset takes of the room of a width.
    """
    assume(adaptation.is_trusted(Shift(scale, offset_mm), GAP_MM, GOVERNED))
    bounds = limits.bound_tip(gain=0.967, offset_mm=-6.0, gap_mm=GAP_MM)
    half_mm = 0.5 * scale * GAP_MM / bounds.gain
    last = -200.0
    behind, interval = last + half_mm, limits.assume_anywhere(bounds, last)
    for goal in [*ways, 120.0, -200.0]:
        for head in np.linspace(last, goal, 20):
            behind = min(max(behind, head - half_mm), head + half_mm)
            interval = limits.follow(bounds, interval, float(head))
            tip_mm = bounds.gain * behind + bounds.offset_mm + offset_mm
            assert tip_mm <= limits.deepest_mm(bounds, interval) + 1e-6
            assert tip_mm >= limits.shallowest_mm(bounds, interval) - 1e-6
        last = goal
