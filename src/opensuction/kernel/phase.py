"""Phases of a suction cycle: the words that procedure, trace, reports and console share.

Where each phase may go is a table of its own: `opensuction.procedure.cycle.transition`.
"""

from enum import IntEnum


class Phase(IntEnum):
    """Phase of the machine. Gerunds; the numbers are stored in recordings: never renumber."""

    PARKED = 0
    """Tip out of the patient, valve closed, ready."""
    CHECKING = 1
    """Pre-use test of sensors, valve and pump."""
    PRELOADING = 2
    """Head takes up the gap of the transmission; the tip stands still."""
    INSERTING = 3
    """Tip advances to its stopping point, valve closed."""
    BACKING_OFF = 4
    """Tip leaves the carina after contact, before suction."""
    OPENING = 5
    """Cam opens the suction valve (point A to A' of the paper's Fig. 2)."""
    SUCTIONING = 6
    """Dwell with the valve open (A' to B)."""
    WITHDRAWING = 7
    """Tip moves out with the valve open (B to C)."""
    CLOSING = 8
    """Spring closes the valve (C to D)."""
    ABORTING = 9
    """Out of the airway first, suction as the fault allows."""
    HALTED = 10
    """Stopped and latched until a person resets."""
    TEACHING = 11
    """A person moves the catheter to measure the travel length."""
    IDENTIFYING = 12
    """Bench: the head follows the identification excitation."""
    OUT_OF_SERVICE = 13
    """Catheter change or cleaning."""


CYCLE = (
    Phase.CHECKING,
    Phase.PRELOADING,
    Phase.INSERTING,
    Phase.BACKING_OFF,
    Phase.OPENING,
    Phase.SUCTIONING,
    Phase.WITHDRAWING,
    Phase.CLOSING,
)
"""Phases of a cycle in their order; one that stops by travel does not back off."""
RESTING = (Phase.PARKED, Phase.HALTED, Phase.OUT_OF_SERVICE)
"""Phases that wait for a person."""
