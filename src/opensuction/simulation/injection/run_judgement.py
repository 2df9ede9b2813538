"""A run with faults before its judge: what the patient bore, and what of it no fault explains."""

import math
from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple

from opensuction.kernel.age_group import AgeGroup
from opensuction.oracle import exposure, harm
from opensuction.oracle.bound import BOUNDS
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import AIRWAY_TIME, CONTACT_TIME, LEFT_INSIDE, Harm
from opensuction.result.cycle_result import LeftInsideCount
from opensuction.simulation import annunciation
from opensuction.simulation.annunciation import Annunciation
from opensuction.simulation.injection import catheter_retention, fault_allowance
from opensuction.simulation.injection.injection import Injected
from opensuction.simulation.trace import Columns
from opensuction.twin.machine.machine import Machine

CONSEQUENCES = (AIRWAY_TIME, CONTACT_TIME)
"""Of a catheter that stays inside until a person draws it out: nobody does in a run."""
COLUMNS = tuple(dict.fromkeys((*exposure.COLUMNS, *annunciation.COLUMNS)))
"""What is looked at."""


class LeftInside(NamedTuple):
    """A catheter that was still in the airway when nobody watched any longer."""

    unavoidable: str
    """The argument; empty where something could have brought it out."""
    person: str
    """What a person must do."""
    told_s: float
    """How long after the first fault people were told with high priority; nan for never."""
    in_time: bool
    """Whether that was within its bound."""


def count_left_inside(found: Iterable[LeftInside | None]) -> LeftInsideCount:
    """Runs that ended with the tip inside; those that nothing could have prevented; those told."""
    left = [one for one in found if one is not None]
    return LeftInsideCount(
        count=len(left),
        unavoidable=sum(bool(one.unavoidable) for one in left),
        told=sum(one.in_time for one in left),
    )


class PatientAlone(NamedTuple):
    """Exposure of a patient after a run, while the machine does nothing."""

    spo2_least_percent: float = math.inf
    lung_volume_loss_ml: float = 0.0
    in_airway_s: float = 0.0
    """With a catheter that stays inside."""
    contact_s: float = 0.0
    """With one that stays on the carina."""

    def add_to(self, borne: PatientExposure) -> PatientExposure:
        """Exposure of the patient in the run and after it."""
        return borne._replace(
            spo2_least_percent=min(borne.spo2_least_percent, self.spo2_least_percent),
            lung_volume_loss_ml=max(borne.lung_volume_loss_ml, self.lung_volume_loss_ml),
            in_airway_s=borne.in_airway_s + self.in_airway_s,
            contact_s=borne.contact_s + self.contact_s,
        )


NOT_FOLLOWED = PatientAlone()


class Judgement(NamedTuple):
    """Judgement on a run."""

    borne: PatientExposure
    harm: tuple[Harm, ...]
    """Every bound that was broken, whosoever's doing it was."""
    breaches: tuple[Harm, ...]
    """Of these the ones that the faults' own nature does not make unavoidable."""
    left_inside: LeftInside | None
    """None where the tip is out."""
    told: tuple[Annunciation, ...]
    """Of what people were told in the whole run."""


def _judge_left_inside(
    machine: Machine, told: Sequence[Annunciation], came: Sequence[Injected], within_s: float
) -> LeftInside:
    why = catheter_retention.find_unavoidable(machine, [one.injection for one in came])
    from_s = min((one.at_s for one in came), default=0.0)
    after_s = catheter_retention.told_s(told, from_s) - from_s
    return LeftInside(
        unavoidable="" if why is None else why.reason,
        person="Draw the catheter out by hand." if why is None else why.person,
        told_s=after_s,
        in_time=after_s <= within_s,
    )


def judge(
    machine: Machine,
    cap_mm: float,
    columns: Columns,
    injected: Sequence[Injected],
    told_within_s: float = math.nan,
    strictly: Collection[str] = (),
    alone: PatientAlone = NOT_FOLLOWED,
) -> Judgement:
    """Judge a run by the truth of its columns, at least `COLUMNS`.

    machine: as it was built, before any fault. cap_mm: deepest planned position of the tip.
    injected: its faults. told_within_s: how soon people must be told of a catheter that cannot but
    stay inside; nan for the patient's own bound of time in the airway. strictly: bounds to which no
    fault adds anything. alone: what the patient goes through after the run.
    """
    came = [one for one in injected if not math.isnan(one.at_s)]
    if math.isnan(told_within_s):
        told_within_s = BOUNDS[AgeGroup(machine.patient.age_group)].in_airway_s
    borne = alone.add_to(exposure.measure(machine, columns))
    found = harm.find(machine, borne, cap_mm)
    told = tuple(annunciation.told(columns))
    breaches = fault_allowance.find_breaches(found, [one.injection for one in came], strictly)
    left = None
    if borne.inside_at_end or borne.piece_mm > 0.0:
        left = _judge_left_inside(machine, told, came, told_within_s)
        excused = {*CONSEQUENCES} if left.unavoidable else set()
        if left.unavoidable and left.in_time:
            excused.add(LEFT_INSIDE)
        breaches = tuple(one for one in breaches if one.name not in excused)
    return Judgement(borne, found, breaches, left, told)
