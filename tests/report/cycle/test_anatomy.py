import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.report.cycle import anatomy
from tests.report import example


def test_depths_are_to_scale() -> None:
    drawn = anatomy.drawing(example.summary())
    assert drawn is not None
    y_px = {mark.kind: mark.y_px for mark in drawn.marks}
    deepest_px = y_px["deepest"] - y_px["tube"]
    # Positions are rounded to 0.1 px.
    assert deepest_px / (y_px["carina"] - y_px["tube"]) == pytest.approx(0.907, abs=0.001)
    assert drawn.catheter_px == y_px["deepest"]


@given(st.lists(st.floats(0, 500), min_size=1, max_size=8).map(sorted))
def test_labels_keep_their_order_and_do_not_overlap(wanted_px: list[float]) -> None:
    placed = anatomy.spread(wanted_px, 20.0)
    assert len(placed) == len(wanted_px)
    assert np.all(np.diff(placed) >= 20.0 - 1e-9)


def test_labels_with_room_stay_where_they_belong() -> None:
    assert anatomy.spread([0.0, 50.0, 100.0], 20.0) == [0.0, 50.0, 100.0]


def test_description_says_what_is_drawn() -> None:
    drawn = anatomy.drawing(example.summary())
    assert drawn is not None
    for depth in ("target at 90.0 mm", "deepest tip at 90.7 mm", "cap at 95.0 mm"):
        assert depth in drawn.description


def test_unknown_anatomy_is_not_drawn_as_if_it_were_known() -> None:
    drawn = anatomy.drawing(example.summary(anatomy=None))
    assert drawn is not None
    assert drawn.carina_px is None
    assert {mark.kind for mark in drawn.marks} == {"tube", "target", "deepest"}
    assert anatomy.drawing(example.summary(tip=None)) is None


def test_tube_of_a_patient_says_where_it_begins() -> None:
    drawn = anatomy.drawing(example.on_patient())
    assert drawn is not None
    assert drawn.upper_end == "-80 mm"
    bench = anatomy.drawing(example.summary())
    assert bench is not None
    assert bench.upper_end == ""


def test_tip_that_stayed_out_of_the_drawing_is_not_drawn() -> None:
    tip = example.on_patient()["tip"] | {"deepest_mm": -99.0}
    drawn = anatomy.drawing(example.on_patient(tip=tip))
    assert drawn is not None
    assert drawn.catheter_px is None
    assert "deepest" not in {mark.kind for mark in drawn.marks}
    assert "-99.0 mm" in drawn.description
