"""One instant of a running cycle, as whoever plays it tells whoever shows it."""

from typing import NamedTuple


class Moment(NamedTuple):
    """Values that a live display shows of an instant."""

    phase: str
    """Name as in summaries: lower case, ``backing_off``."""
    time_s: float
    tip_mm: float
    valve_open_ratio: float
    line_vacuum_mmhg: float
