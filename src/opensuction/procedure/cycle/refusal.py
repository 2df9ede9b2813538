"""Reasons for which a start or a reset is refused, as numbers in the core and words outside."""

import math
from enum import IntEnum


class Refusal(IntEnum):
    """Reason why a start or a reset was refused. The numbers are in recordings: never renumber."""

    NONE = 0
    CATHETER_LIFE_OVER = 1
    CATHETER_LIFE_ENDS = 2
    """It would end within the cycle."""
    OUT_OF_SERVICE = 3
    HALTED = 4
    NOT_TAUGHT = 5
    """The plan is one that a travel length is taught with."""
    MONITOR_LINK_LOST = 6
    PATIENT_UNSAFE = 7
    """The monitor shows a value out of its limits."""
    PASS_LIMIT = 8
    """A person must look at the patient first."""
    RESTING = 9
    """The last pass is too short a time ago; `say` has the seconds left."""
    OXYGEN_UNANSWERED = 10
    """Pre-oxygenation is neither confirmed nor skipped."""
    LOCKED_OUT = 11
    """The machine must be taken out of service first."""


SENTENCES: dict[Refusal, str] = {
    Refusal.NONE: "nothing was refused",
    Refusal.CATHETER_LIFE_OVER: "the catheter has been used for 24 h: change it",
    Refusal.CATHETER_LIFE_ENDS: "the catheter's 24 h would end within the cycle: change it",
    Refusal.OUT_OF_SERVICE: "the machine is out of service",
    Refusal.HALTED: "the machine is halted: deal with the cause and reset it",
    Refusal.NOT_TAUGHT: "no travel length has been set",
    Refusal.MONITOR_LINK_LOST: "the patient monitor cannot be read: check its cables",
    Refusal.PATIENT_UNSAFE: "the patient monitor shows a value out of its limits: look at the "
    "patient first",
    Refusal.PASS_LIMIT: "as many passes as may follow each other have been made: look at the "
    "patient and say so",
    Refusal.RESTING: "the patient rests after the last pass",
    Refusal.OXYGEN_UNANSWERED: "pre-oxygenation has not been answered: give it and confirm, or "
    "skip it",
    Refusal.LOCKED_OUT: "the machine is locked out after resets with the same cause: take it out "
    "of service, find the cause, return it to service",
}
"""For people; `say` adds the seconds that are left of a rest."""


def say(refused: Refusal, rest_left_s: float) -> str:
    """Reason why a start or a reset was refused, in words, with the seconds left of a rest."""
    if refused == Refusal.RESTING:
        return f"{SENTENCES[refused]}: another {math.ceil(rest_left_s)} s"
    return SENTENCES[refused]
