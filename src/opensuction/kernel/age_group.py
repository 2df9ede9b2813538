"""Age groups of patients: limits of suctioning differ between them."""

from enum import IntEnum


class AgeGroup(IntEnum):
    """Who the patient is, as guidelines divide them; stored in recordings: never renumber."""

    NEONATE = 0
    CHILD = 1
    """Infants and children."""
    ADULT = 2
