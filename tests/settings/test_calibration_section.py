"""Measured sections: written, read back, and refused in every way they can be wrong."""

from pathlib import Path

import numpy as np
import pytest

from opensuction.controller.calibration import Feedforward
from opensuction.settings import calibration_section, identification_file
from opensuction.settings.calibration_section import (
    Branches,
    CalibratedMachine,
    Measured,
    Plays,
    Validation,
)
from opensuction.settings.identification_file import ON_MEASURED, Identified
from tests.settings.test_identification_file import identified, refusal, written

MEASURED = Measured(
    machine=CalibratedMachine(name="bench", preset="bench", catheter_mm=4.0, seed=3),
    validation=Validation(0.83, 0.09, 0.11, 0.1),
    plays=Plays([6.0, 9.0, 12.5], [0.25, 0.5, 0.125], 0.0, -6.5, 1e-4),
    gap_width=Branches(2.0, 80.0, [20.5, 104.5], [1.5, 85.5]),
    lookup_table=Branches(2.0, 40.0, [20.0, 63.0, 105.0], [1.0, 43.0, 86.0]),
)


def calibrated(compensator: str = "preview") -> Identified:
    return identified(compensator=compensator)._replace(
        servo=Feedforward(1.27, 0.54), measured=MEASURED
    )


@pytest.mark.parametrize("compensator", ON_MEASURED)
def test_every_compensator_gets_its_model_back_to_the_last_bit(
    tmp_path: Path, compensator: str
) -> None:
    path = written(tmp_path, calibrated(compensator))
    assert identification_file.load(path) == calibrated(compensator)
    found = identification_file.to_calibration(identification_file.load(path), path)
    assert calibration_section.write_section(Plays, found.plays) == MEASURED.plays
    assert calibration_section.write_section(Branches, found.width) == MEASURED.gap_width
    assert calibration_section.write_section(Branches, found.table) == MEASURED.lookup_table
    assert found.feedforward == Feedforward(1.27, 0.54)
    assert found.plays.weights.dtype == np.float64


def test_a_file_of_version_1_is_still_read(tmp_path: Path) -> None:
    path = written(tmp_path, identified())
    assert "format_version = 1\n" in path.read_text()
    found = identification_file.to_calibration(identification_file.load(path), path)
    assert found.plays.thresholds_mm.size == 1  # the model's plain backlash


def test_plays_need_a_file_that_has_them(tmp_path: Path) -> None:
    assert "compensator for modified-dahl" in refusal(tmp_path, identified(compensator="preview"))


WRONG_PLAYS = [
    (MEASURED.plays._replace(weights=[0.5, 0.5]), "3 thresholds_mm and 2 weights"),
    (MEASURED.plays._replace(weights=[], thresholds_mm=[]), "0 thresholds_mm"),
    (
        MEASURED.plays._replace(weights=[0.05] * 17, thresholds_mm=[*range(1, 18)]),
        "17 thresholds_mm and 17 weights, should have as many of one as of the other, 1 to 16",
    ),
    (MEASURED.plays._replace(thresholds_mm=[6.0, 6.0, 12.5]), "should rise"),
    (MEASURED.plays._replace(thresholds_mm=[-1.0, 6.0, 12.5]), "from above 0"),
    (MEASURED.plays._replace(weights=[0.5, -0.1, 0.5]), "none should be below 0"),
    (MEASURED.plays._replace(weights=[0.0, 0.0, 0.0]), "come to 0 together"),
    (MEASURED.plays._replace(weights=[1e308, 1e308, 1e308]), "come to inf together"),
    (MEASURED.plays._replace(slope=-0.1), "plays.slope"),
    (MEASURED.plays._replace(offset_mm=float("nan")), "plays.offset_mm"),
    (MEASURED.plays._replace(thresholds_mm=[6.0, float("inf"), 12.5]), "thresholds_mm"),
    (MEASURED.plays._replace(curvature_per_mm=-0.01), "gain would end"),
]


@pytest.mark.parametrize(("plays", "words"), WRONG_PLAYS, ids=[words for _, words in WRONG_PLAYS])
def test_plays_that_cannot_be_are_refused(tmp_path: Path, plays: Plays, words: str) -> None:
    content = calibrated()._replace(measured=MEASURED._replace(plays=plays))
    assert words in refusal(tmp_path, content)


WRONG_CURVES = [
    (MEASURED.lookup_table._replace(inwards_mm=[20.0, 63.0]), "2 entries inwards_mm and 3"),
    (MEASURED.lookup_table._replace(inwards_mm=[20.0, 110.0, 105.0]), "should rise"),
    (MEASURED.lookup_table._replace(outwards_mm=[1.0, 43.0, 106.0]), "nowhere be below"),
    (MEASURED.lookup_table._replace(spacing_mm=0.0), "spacing_mm"),
]


@pytest.mark.parametrize(("table", "words"), WRONG_CURVES, ids=[words for _, words in WRONG_CURVES])
def test_curves_that_cannot_be_are_refused(tmp_path: Path, table: Branches, words: str) -> None:
    content = calibrated()._replace(measured=MEASURED._replace(lookup_table=table))
    assert words in refusal(tmp_path, content)


def test_half_of_the_sections_is_not_enough(tmp_path: Path) -> None:
    text = identification_file.to_toml(calibrated()).replace("[gap_width]", "[gap_depth]", 1)
    assert "unknown key gap_depth" in refusal(tmp_path, text)
    start = identification_file.to_toml(calibrated()).index("[lookup_table]")
    assert "lookup_table is missing" in refusal(
        tmp_path, identification_file.to_toml(calibrated())[:start]
    )
