"""Columns of a run that a test looks at, out of the rows that were played.

To make columns of all rows takes four times as long as to play them; few are looked at.
"""

from collections.abc import ItemsView

import numpy as np
from numpy.typing import NDArray

from opensuction.simulation.closed_loop import COLUMNS

Column = NDArray[np.float64]


class ColumnsOfRows(dict[str, Column]):
    """Columns of a table by name, each copied when it is first asked for, by name or with all."""

    def __init__(self, table: NDArray[np.float64]) -> None:
        super().__init__()
        self._table = table

    def __missing__(self, name: str) -> Column:
        column = self[name] = self._table[:, COLUMNS.index(name)].copy()
        return column

    def __bool__(self) -> bool:
        return True

    def items(self) -> ItemsView[str, Column]:  # type: ignore[override]
        for name in COLUMNS:
            self[name]
        return ItemsView(self)
