"""Cohorts of a trial: sets of patients by name."""

from opensuction.evidence.campaign.sound_machine import Kind
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.settings.choice import choose
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

PRESETS = "presets"
COHORTS: dict[str, tuple[str, ...]] = {
    PRESETS: tuple(PATIENT_TABLES),
    **{name: (name,) for name in PATIENT_TABLES},
}
"""Presets of patients by the name of their set: all of them, or one."""


def list_kinds(cohort: str) -> tuple[Kind, ...]:
    """Every patient of a cohort by every approach, in the order in which machines take turns.

    Raises InputError for an unknown name.
    """
    patients = choose(cohort, COHORTS, "--cohort")
    return tuple(Kind(patient, approach) for patient in patients for approach in APPROACHES)
