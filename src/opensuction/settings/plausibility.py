"""Check that an identified transmission can be that of the machine it is to drive.

The governor's interval of possible tip positions rests on the identified model, so a file of
another machine, or of a recording with another zero, would move every limit along with the error.
"""

from typing import NamedTuple

import numpy as np

from opensuction.control.lookup_table import Curves
from opensuction.controller.calibration import Calibration
from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.bank import play_table
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.settings.wording import refuse

GAP_RATIOS = (0.5, 1.5)
"""Gap over the machine's nominal one. Re-routing the conduit changes it by 30 % [design-gap],
another catheter in it by as much again (assumed)."""

SLOPES = (0.85, 1.1)
"""mm of tip for each mm of head: the catheter neither shortens nor grows by more (assumed)."""

MOST_SHIFT_MM = 10.0
"""Tip between both ways, half way in, off the nominal one; a larger shift is another zero
(assumed)."""

HALF_WAY_MM = 50.0
"""Head position at which the shift is taken: half of the paper's excitation."""


class _Shape(NamedTuple):
    """Shape that all models of a transmission have in common."""

    gap_mm: float
    """Distance between both ways, mm of tip."""
    slope: float
    middle_mm: float
    """Tip between the way in and the way out, half way in."""


def check(found: Calibration, nominal: ModifiedDahl, where: object) -> None:
    """Refuse a calibration one of whose models cannot be this machine's; raises InputError.

    nominal: the machine's transmission as it was built. where: names the source in messages.
    """
    built = _of_model(nominal)
    shapes = (
        ("the gap 2 velocity_gain/decay", "parameters.slope", _of_model(found.model)),
        ("the gap of the plays", "the slope of the plays", _of_plays(found.plays)),
        ("the gap of gap_width", "the slope of gap_width", _of_curves(found.width)),
        ("the gap of lookup_table", "the slope of lookup_table", _of_curves(found.table)),
        ("the gap of driven", "the slope of driven", _of_lines(found.lines)),
    )
    for gap_name, slope_name, shape in shapes:
        problem = _problem(shape, built, gap_name, slope_name)
        if problem:
            raise refuse(where, f"{problem} for this machine; identify the machine itself")


def _problem(shape: _Shape, built: _Shape, gap_name: str, slope_name: str) -> str:
    least_mm, most_mm = (bound * built.gap_mm for bound in GAP_RATIOS)
    if not least_mm <= shape.gap_mm <= most_mm:
        return (
            f"{gap_name} is {shape.gap_mm:.1f} mm, should be from {least_mm:.1f} to "
            f"{most_mm:.1f} mm"
        )
    if not SLOPES[0] <= shape.slope <= SLOPES[1]:
        return f"{slope_name} is {shape.slope:.4g}, should be from {SLOPES[0]} to {SLOPES[1]}"
    if not abs(shape.middle_mm - built.middle_mm) <= MOST_SHIFT_MM:
        return (
            f"with the head at {HALF_WAY_MM:g} mm the tip would be at {shape.middle_mm:.1f} mm, "
            f"should be within {MOST_SHIFT_MM:g} mm of {built.middle_mm:.1f} mm (the zero of "
            "the recording may be another)"
        )
    return ""


def _of_model(model: ModifiedDahl) -> _Shape:
    middle_mm = model.slope * HALF_WAY_MM + model.offset_mm
    return _Shape(float(modified_dahl.gap_mm(model)), model.slope, middle_mm)


def _of_plays(model: PrandtlIshlinskii) -> _Shape:
    slope = float(prandtl_ishlinskii.total_slope(model))
    inner_mm = slope * HALF_WAY_MM
    bent = 1.0 + model.curvature_per_mm * inner_mm
    return _Shape(prandtl_ishlinskii.gap_mm(model), slope, model.offset_mm + inner_mm * bent)


def _of_lines(lines: PlayLines) -> _Shape:
    """Of the tips half way in, and a quarter of the way before and behind, after long ways."""
    table = play_table.tabulate(lines)
    tips_mm = np.empty((2, 2))
    for row, head_mm in enumerate((0.5 * HALF_WAY_MM, 1.5 * HALF_WAY_MM)):
        for column, direction in enumerate((1.0, -1.0)):
            turns = play_table.turns_after_travel(direction, head_mm)
            positions = play_table.positions_mm(table, turns, head_mm)
            tips_mm[row, column] = play_table.output_mm(
                table, positions, -direction * lines.decay_mm
            )
    inwards_mm, outwards_mm = tips_mm.mean(axis=0).tolist()
    slope = float(np.diff(tips_mm.mean(axis=1))[0]) / HALF_WAY_MM
    return _Shape(outwards_mm - inwards_mm, slope, 0.5 * (inwards_mm + outwards_mm))


def _of_curves(curves: Curves) -> _Shape:
    """Of the straight line through the middle of both curves."""
    tip_mm = curves.first_mm + curves.spacing_mm * np.arange(curves.inwards_mm.size)
    heads_mm = 0.5 * (curves.inwards_mm + curves.outwards_mm)
    slope, offset_mm = np.polyfit(heads_mm, tip_mm, 1)
    width_mm = float(np.mean(curves.inwards_mm - curves.outwards_mm))
    return _Shape(slope * width_mm, float(slope), float(slope * HALF_WAY_MM + offset_mm))
