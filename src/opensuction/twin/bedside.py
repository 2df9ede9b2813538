"""Where the machine meets the patient: the gas its catheter takes, and the tube it fills.

The machine runs at 1 kHz, the patient at 100 Hz. Between two steps of the patient the gas that
the tip draws inside is added up, so that none is lost at the seam; the patient feels it a
hundredth of a second late at most.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.twin import patient as patients
from opensuction.twin.patient import Patient, PatientState

TICKS = 10
"""Ticks of the machine for each step of the patient."""


class SeamState(NamedTuple):
    """What has passed since the patient's last step."""

    ticks: int
    taken_ml: float
    """Gas that the tip drew inside the patient, at atmospheric pressure."""


NOTHING_PASSED = SeamState(ticks=0, taken_ml=0.0)


@compiled
def is_inside(patient: Patient, tip_mm: float) -> bool:
    """Whether the tip is past the tube's upper end."""
    return tip_mm > -patient.tube_length_mm


@compiled
def step(
    patient: Patient,
    state: PatientState,
    seam: SeamState,
    tip_mm: float,
    drawn_ml: float,
    catheter_mm: float,
    dt_s: float,
) -> tuple[PatientState, SeamState]:
    """Advance by one tick of the machine; the patient steps with every tenth.

    tip_mm, drawn_ml: where the tip is and what gas it drew in this tick, at atmospheric pressure.
    catheter_mm: outer diameter.
    """
    inside = is_inside(patient, tip_mm)
    taken = seam.taken_ml
    if inside:
        taken += drawn_ml
    if seam.ticks + 1 < TICKS:
        return state, SeamState(ticks=seam.ticks + 1, taken_ml=taken)
    ratio = catheter_mm / patient.tube_id_mm if inside else 0.0
    span_s = TICKS * dt_s
    later = patients.step(patient, state, taken / span_s, ratio, span_s)
    return later, SeamState(ticks=0, taken_ml=0.0)
