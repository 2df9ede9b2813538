"""A run with faults before its judge: what the patient bore, and what of it no fault explains.

A catheter that stays in the airway: when the fault's own nature makes that unavoidable.

It is an outcome of its own, and never a safe state. Unavoidable it is only where the faults take
every actuator that could bring it out; then a person must be told at once, with high priority, and
do what no drive can. Whether a drive is taken is a matter of physics: of the faulty machine's own
parameters, not of a list of names.
"""

import math
from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple

from opensuction.kernel.vocabulary import AgeGroup
from opensuction.oracle import exposure, harm
from opensuction.oracle.exposure import BOUNDS, PatientExposure
from opensuction.oracle.harm import AIRWAY_TIME, CONTACT_TIME, LEFT_INSIDE, Harm
from opensuction.result.cycle_result import LeftInsideCount
from opensuction.safety.handling import Priority
from opensuction.simulation import outcome
from opensuction.simulation.injection import fault_allowance, least_exposure
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.simulation.injection.injection import Injected, InjectedRun
from opensuction.simulation.outcome import Annunciation
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import BY_TURNS, MachineEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.machine import Machine

GONE_S = 4.0
"""[design] A drive that has no force for so long is gone: a neonate's withdrawal may take 5 s in
all, and one that starts again later would pull against the hand that has been called."""
SPARE_SHARE = 0.01
"""Share of its force that a drive must have to spare: with less, 0.04 N for 16 kg, a catheter that
it pulls creeps by less than 1 mm/s after 0.4 s and cannot be told from one that is held fast, on
which nothing may go on pulling [computed]."""
PARTED_MM = 1000.0
"""More play than any rack is long: the head does not follow the motor."""


class Unavoidable(NamedTuple):
    """Reason why nothing of the machine can bring a catheter out, and the remedy by a person."""

    reason: str
    person: str


HELD = Unavoidable(
    "the insertion motor's whole force does not overcome what holds the catheter's head",
    "Draw the catheter out by hand, at the head's handle; cut it off its clamp if it is held fast.",
)
PARTED = Unavoidable(
    "the gear has parted: what the motor does no longer reaches the catheter's head",
    "Draw the catheter out by hand: the head moves freely.",
)
POWERLESS = Unavoidable(
    "neither mains nor reserve energy is left to move anything",
    "Draw the catheter out by hand: the head moves freely, and suction is off.",
)
SLIPPED = Unavoidable(
    "the clamp slips: with its head at home the catheter has not come out as far as it went in",
    "Draw the catheter out by hand, beyond the clamp; do not use this clamp again.",
)
LOOSE = Unavoidable(
    "the tip has parted from the catheter: nothing of the machine reaches it",
    "Call for a bronchoscopy: the tip lies in the airway and must be taken out with forceps.",
)


def _find_of_machine(machine: Machine) -> Unavoidable | None:
    axis = machine.insertion_axis
    if (1.0 - SPARE_SHARE) * axis.force_v <= axis.friction_v:
        return HELD
    if machine.gear_backlash_mm > PARTED_MM:
        return PARTED
    return SLIPPED if machine.clamp_slip_ratio > 0.0 else None


def find_unavoidable(machine: Machine, came: Sequence[Injection]) -> Unavoidable | None:
    """Reason why a catheter must stay inside under these faults; None where it could be moved.

    machine: as it was built, before any fault. came: the faults whose instant came.
    """
    for one in came:
        row = ROWS[one.fault]
        if one.fault == Fault.POWER_LOST_WITHOUT_RESERVE:
            return POWERLESS
        if one.fault == Fault.TIP_LEFT_BEHIND:
            return LOOSE
        gone = row.course == BY_TURNS and one.strength >= GONE_S
        if isinstance(row.effect, MachineEffect) and (row.course is None or gone):  # else it passes
            machine = row.change_machine(machine, one.strength)
    return _find_of_machine(machine)


def told_s(told: Sequence[Annunciation], from_s: float) -> float:
    """Time of the first alarm of high priority, from an instant on; nan where there was none."""
    high = [
        one.at_s
        for one in told
        if one.at_s >= from_s and one.condition.row.handling.priority == Priority.HIGH
    ]
    return min(high, default=float("nan"))


CONSEQUENCES = (AIRWAY_TIME, CONTACT_TIME)
"""Of a catheter that stays inside until a person draws it out: nobody does in a run."""
COLUMNS = tuple(dict.fromkeys((*exposure.COLUMNS, *outcome.COLUMNS)))
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
    unavoidable: tuple[Harm, ...]
    """Bounds of time that no withdrawal could have kept, each with the least value that any could
    have come to; empty before `spare`."""
    left_inside: LeftInside | None
    """None where the tip is out."""
    told: tuple[Annunciation, ...]
    """Of what people were told in the whole run."""


def _judge_left_inside(
    machine: Machine, told: Sequence[Annunciation], came: Sequence[Injected], within_s: float
) -> LeftInside:
    why = find_unavoidable(machine, [one.injection for one in came])
    from_s = min((one.at_s for one in came), default=0.0)
    after_s = told_s(told, from_s) - from_s
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
    told = tuple(outcome.told(columns))
    breaches = fault_allowance.find_breaches(found, [one.injection for one in came], strictly)
    left = None
    if borne.inside_at_end or borne.piece_mm > 0.0:
        left = _judge_left_inside(machine, told, came, told_within_s)
        excused = {*CONSEQUENCES} if left.unavoidable else set()
        if left.unavoidable and left.in_time:
            excused.add(LEFT_INSIDE)
        breaches = tuple(one for one in breaches if one.name not in excused)
    return Judgement(borne, found, breaches, (), left, told)


def spare(judged: Judgement, machine: Machine, run: InjectedRun) -> Judgement:
    """The judgement without the breaches of time that no withdrawal could have kept.

    machine: as it was built. run: that was judged. Nothing is spared where people were not told
    within the patient's own bound of time in the airway.
    """
    late = [one for one in judged.breaches if one.name in CONSEQUENCES]
    from_s = min((one.at_s for one in run.faults if not math.isnan(one.at_s)), default=0.0)
    within_s = BOUNDS[AgeGroup(machine.patient.age_group)].in_airway_s
    if not late or not told_s(judged.told, from_s) - from_s <= within_s:
        return judged
    least = least_exposure.find(machine, run)
    if least is None:
        return judged
    values = {AIRWAY_TIME: least.in_airway_s, CONTACT_TIME: least.contact_s}
    at_least = (one._replace(worst=values[one.name]) for one in late)
    unavoidable = tuple(one for one in at_least if one.is_broken)
    spared = {one.name for one in unavoidable}
    breaches = tuple(one for one in judged.breaches if one.name not in spared)
    return judged._replace(breaches=breaches, unavoidable=unavoidable)
