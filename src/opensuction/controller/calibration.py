"""Calibration of a machine: the result of an identification run, or nominal values alone."""

from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge

from opensuction.control.lookup_table import Curves
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.bank import play_lines
from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii


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
