"""Items of the pre-use test: their order, their words, and the longest time for each."""

from enum import IntEnum
from typing import NamedTuple


class CheckItem(IntEnum):
    """What is tested. The numbers are stored in recordings: never renumber."""

    NONE = 0
    """Nothing is being tested, or nothing failed."""
    READINGS = 1
    CONTACT_OPEN = 2
    HEAD_HOME = 3
    HEAD_ADVANCES = 4
    HEAD_RETURNS = 5
    LINE_VENTED = 6
    VALVE_OPENS = 7
    VALVE_CLOSES = 8
    VACUUM_BUILDS = 9
    VACUUM_HOLDS = 10
    RELIEF_OPENS = 11
    REGULATOR_HOLDS = 12


I = CheckItem  # noqa: E741 - short, for the tables below

ORDER = (
    I.READINGS,
    I.CONTACT_OPEN,
    I.HEAD_HOME,
    I.HEAD_ADVANCES,
    I.HEAD_RETURNS,
    I.LINE_VENTED,
    I.VALVE_OPENS,
    I.VALVE_CLOSES,
    I.VACUUM_BUILDS,
    I.RELIEF_OPENS,
    I.REGULATOR_HOLDS,
    I.VACUUM_HOLDS,
)
"""Sensors first, for the rest is judged by them; the valve strokes before there is vacuum. What the
regulator has lowered, the line must hold."""

SENTENCES: dict[CheckItem, str] = {
    I.NONE: "nothing failed",
    I.READINGS: "a sensor gives no valid reading",
    I.CONTACT_OPEN: "the contact switch is closed although nothing touches the tip",
    I.HEAD_HOME: "the catheter head is not at its park position",
    I.HEAD_ADVANCES: "the insertion motor does not move the catheter head in",
    I.HEAD_RETURNS: "the insertion motor does not bring the catheter head back",
    I.LINE_VENTED: "there is vacuum in the line with the pump off",
    I.VALVE_OPENS: "the suction valve does not open in time",
    I.VALVE_CLOSES: "the spring does not close the suction valve in time",
    I.VACUUM_BUILDS: "the pump does not reach its set point in time",
    I.VACUUM_HOLDS: "the line loses its vacuum with the pump off: there is a leak",
    I.RELIEF_OPENS: "the mechanical relief valve does not keep the line at its vacuum",
    I.REGULATOR_HOLDS: "the regulator does not keep a lower set point",
}
"""What a failure means, for people."""

ITEMS: dict[CheckItem, str] = {
    I.READINGS: "Sensors give valid readings",
    I.CONTACT_OPEN: "Contact switch is open at rest",
    I.HEAD_HOME: "Encoder reads the park position",
    I.HEAD_ADVANCES: "Insertion motor moves the head in, within the slack",
    I.HEAD_RETURNS: "Insertion motor brings it back",
    I.LINE_VENTED: "Line is vented with the pump off",
    I.VALVE_OPENS: "Suction valve opens in time",
    I.VALVE_CLOSES: "Suction valve closes in time, by its spring alone",
    I.VACUUM_BUILDS: "Pump reaches its set point",
    I.RELIEF_OPENS: "Relief valve opens, behind the closed valve",
    I.REGULATOR_HOLDS: "Regulator keeps a lower set point",
    I.VACUUM_HOLDS: "Line holds its vacuum with the pump off",
}
"""Each item in words, in the order in which they are listed."""


class ItemLimits(NamedTuple):
    """Longest time for each item, s, in the order of `CheckItem`."""

    none: float
    readings: float
    contact_open: float
    head_home: float
    head_advances: float
    head_returns: float
    line_vented: float
    valve_opens: float
    valve_closes: float
    vacuum_builds: float
    vacuum_holds: float
    relief_opens: float
    regulator_holds: float
