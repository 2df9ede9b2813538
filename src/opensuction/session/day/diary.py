"""The patient over a day: secretions, saturation and volume lost, sampled as time passes."""

import numpy as np

from opensuction.simulation.closed_loop import DT_S, LoopState
from opensuction.simulation.trace import Columns
from opensuction.twin import bedside

Sample = tuple[float, float, float, float]
"""One row of `DaySamples`."""


def sum_secretion_ml(state: LoopState) -> float:
    """Secretions in the airway, in mL; those that suction cannot reach are among them."""
    return bedside.sum_secretion_ml(state.bedside)


def look_at(state: LoopState) -> Sample:
    """The patient as it is now."""
    signs = state.machine.coupling.signs
    seen = signs.spo2_percent, signs.lung_volume_loss_ml
    return state.tick * DT_S, sum_secretion_ml(state), *seen


def look_back(state: LoopState, columns: Columns) -> list[Sample]:
    """The patient during a cycle, once a second, and as it is after it."""
    removed = columns["truth.secretion_removed_ml"]
    after_ml = sum_secretion_ml(state)
    seen = (
        columns["time_s"],
        after_ml + (removed[-1] - removed),
        columns["truth.spo2_percent"],
        columns["truth.lung_volume_loss_ml"],
    )
    every = np.column_stack([values[:: round(1.0 / DT_S)] for values in seen])
    return [*map(tuple, every.tolist()), look_at(state)]
