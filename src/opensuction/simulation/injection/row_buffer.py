"""Memory for the rows of a run with faults: written a piece at a time, kept as columns."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from opensuction.simulation import trace
from opensuction.simulation.closed_loop import COLUMNS, DT_S
from opensuction.simulation.trace import Columns

PIECE_ROWS = 20_000
"""Simulated at once, at most: 14 MB, used again and again. To hand a state to compiled code and
take it back costs as much as hundreds of ticks."""


class RowBuffer:
    """Room for the rows of one run after the other.

    longest_s: the longest run. names: columns that are kept, the phase among them.
    """

    def __init__(self, longest_s: float, names: Sequence[str] = COLUMNS) -> None:
        self.names = tuple(names)
        self._piece = np.zeros((PIECE_ROWS, len(COLUMNS)))
        self._columns = np.empty((len(self.names), round(longest_s / DT_S)))
        self._index = trace.indices(self.names)
        self._sent: npt.NDArray[np.float64] | None = None

    @property
    def ticks(self) -> int:
        """Of the longest run."""
        return self._columns.shape[1]

    def piece(self, most: int) -> npt.NDArray[np.float64]:
        """Rows for the next ticks, ``most`` of them or fewer: to be written, then to be kept."""
        return self._piece[:most]

    def keep(self, done: int, ticks: int) -> None:
        """Keep so many rows of the piece that follow the ``done`` ones."""
        trace.transpose(self._piece[:ticks], self._index, self._columns[:, done : done + ticks])

    def sent(self, columns: int) -> npt.NDArray[np.float64]:
        """Room for what a controller sends in the longest run, shape (ticks, columns).

        It holds what the last run has left there.
        """
        if self._sent is None:
            self._sent = np.empty((self.ticks, columns))
        return self._sent

    def copy(self, done: int) -> npt.NDArray[np.float64]:
        """The first ``done`` rows, shape (columns, done), for `fill`."""
        return self._columns[:, :done].copy()

    def fill(self, kept: npt.NDArray[np.float64], done: int) -> None:
        """Take over the first ``done`` rows of what a run of the same columns has left."""
        self._columns[:, :done] = kept[:, :done]

    def columns(self, done: int) -> Columns:
        """The first ``done`` rows, by name; they are of this room, and the next run's after it."""
        return dict(zip(self.names, self._columns[:, :done], strict=True))
