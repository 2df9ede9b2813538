"""A row of the control loop, read by the names of its columns."""

import math

from opensuction.kernel.record import Array
from opensuction.runtime.loop import ROW_COLUMNS

PLACES = {name: place for place, name in enumerate(ROW_COLUMNS)}


class Row:
    """One tick."""

    def __init__(self, values: Array) -> None:
        """values: by `ROW_COLUMNS`."""
        self._values = values

    def number(self, name: str) -> float:
        """A column as it is; may be no number."""
        return float(self._values[PLACES[name]])

    def whole(self, name: str) -> int:
        """A column that holds a whole number; 0 where it holds none."""
        value = self.number(name)
        return int(value) if math.isfinite(value) else 0

    def flag(self, name: str) -> bool:
        """A column that holds yes or no."""
        return self.number(name) == 1.0

    def reading(self, name: str) -> float | None:
        """A number that a page can show; None for one that is none."""
        return plain(self.number(name))

    def valid(self, name: str, flag: str) -> float | None:
        """A reading with its flag; None where the flag says that it is none."""
        return self.reading(name) if self.flag(flag) else None


def plain(value: float, digits: int = 4) -> float | None:
    """A number as JSON has it; None for one that is none."""
    return round(value, digits) if math.isfinite(value) else None
