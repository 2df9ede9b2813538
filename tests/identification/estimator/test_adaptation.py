"""Two witnesses of a changed transmission: weighed by their errors, bounded, never forced."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from opensuction.identification.estimator import adaptation
from opensuction.identification.estimator.adaptation import Evidence, Finding
from opensuction.identification.estimator.gap_scale import TRUSTED
from opensuction.identification.estimator.mouth_passage import (
    AS_IDENTIFIED,
    UNKNOWN,
    Missed,
    Shift,
)
from opensuction.safety import tip_bound
from opensuction.safety.tip_bound import GAP_LEAST, GAP_MOST

NAN = float("nan")
GAP_MM = 19.7
OLD = Shift(1.05, 0.4)
GOVERNED = TRUSTED._replace(least=GAP_LEAST, most=GAP_MOST)
"""Without the error of a measurement."""


def seen(contact: float = NAN, mouth: Shift = UNKNOWN) -> Evidence:
    return Evidence(contact, mouth, Missed.NOTHING)


def test_one_witness_is_taken_as_it_is() -> None:
    mouth = adaptation.update(OLD, seen(mouth=Shift(0.9, 1.2)), GAP_MM, TRUSTED)
    assert (mouth.new, mouth.finding) == (Shift(0.9, 1.2), Finding.LEARNED)
    contact = adaptation.update(OLD, seen(contact=0.9), GAP_MM, TRUSTED)
    assert contact.new == Shift(0.9, OLD.offset_mm)  # a contact says nothing of the offset


def test_both_are_weighed_by_their_errors() -> None:
    change = adaptation.update(OLD, seen(1.05, Shift(1.0, 0.2)), GAP_MM, TRUSTED)
    assert change.new.offset_mm == 0.2
    assert change.new.scale == pytest.approx(1.005)  # .01 against .03: nine to one


def test_witnesses_that_contradict_each_other_are_both_left_alone() -> None:
    change = adaptation.update(OLD, seen(1.1, Shift(1.0, 0.2)), GAP_MM, TRUSTED)
    assert (change.new, change.finding, change.in_range) == (OLD, Finding.CONTRADICTION, True)
    assert math.isnan(change.found.scale)


@pytest.mark.parametrize(
    "evidence",
    [
        seen(contact=1.4),
        seen(contact=0.6),
        seen(mouth=Shift(1.4, 0.0)),
        seen(mouth=Shift(1.0, 3.5)),
        seen(mouth=Shift(1.0, -3.5)),
        seen(mouth=Shift(1.2, 2.0)),
        # Either is enough: which of the two is wrong is not known.
        seen(contact=1.4, mouth=Shift(1.0, 0.0)),
        seen(contact=1.0, mouth=Shift(1.0, 5.0)),
    ],
)
def test_what_the_bounds_do_not_hold_for_is_told_and_not_used(evidence: Evidence) -> None:
    change = adaptation.update(AS_IDENTIFIED, evidence, GAP_MM, TRUSTED)
    assert (change.new, change.finding) == (AS_IDENTIFIED, Finding.OUT_OF_RANGE)
    assert not change.in_range


def test_a_contact_is_held_against_its_own_bounds_and_with_the_offset_in_use() -> None:
    """It says nothing of the offset, but what would be used must be in range as a whole."""
    alone = adaptation.update(AS_IDENTIFIED, seen(contact=1.15), GAP_MM, TRUSTED)
    assert alone.finding == Finding.LEARNED
    deeper = Shift(1.0, 2.0)
    change = adaptation.update(deeper, seen(contact=1.15), GAP_MM, TRUSTED)
    assert (change.new, change.finding) == (deeper, Finding.OUT_OF_RANGE)
    assert change.found == Shift(1.15, 2.0)
    # A barrier that saw the offset shrink goes before the one in use.
    both = adaptation.update(deeper, seen(1.15, Shift(1.14, 0.5)), GAP_MM, TRUSTED)
    assert both.finding == Finding.LEARNED


def test_nothing_seen_changes_nothing_and_is_no_alarm() -> None:
    change = adaptation.update(OLD, adaptation.NO_EVIDENCE, GAP_MM, TRUSTED)
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
    bounds = tip_bound.bound_tip(gain=0.967, offset_mm=-6.0, gap_mm=GAP_MM)
    half_mm = 0.5 * scale * GAP_MM / bounds.gain
    last = -200.0
    behind, interval = last + half_mm, tip_bound.assume_anywhere(bounds, last)
    for goal in [*ways, 120.0, -200.0]:
        for head in np.linspace(last, goal, 20):
            behind = min(max(behind, head - half_mm), head + half_mm)
            interval = tip_bound.follow(bounds, interval, float(head))
            tip_mm = bounds.gain * behind + bounds.offset_mm + offset_mm
            assert tip_mm <= tip_bound.deepest_mm(bounds, interval) + 1e-6
            assert tip_mm >= tip_bound.shallowest_mm(bounds, interval) - 1e-6
        last = goal
