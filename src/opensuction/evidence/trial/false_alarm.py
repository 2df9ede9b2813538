"""Cycles in which nothing is wrong: none may trip, break off or raise an alarm.

Each cycle has a machine and a patient of its own, drawn from its number. An alarm that says what
is true of the patient is none of these: a saturation below its limit is told rightly.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from opensuction.evidence.trial.fault_campaign import APPROACHES, BASKET
from opensuction.kernel.errors import InputError
from opensuction.safety.alarm.alarm_episode import Episode
from opensuction.safety.condition import Condition
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation.trace import Columns

FIRST_SEED = 50_000
"""Away from the seeds that were looked at while limits were set."""


class Quiet(NamedTuple):
    """A cycle without a fault, and what was said of it all the same."""

    seed: int
    patient: str
    approach: str
    completed: bool
    trips: tuple[str, ...]
    alarms: tuple[str, ...]
    """Those that say what is not so."""
    true_alarms: tuple[str, ...]
    """Those of the patient that say what is."""

    @property
    def ok(self) -> bool:
        """Whether it went as it should."""
        return self.completed and not self.trips and not self.alarms


def choice(number: int, compensation: str) -> CycleChoice:
    """The cycle of that number: patients and approaches in turn, a seed of its own."""
    protocol, patient = BASKET[number % len(BASKET)]
    approach = APPROACHES[number // len(BASKET) % len(APPROACHES)]
    rig = RigChoice(patient=patient, seed=FIRST_SEED + number)
    return CycleChoice(rig, protocol, approach, compensation)


def _is_true(episode: Episode, columns: Columns, spo2_percent: float) -> bool:
    """Whether the patient's saturation really was below its limit."""
    if episode.condition != Condition.SPO2_LOW:
        return False
    return bool(np.min(columns["truth.spo2_percent"]) < spo2_percent)


def played(number: int, compensation: str) -> Quiet:
    """Prepare and play one; what it came to."""
    prepared = cycle_run.prepare(resolution.resolve(choice(number, compensation)))
    columns = cycle_run.play(prepared)
    found = cycle_run.figures(prepared, columns)
    least = prepared.loop.controller.limits.patient.spo2_percent
    true = [one for one in found.alarms if _is_true(one, columns, least)]
    false = [one for one in found.alarms if one not in true]
    told = {one.condition for one in true}
    return Quiet(
        seed=prepared.rig.seed,
        patient=str(prepared.resolved.equipment.patient_name),
        approach=prepared.resolved.choice.approach,
        completed=found.completed or bool(told),
        trips=tuple(one.trip.name for one in found.trips if one.trip not in told),
        alarms=tuple(Condition(one.condition).name for one in false),
        true_alarms=tuple(Condition(one).name for one in told),
    )


class Campaign(NamedTuple):
    """Cycles that were played, and those that planning refused before they began."""

    cases: list[Quiet]
    refused: list[str]
    """Why: one line each. A machine that cannot keep its patient's limits is told so."""


def campaign(numbers: Iterable[int], compensation: str, cycles: int) -> Campaign:
    """That many cycles of these numbers, in order; a refused one does not count."""
    cases: list[Quiet] = []
    refused: list[str] = []
    for number in numbers:
        if len(cases) == cycles:
            break
        try:
            cases.append(played(number, compensation))
        except InputError as error:
            refused.append(f"{number}: {error}")
    return Campaign(cases, refused)
