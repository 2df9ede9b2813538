"""Items of the pre-use test: their order and their words."""

from enum import IntEnum


class CheckItem(IntEnum):
    """Item of the pre-use test, in the order of the test. Never renumber: recordings hold these.

    Sensors first, for the rest is judged by them; the valve strokes before there is vacuum. What
    the regulator has lowered, the line must hold.
    """

    title: str
    """What the item shows where it passes."""
    failure: str
    """What its failure means, for people."""

    def __new__(cls, number: int, *words: str) -> "CheckItem":
        """Member with the number as its value."""
        member = int.__new__(cls, number)
        member._value_ = number
        member.title, member.failure = words
        return member

    NONE = (0, "Nothing is being tested", "nothing failed")
    READINGS = (1, "Sensors give valid readings", "a sensor gives no valid reading")
    CONTACT_OPEN = (
        2,
        "Contact switch is open at rest",
        "the contact switch is closed although nothing touches the tip",
    )
    HEAD_HOME = (
        3,
        "Encoder reads the park position",
        "the catheter head is not at its park position",
    )
    HEAD_ADVANCES = (
        4,
        "Insertion motor moves the head in, within the slack",
        "the insertion motor does not move the catheter head in",
    )
    HEAD_RETURNS = (
        5,
        "Insertion motor brings it back",
        "the insertion motor does not bring the catheter head back",
    )
    LINE_VENTED = (
        6,
        "Line is vented with the pump off",
        "there is vacuum in the line with the pump off",
    )
    VALVE_OPENS = (7, "Suction valve opens in time", "the suction valve does not open in time")
    VALVE_CLOSES = (
        8,
        "Suction valve closes in time, by its spring alone",
        "the spring does not close the suction valve in time",
    )
    VACUUM_BUILDS = (
        9,
        "Pump reaches its set point",
        "the pump does not reach its set point in time",
    )
    RELIEF_OPENS = (
        11,
        "Relief valve opens, behind the closed valve",
        "the mechanical relief valve does not keep the line at its vacuum",
    )
    REGULATOR_HOLDS = (
        12,
        "Regulator keeps a lower set point",
        "the regulator does not keep a lower set point",
    )
    VACUUM_HOLDS = (
        10,
        "Line holds its vacuum with the pump off",
        "the line loses its vacuum with the pump off: there is a leak",
    )


ORDER = tuple(CheckItem)[1:]
"""The items without `NONE`."""
