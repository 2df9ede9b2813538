"""For how many ticks each sensor has given no valid reading."""

from typing import NamedTuple

from opensuction.kernel.arithmetic import count_ticks
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings, is_number

INVALID_TICKS = 5
"""Consecutive ticks without a valid reading that are a fault; fewer are ridden out."""
NEVER_TICKS = 1_000_000
"""Of a sensor that was never read: longer than any dropout, so where it is found is no leap."""


class InvalidTicks(NamedTuple):
    """Consecutive ticks without a valid reading."""

    head: int
    carriage: int
    cam: int
    vacuum: int
    contact: int


NONE = InvalidTicks(head=0, carriage=0, cam=0, vacuum=0, contact=0)
"""All readings are valid."""


@compiled
def step(state: InvalidTicks, readings: Readings) -> InvalidTicks:
    """Bring the counts up to this tick."""
    head = readings.head_valid and is_number(readings.head_mm)
    carriage = readings.carriage_valid and is_number(readings.carriage_mm)
    cam = readings.cam_valid and is_number(readings.cam_rad)
    vacuum = readings.vacuum_valid and is_number(readings.line_vacuum_mmhg)
    return InvalidTicks(
        head=count_ticks(state.head, not head),
        carriage=count_ticks(state.carriage, not carriage),
        cam=count_ticks(state.cam, not cam),
        vacuum=count_ticks(state.vacuum, not vacuum),
        contact=count_ticks(state.contact, not readings.contact_valid),
    )
