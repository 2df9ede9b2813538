import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.report import airway_geometry
from opensuction.report import airway_geometry as geometry
from tests.report import example


def test_depths_are_to_scale() -> None:
    drawn = airway_geometry.drawing(example.summary())
    assert drawn is not None
    y_px = {mark.kind: mark.y_px for mark in drawn.marks}
    deepest_px = y_px["deepest"] - y_px["tube"]
    # Positions are rounded to 0.1 px.
    assert deepest_px / (y_px["carina"] - y_px["tube"]) == pytest.approx(0.907, abs=0.001)
    assert drawn.deepest_px == y_px["deepest"]
    assert drawn.now_px == y_px["now"]


@given(st.lists(st.floats(0, 500), min_size=1, max_size=8).map(sorted))
def test_labels_keep_their_order_and_do_not_overlap(wanted_px: list[float]) -> None:
    placed = geometry.spread(wanted_px, 20.0)
    assert len(placed) == len(wanted_px)
    assert np.all(np.diff(placed) >= 20.0 - 1e-9)


def test_labels_with_room_stay_where_they_belong() -> None:
    assert geometry.spread([0.0, 50.0, 100.0], 20.0) == [0.0, 50.0, 100.0]


def test_description_says_what_is_drawn() -> None:
    drawn = airway_geometry.drawing(example.summary())
    assert drawn is not None
    for depth in ("target at 90.0 mm", "deepest tip at 90.7 mm", "cap at 95.0 mm"):
        assert depth in drawn.description


def test_unknown_anatomy_is_not_drawn_as_if_it_were_known() -> None:
    drawn = airway_geometry.drawing(example.summary(anatomy=None))
    assert drawn is not None
    assert drawn.carina_px is None
    assert {mark.kind for mark in drawn.marks} == {"tube", "target", "now", "deepest"}
    assert airway_geometry.drawing(example.summary(tip=None)) is None


def test_tube_of_a_patient_says_where_it_begins() -> None:
    drawn = airway_geometry.drawing(example.on_patient())
    assert drawn is not None
    assert drawn.upper_end == "-80 mm"
    bench = airway_geometry.drawing(example.summary())
    assert bench is not None
    assert bench.upper_end == ""


def test_tip_that_stayed_out_of_the_drawing_is_not_drawn() -> None:
    tip = example.ON_PATIENT["tip"] | {"deepest_mm": -99.0}
    drawn = airway_geometry.drawing(example.on_patient(tip=tip))
    assert drawn is not None
    assert drawn.deepest_px is None
    assert "deepest" not in {mark.kind for mark in drawn.marks}
    assert "-99.0 mm" in drawn.description


def _with_tip(end_mm: float, *, inside: bool) -> airway_geometry.Drawing:
    tip = example.ON_PATIENT["tip"] | {"end_mm": end_mm, "inside_at_end": inside}
    drawn = airway_geometry.drawing(example.on_patient(tip=tip))
    assert drawn is not None
    return drawn


def test_the_catheter_is_drawn_where_it_is_now() -> None:
    left = _with_tip(48.6, inside=True)
    assert left.now_px == geometry.y_px(48.6)
    assert left.deepest_px == geometry.y_px(100.7)
    assert left.bend_share == 1.0
    assert "still inside, its tip 48.6 mm below the tube's end" in left.caption
    in_the_tube = _with_tip(-48.0, inside=True)
    assert in_the_tube.now_px is None
    assert in_the_tube.bend_share == pytest.approx(0.5)
    parked = _with_tip(-100.0, inside=False)
    assert (parked.now_px, parked.bend_share) == (None, 0.0)
    assert "out at the end" in parked.caption


def test_a_tip_that_is_still_at_its_deepest_is_drawn_once() -> None:
    drawn = _with_tip(100.6, inside=True)
    assert drawn.deepest_px is None
    assert "deepest" not in {mark.kind for mark in drawn.marks}


def test_a_cap_beyond_the_carina_is_where_the_search_ends() -> None:
    by_contact = airway_geometry.drawing(example.on_patient())
    assert by_contact is not None
    assert "Search ends 113.0 mm" in {mark.text for mark in by_contact.marks}
    assert "Cap" not in {mark.name for mark in by_contact.marks}
    by_travel = airway_geometry.drawing(example.summary())
    assert by_travel is not None
    assert "Cap 95.0 mm" in {mark.text for mark in by_travel.marks}
