"""The drawing for the bedside: of the same parts as a report's, at the depths asked for."""

import re
from xml.etree import ElementTree

import pytest

from opensuction.console.route import machine
from opensuction.report import airway_geometry as geometry
from opensuction.report import airway_geometry as report_anatomy
from opensuction.report import sheet
from tests.report import example

DEPTHS = {"target_mm": 90.0, "cap_mm": 95.0, "carina_mm": 100.0, "boundary_mm": -80.0}


def test_it_is_drawn_as_in_a_report() -> None:
    drawing = report_anatomy.drawing(example.summary())
    assert drawing is not None
    told = sheet.render_part("anatomy.svg.j2", drawing=drawing)
    for part in ("airway", "ring", "tube-wall", "tube-lumen"):
        found = re.findall(rf'<path class="{part}" d="[^"]*"', told)
        assert found, part
        ours = machine.draw(
            target_mm=90.0, cap_mm=95.0, carina_mm=100.0, boundary_mm=None, by_contact=False
        )
        assert re.findall(rf'<path class="{part}" d="[^"]*"', ours) == found, part


@pytest.mark.parametrize("by_contact", [False, True])
def test_depths_are_named_and_to_scale(by_contact: bool) -> None:
    drawn = machine.draw(**DEPTHS, by_contact=by_contact)
    root = ElementTree.fromstring(drawn)
    assert root.get("data-px-per-mm") == str(geometry.PX_PER_MM)
    assert root.get("data-boundary-mm") == "-80.0"
    assert ("Search ends 95.0 mm" in drawn) is by_contact
    assert ("Cap 95.0 mm" in drawn) is not by_contact
    assert f"M 96,{geometry.y_px(90.0)} H" in drawn
    parts = {one.get("data-part") for one in root.iter()} - {None}
    assert parts == {
        *("range", "bend", "straight", "contact", "tip", "arrow"),
        *("flow", "secretions", "head", "pushed", "conduit"),
    }


def test_what_is_not_known_is_not_drawn() -> None:
    drawn = machine.draw(None, None, None, None, by_contact=False)
    assert "Carina" not in drawn
    assert "Target" not in drawn
    assert 'data-boundary-mm=""' in drawn


def test_no_style_or_script_is_inline() -> None:
    drawn = machine.draw(**DEPTHS, by_contact=False)
    assert "style=" not in drawn
    assert "<script" not in drawn
