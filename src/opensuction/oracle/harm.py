"""Bounds for the patient that a run broke; empty where it broke none.

`measure` returns for each bound how near the run came to it, `find` those that were broken.

The cause is not judged: a saturation that falls for the patient's own reasons is listed as any
other.
"""

import math
from typing import NamedTuple

from opensuction.kernel.age_group import AgeGroup
from opensuction.oracle.bound import ADVANCE_MM, BOUNDS, CLOSING_S, FORCE_N
from opensuction.oracle.exposure import PatientExposure
from opensuction.twin.machine.machine import Machine


class Harm(NamedTuple):
    """A bound, and how near to it or how far beyond it a patient came."""

    name: str
    """One of `NAMES`."""
    worst: float
    limit: float
    unit: str
    """Of both."""

    @property
    def is_broken(self) -> bool:
        """True where the worst value is beyond the limit."""
        if self.name == SATURATION:
            return self.worst < self.limit
        return self.worst > self.limit


LEFT_INSIDE = "left-inside"
TIP_PAST_CAP = "tip-past-cap"
FORCE = "force"
CONTACT_TIME = "contact-time"
VACUUM = "vacuum"
SUCTION_TIME = "suction-time"
AIRWAY_TIME = "airway-time"
ADVANCE = "advance-under-vacuum"
AIRWAY_PRESSURE = "airway-pressure"
LUNG_VOLUME = "lung-volume"
SATURATION = "saturation"

NAMES = (
    LEFT_INSIDE,
    TIP_PAST_CAP,
    FORCE,
    CONTACT_TIME,
    VACUUM,
    SUCTION_TIME,
    AIRWAY_TIME,
    ADVANCE,
    AIRWAY_PRESSURE,
    LUNG_VOLUME,
    SATURATION,
)
"""Every bound by name, the most urgent first."""


def deepest_mm(machine: Machine, cap_mm: float) -> float:
    """Greatest depth of the tip: its cap, and no further past the carina than force presses it.

    A tip that is further past it is in a bronchus. cap_mm: deepest position that was planned.
    """
    return min(cap_mm, machine.airway.carina_mm + FORCE_N / machine.airway.tip.carina_n_per_mm)


def _depth(machine: Machine, borne: PatientExposure, cap_mm: float) -> Harm:
    """Past its cap, or past the carina where that was at the same instant."""
    if borne.deepest_mm > cap_mm:
        return Harm(TIP_PAST_CAP, borne.deepest_mm, deepest_mm(machine, cap_mm), "mm")
    reached_mm = machine.airway.carina_mm + borne.past_carina_mm
    return Harm(TIP_PAST_CAP, reached_mm, deepest_mm(machine, math.inf), "mm")


def _rest(borne: PatientExposure) -> Harm:
    """The catheter at the end, or a piece of it."""
    if borne.piece_mm > 0.0 and not borne.inside_at_end:
        return Harm(LEFT_INSIDE, borne.piece_mm, 0.0, "mm")
    worst_mm = borne.end_mm if borne.inside_at_end else min(borne.end_mm, borne.outside_mm)
    return Harm(LEFT_INSIDE, worst_mm, borne.outside_mm, "mm")


def _of_machine(machine: Machine, borne: PatientExposure, cap_mm: float) -> tuple[Harm, ...]:
    """Bounds that hold on the bench, too."""
    force = Harm(FORCE, borne.force_peak_n, FORCE_N, "N")
    return _rest(borne), _depth(machine, borne, cap_mm), force


def _of_patient(machine: Machine, borne: PatientExposure) -> tuple[Harm, ...]:
    """Bounds that need a patient."""
    person = machine.patient
    bounds = BOUNDS[AgeGroup(person.age_group)]
    return (
        Harm(CONTACT_TIME, borne.contact_s, bounds.contact_s, "s"),
        Harm(VACUUM, borne.vacuum_peak_mmhg, bounds.vacuum_mmhg, "mmHg"),
        Harm(SUCTION_TIME, borne.suction_s, bounds.suction_s + CLOSING_S, "s"),
        Harm(AIRWAY_TIME, borne.in_airway_s, bounds.in_airway_s, "s"),
        Harm(ADVANCE, borne.advance_mm, ADVANCE_MM, "mm"),
        Harm(AIRWAY_PRESSURE, borne.pressure_unsafe_s, bounds.pressure_s, "s"),
        Harm(
            LUNG_VOLUME,
            borne.lung_volume_loss_ml,
            bounds.lung_loss_ml_per_kg * person.weight_kg,
            "mL",
        ),
        Harm(SATURATION, borne.spo2_least_percent, bounds.spo2_percent, "%"),
    )


def measure(machine: Machine, borne: PatientExposure, cap_mm: float) -> tuple[Harm, ...]:
    """Every bound, broken or not, in the order of `NAMES`; arguments as of `find`."""
    found = _of_machine(machine, borne, cap_mm)
    return (*found, *_of_patient(machine, borne)) if machine.has_patient else found


def find(machine: Machine, borne: PatientExposure, cap_mm: float) -> tuple[Harm, ...]:
    """Bounds that were broken, in the order of `NAMES`.

    machine: as it was built, before any fault. borne: of the whole run. cap_mm: deepest tip
    position that was planned; infinite where none was.
    """
    return tuple(one for one in measure(machine, borne, cap_mm) if one.is_broken)
