"""Sections of the parameter file that only a calibration of the machine itself fills.

A recording of head and tip gives the modified Dahl model; the run on the machine adds the plays,
the curves of either direction, which machine it was and how a second run confirmed it. A
compensator drives the head by these numbers, so each is checked before it may.

A model that drives, as a section of a file: plays with a line over each, every number checked.

Preisach models, play readouts and Prandtl-Ishlinskii models all drive in this form
(`hysteresis.bank.play_lines`). A head goes by these numbers, so each is looked at before it may.

Check that an identified transmission can be that of the machine it is to drive.

The governor's interval of possible tip positions rests on the identified model, so a file of
another machine, or of a recording with another zero, would move every limit along with the error.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Annotated, NamedTuple, TypeVar

import numpy as np
from annotated_types import Ge, Gt

from opensuction.control.backlash_inverse import Curves
from opensuction.controller.calibration import Calibration
from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play_sum import PLAYS
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.kernel.errors import InputError
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
    table = play_lines.tabulate(lines)
    tips_mm = np.empty((2, 2))
    for row, head_mm in enumerate((0.5 * HALF_WAY_MM, 1.5 * HALF_WAY_MM)):
        for column, direction in enumerate((1.0, -1.0)):
            turns = play_lines.turns_after_travel(direction, head_mm)
            positions = play_lines.positions_mm(table, turns, head_mm)
            tips_mm[row, column] = play_lines.output_mm(
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


MOST_PLAYS = 64
"""[design] More than any model has that is identified, 41: a tick looks at each of them."""
MOST_CELLS = 64
"""[design] Likewise: 40 are the most that are identified."""


class Lines(NamedTuple):
    """`PlayLines` as lists."""

    widths_mm: list[float]
    lows_mm: list[float]
    cell_mm: Annotated[float, Gt(0)]
    gains: list[list[float]]
    """A list for each play."""
    decay_mm: Annotated[float, Gt(0)]
    lag: float
    offset_mm: float
    model: str = ""
    """The model of the catalogue that these are the lines of, for people."""


def write(lines: PlayLines, model: str = "") -> Lines:
    """The section of a model."""
    values = (np.asarray(value).tolist() for value in lines)
    return Lines(*values)._replace(model=model)


def read(section: Lines, name: str = "driven") -> PlayLines:
    """The model of a section. name: of the section, for messages.

    Raises InputError for lists of different length, too many or too few, numbers that are not
    finite or below 0 where they must not be, and a model that no head can be driven by.
    """
    plays = len(section.widths_mm)
    if not (plays == len(section.lows_mm) == len(section.gains) and 1 <= plays <= MOST_PLAYS):
        raise InputError(
            f"{name} has {plays} widths_mm, {len(section.lows_mm)} lows_mm and "
            f"{len(section.gains)} lists in gains, should have as many of one as of the others, "
            f"1 to {MOST_PLAYS}"
        )
    cells = {len(row) for row in section.gains}
    if len(cells) != 1 or not 1 <= min(cells) <= MOST_CELLS:
        raise InputError(
            f"{name}.gains has lists of {' and '.join(map(str, sorted(cells)))} numbers, should "
            f"have one number for each cell, the same for all plays, 1 to {MOST_CELLS}"
        )
    for key, values in _numbers(section).items():
        for value in values:
            if not math.isfinite(value):
                raise InputError(f"{name}.{key} holds {value}, should be a finite number")
    if min(section.widths_mm) < 0.0:
        raise InputError(
            f"{name}.widths_mm holds {min(section.widths_mm):g}, none should be below 0"
        )
    lines = PlayLines(
        widths_mm=np.array(section.widths_mm, dtype=np.float64),
        lows_mm=np.array(section.lows_mm, dtype=np.float64),
        cell_mm=section.cell_mm,
        gains=np.array(section.gains, dtype=np.float64),
        decay_mm=section.decay_mm,
        lag=section.lag,
        offset_mm=section.offset_mm,
    )
    reason = play_lines.why_not_driven(lines)
    if reason is not None:
        raise InputError(f"{name} cannot drive a head: {reason}; identify again instead")
    return lines


def _numbers(section: Lines) -> dict[str, list[float]]:
    """Every number by the key that it stands under."""
    return {
        "widths_mm": section.widths_mm,
        "lows_mm": section.lows_mm,
        "gains": [gain for row in section.gains for gain in row],
        "cell_mm": [section.cell_mm],
        "decay_mm": [section.decay_mm],
        "lag": [section.lag],
        "offset_mm": [section.offset_mm],
    }


Section = TypeVar("Section", bound=tuple[object, ...])

MOST_ENTRIES = 1000
"""Of a curve; the estimator makes 40."""


class CalibratedMachine(NamedTuple):
    """The machine that was calibrated."""

    name: str
    """Name of a preset or path of a machine file, as a person gave it."""
    preset: str
    catheter_mm: Annotated[float, Gt(0)]
    """Outer diameter of the catheter in it."""
    seed: Annotated[int, Ge(0)]
    """Which machine of the kind was drawn."""


class Validation(NamedTuple):
    """Errors of a second run, which nothing was fitted to; all root mean square."""

    model_rmse_mm: Annotated[float, Ge(0)]
    plays_rmse_mm: Annotated[float, Ge(0)]
    repeatability_mm: Annotated[float, Ge(0)]
    """Tip of the second run less tip of the first, at the same instants."""
    servo_rmse_v: Annotated[float, Ge(0)]
    """Voltage that the feedforward leaves unexplained in the first run."""


class Plays(NamedTuple):
    """`PrandtlIshlinskii` as lists."""

    thresholds_mm: list[float]
    weights: list[float]
    slope: Annotated[float, Ge(0)]
    offset_mm: float
    curvature_per_mm: float


class Branches(NamedTuple):
    """`Curves` as lists."""

    first_mm: float
    spacing_mm: Annotated[float, Gt(0)]
    inwards_mm: list[float]
    outwards_mm: list[float]


class Measured(NamedTuple):
    """Sections of a calibrated machine; a file has all of them or none."""

    machine: CalibratedMachine
    validation: Validation
    plays: Plays
    gap_width: Branches
    lookup_table: Branches


def write_section(section: Callable[..., Section], record: PrandtlIshlinskii | Curves) -> Section:
    """`Plays` or `Branches` of the record of the same fields."""
    return section(*(np.asarray(value).tolist() for value in record))


def read_plays(section: Plays, lowest_mm: float, highest_mm: float) -> PrandtlIshlinskii:
    """The model of a section. lowest_mm, highest_mm: tip positions that it must be invertible for.

    Raises InputError for lists of different length, thresholds that do not rise from above 0,
    negative weights, and a model without a continuous inverse.
    """
    thresholds, weights = section.thresholds_mm, section.weights
    if len(thresholds) != len(weights) or not 1 <= len(weights) <= PLAYS:
        raise InputError(
            f"plays has {len(thresholds)} thresholds_mm and {len(weights)} weights, should have "
            f"as many of one as of the other, 1 to {PLAYS}"
        )
    if not _rises([0.0, *thresholds]):
        raise InputError("plays.thresholds_mm should rise from each to the next, from above 0")
    if min(weights) < 0.0:
        raise InputError(f"plays.weights holds {min(weights):g}, none should be below 0")
    model = PrandtlIshlinskii(
        thresholds_mm=np.array(thresholds, dtype=np.float64),
        weights=np.array(weights, dtype=np.float64),
        slope=section.slope,
        offset_mm=section.offset_mm,
        curvature_per_mm=section.curvature_per_mm,
    )
    total = float(prandtl_ishlinskii.total_slope(model))
    if not 0.0 < total < np.inf:
        raise InputError(
            f"plays.slope and plays.weights come to {total:g} together, should be a number above 0"
        )
    if not prandtl_ishlinskii.is_well_posed(model, highest_mm, lowest_mm):
        raise InputError(
            f"plays.curvature_per_mm is {section.curvature_per_mm:g}, so that the gain would end "
            f"within the recorded depths, {lowest_mm:.1f} to {highest_mm:.1f} mm"
        )
    return model


def read_curves(section: Branches, name: str) -> Curves:
    """The curves of a section. name: of the section, for messages.

    Raises InputError for lists of different or impossible length, heads that do not rise with
    depth, and a way in that lies behind the way out.
    """
    inwards, outwards = section.inwards_mm, section.outwards_mm
    if len(inwards) != len(outwards) or not 2 <= len(inwards) <= MOST_ENTRIES:
        raise InputError(
            f"{name} has {len(inwards)} entries inwards_mm and {len(outwards)} outwards_mm, should "
            f"have as many of one as of the other, 2 to {MOST_ENTRIES}"
        )
    for key, heads in (("inwards_mm", inwards), ("outwards_mm", outwards)):
        if not _rises(heads):
            raise InputError(f"{name}.{key} should rise from each entry to the next")
    if any(inner < outer for inner, outer in zip(inwards, outwards, strict=True)):
        raise InputError(f"{name}.inwards_mm should nowhere be below {name}.outwards_mm")
    return Curves(
        first_mm=section.first_mm,
        spacing_mm=section.spacing_mm,
        inwards_mm=np.array(inwards, dtype=np.float64),
        outwards_mm=np.array(outwards, dtype=np.float64),
    )


def _rises(values: list[float]) -> bool:
    return all(later > earlier for earlier, later in pairwise(values))
