"""Faults of the set-up: what a person chose wrongly before the start."""

from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import SetupEffect, Strength, row

ROWS = {
    Fault.WRONG_PRESET: row(
        "an adult's protocol is set for a neonate",
        SetupEffect(is_planned=True),
        detected_by="the guidelines of the patient's age, before the start",
    ),
    Fault.CATHETER_TOO_WIDE: row(
        "a catheter is fitted that is too wide for the tube",
        SetupEffect(is_planned=True),
        detected_by="the guideline's ratio, before the start",
    ),
    Fault.CATHETER_EXPIRED: row(
        "the catheter has been used for more than its life",
        SetupEffect(is_planned=False),
        Strength("since its first use", "h", 24.0, 1000.0, 25.0),
        detected_by="its clock, at the request",
    ),
    Fault.TAUGHT_TOO_DEEP: row(
        "the way to the carina was taught longer than it is",
        SetupEffect(is_planned=True),
        Strength("too much", "mm", 1.0, 60.0, 20.0),
        detected_by="the range that is plausible for the age; contact before the window",
    ),
}
