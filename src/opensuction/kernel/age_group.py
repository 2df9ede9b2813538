"""Age groups of patients: limits of suctioning differ between them."""

from enum import IntEnum


class AgeGroup(IntEnum):
    """Age group of the patient, as guidelines divide them; stored in recordings: never renumber."""

    NEONATE = 0
    CHILD = 1
    """Infants and children."""
    ADULT = 2
