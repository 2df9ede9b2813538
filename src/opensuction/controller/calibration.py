"""Calibration of a machine: the result of an identification run, or nominal values alone.

A calibration carried over to a transmission that has changed: each model in its own way.

What changes is the width of the gap, by a factor, and where the tip lies, by an offset. The gain
stays as identified: see docs/decisions/0036.
"""

from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge
from numpy.typing import ArrayLike

from opensuction.control.backlash_inverse import Curves
from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.estimator import adaptation, gap_measurement
from opensuction.identification.estimator.adaptation import AdaptationChange, Evidence
from opensuction.identification.estimator.gap_measurement import UNKNOWN, Missed, Shift, scale_dahl


class Feedforward(NamedTuple):
    """Servo feedforward of the insertion axis, found by calibration; zeros for the paper's PD."""

    velocity_v_s_per_mm: Annotated[float, Ge(0)]
    friction_v: Annotated[float, Ge(0)]


PLAIN_PD = Feedforward(velocity_v_s_per_mm=0.0, friction_v=0.0)


class Calibration(NamedTuple):
    """Result of an identification run; each compensator uses its part of it."""

    model: ModifiedDahl
    feedforward: Feedforward
    plays: PrandtlIshlinskii
    width: Curves
    """One backlash width: two parallel lines."""
    table: Curves
    lines: PlayLines
    """A model of plays with lines over them, which `model-preview` is on."""


def assume_nominal(model: ModifiedDahl, feedforward: Feedforward) -> Calibration:
    """A calibration from the modified Dahl model alone: every other model is its plain backlash."""
    half_mm = 0.5 * float(modified_dahl.gap_mm(model)) / model.slope
    middle_mm = -model.offset_mm / model.slope
    plays = PrandtlIshlinskii(
        thresholds_mm=np.array([half_mm]),
        weights=np.array([model.slope]),
        slope=0.0,
        offset_mm=model.offset_mm,
        curvature_per_mm=0.0,
    )
    tip_mm = np.array([0.0, 1.0])
    heads_mm = middle_mm + tip_mm / model.slope
    width = Curves(0.0, 1.0, heads_mm + half_mm, heads_mm - half_mm)
    lines = play_lines.of_prandtl_ishlinskii(plays)
    return Calibration(model, feedforward, plays, width, width, lines)


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
    tip_mm = gap_measurement.lines_tip_mm(lines) if by_lines else gap_measurement.play_tip_mm(plays)
    found = gap_measurement.read(tip_mm, mouth_clear, head_mm, mouth_mm, period_s)
    if isinstance(found, Missed):
        return Evidence(float("nan"), UNKNOWN, found)
    return Evidence(float("nan"), found, Missed.NOTHING)


def learn(identified: Calibration, before: AdaptationChange, seen: Evidence) -> AdaptationChange:
    """Adapt the transmission by the evidence of a cycle; see `adaptation.update`."""
    return adaptation.update(before, seen, prandtl_ishlinskii.gap_mm(identified.plays))
