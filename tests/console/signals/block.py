"""Rows of a machine that a test says."""

import numpy as np

from opensuction.console.signals.channel import Block
from opensuction.kernel.record import Array
from opensuction.runtime.loop import ROW_COLUMNS

PERIOD_S = 0.001


def rows_of(count: int, first_tick: int = 100, **columns: float | Array) -> Array:
    """Rows a millisecond apart. columns: by their last words."""
    rows = np.zeros((count, len(ROW_COLUMNS)))
    rows[:, ROW_COLUMNS.index("inputs.tick")] = first_tick + np.arange(count)
    rows[:, ROW_COLUMNS.index("loop.time_s")] = 5000.0 + PERIOD_S * np.arange(count)
    for name, values in columns.items():
        rows[:, find(name)] = values
    return rows


def find(name: str) -> int:
    """Place of a column by the end of its name."""
    return next(i for i, full in enumerate(ROW_COLUMNS) if full.endswith(f".{name}"))


def block_of(rows: Array, missed: int = 0, source: int = 1) -> Block:
    return Block(source, rows, missed, PERIOD_S, gain=0.5, offset_mm=-3.0)
