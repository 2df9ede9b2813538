"""A calibration carried over to a transmission that has changed: each model in its own way.

What changes is the width of the gap, by a factor, and where the tip lies, by an offset. The gain
stays as identified: see docs/decisions/0036.
"""

from numpy.typing import ArrayLike

from opensuction.control.lookup_table import Curves
from opensuction.controller.calibration import Calibration
from opensuction.hysteresis import prandtl_ishlinskii
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.estimator import adaptation, mouth_passage
from opensuction.identification.estimator.adaptation import AdaptationChange, Evidence
from opensuction.identification.estimator.mouth_passage import (
    UNKNOWN,
    Missed,
    Shift,
    scale_dahl,
)


def adapt_plays(model: PrandtlIshlinskii, shift: Shift) -> PrandtlIshlinskii:
    """Plays as wide as the shift says, the tip as deep."""
    scaled = prandtl_ishlinskii.scale_widths(model, shift.scale)
    return scaled._replace(offset_mm=model.offset_mm + shift.offset_mm)


def adapt_dahl(model: ModifiedDahl, shift: Shift) -> ModifiedDahl:
    """The same lag over a gap as wide as the shift says, the tip as deep."""
    return scale_dahl(model, shift.scale)._replace(offset_mm=model.offset_mm + shift.offset_mm)


def adapt_lines(lines: PlayLines, shift: Shift) -> PlayLines:
    """The same lines over plays as wide as the shift says, the tip as deep."""
    return lines._replace(
        widths_mm=shift.scale * lines.widths_mm, offset_mm=lines.offset_mm + shift.offset_mm
    )


def adapt_curves(curves: Curves, shift: Shift) -> Curves:
    """Both branches, as far from their middle as the shift says, over depths that lie deeper."""
    middle_mm = 0.5 * (curves.inwards_mm + curves.outwards_mm)
    half_mm = 0.5 * shift.scale * (curves.inwards_mm - curves.outwards_mm)
    return Curves(
        first_mm=curves.first_mm + shift.offset_mm,
        spacing_mm=curves.spacing_mm,
        inwards_mm=middle_mm + half_mm,
        outwards_mm=middle_mm - half_mm,
    )


def adapted(identified: Calibration, shift: Shift) -> Calibration:
    """The calibration for a transmission that differs from the identified one by a shift.

    Servo feedforward and gain stay as they were identified.
    """
    return identified._replace(
        model=adapt_dahl(identified.model, shift),
        plays=adapt_plays(identified.plays, shift),
        width=adapt_curves(identified.width, shift),
        table=adapt_curves(identified.table, shift),
        lines=adapt_lines(identified.lines, shift),
    )


def passed(
    identified: Calibration,
    mouth_clear: ArrayLike,
    head_mm: ArrayLike,
    mouth_mm: float,
    period_s: float,
    by_lines: bool = False,
) -> Evidence:
    """Evidence from the passages of a barrier in one cycle, by the identified plays.

    mouth_clear: 0 or 1, shape (n,), no tip in the beam. head_mm: shape (n,), from rest after a
    retract until the tip is out again. mouth_mm: depth of the barrier, infinite where there is
    none. period_s: of the samples. by_lines: by the plays with lines over them, which
    `model-preview` goes by. Raises InputError for records that are not finite rows of equal
    length.
    """
    plays, lines = identified.plays, identified.lines
    tip_mm = mouth_passage.lines_tip_mm(lines) if by_lines else mouth_passage.play_tip_mm(plays)
    found = mouth_passage.read(tip_mm, mouth_clear, head_mm, mouth_mm, period_s)
    if isinstance(found, Missed):
        return Evidence(float("nan"), UNKNOWN, found)
    return Evidence(float("nan"), found, Missed.NOTHING)


def learn(identified: Calibration, before: AdaptationChange, seen: Evidence) -> AdaptationChange:
    """Adapt the transmission by the evidence of a cycle; see `adaptation.update`."""
    return adaptation.update(before, seen, prandtl_ishlinskii.gap_mm(identified.plays))
