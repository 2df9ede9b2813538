"""One cycle of a trial: its faults placed, and its run judged by the truth alone.

A fault comes while it matters: the tip is in the airway, or will be within a second. One that comes
second, when the first has already had the catheter drawn out, can do no more: it is not counted.

True and false alarms of a cycle without faults.

An alarm from the patient monitor is compared with the truth of the patient: a saturation below its
limit is told rightly, and so is the contact of a tip that touches. Any other alarm of a sound
machine is false.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import Played
from opensuction.evidence.campaign.sound_machine import AIRWAY, HealthyCycle
from opensuction.evidence.trial.draw import DrawnFault
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import Harm
from opensuction.result.trial_result import Endpoints
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.safety.limits import PatientLimits
from opensuction.session.cycle import cycle_run
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import outcome
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.simulation.injection.invariant import Breach
from opensuction.simulation.injection.run_judgement import LeftInside
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault

TOUCHED_TICKS = 500
"""For how long the tip must have touched something: less than contact is waited for."""
BROKEN_OFF = "broken off"
"""Said of a cycle that ends early and names no condition."""
COLUMNS = (
    "time_s",
    "phase",
    "verdict.trips",
    "truth.spo2_percent",
    "truth.heart_rate_per_min",
    "truth.airway_pressure_cmh2o",
    "truth.contact_n",
    *outcome.COLUMNS,
)
"""What is looked at."""


def _is_desaturated(columns: Columns, limits: PatientLimits) -> bool:
    return bool(columns["truth.spo2_percent"].min() < limits.spo2_percent)


def _is_bradycardic(columns: Columns, limits: PatientLimits) -> bool:
    return bool(columns["truth.heart_rate_per_min"].min() < limits.heart_rate_per_min)


def _is_pressure_unsafe(columns: Columns, limits: PatientLimits) -> bool:
    pressure = columns["truth.airway_pressure_cmh2o"]
    least, most = limits.airway_least_cmh2o, limits.airway_most_cmh2o
    return bool(pressure.min() < least or pressure.max() > most)


def _is_losing_volume(columns: Columns, limits: PatientLimits) -> bool:
    return bool(columns["truth.airway_pressure_cmh2o"].min() < limits.airway_losing_cmh2o)


def _is_touching(columns: Columns, _: PatientLimits) -> bool:
    """Something was in the tip's way, such as the carina of a patient who has been moved."""
    return bool(columns["truth.contact_n"][-TOUCHED_TICKS:].min() > 0.0)


TRUE_WHERE: dict[Condition, Callable[[Columns, PatientLimits], bool]] = {
    Condition.SPO2_LOW: _is_desaturated,
    Condition.HEART_RATE_LOW: _is_bradycardic,
    Condition.AIRWAY_PRESSURE_UNSAFE: _is_pressure_unsafe,
    Condition.LUNG_VOLUME_LOST: _is_losing_volume,
    Condition.CONTACT_STUCK_CLOSED: _is_touching,
}
"""Conditions of the patient that may be there without any fault, and whether one was, by the truth
up to when it was said."""
CONSEQUENCES = (Condition.AUTOMATION_STOPPED,)
"""Said of every cycle that is broken off: as true as what has broken it off."""


class Spoken(NamedTuple):
    """False and true alarms of a sound cycle, by name."""

    false: tuple[str, ...]
    true: tuple[str, ...]


def _list_said(columns: Columns) -> dict[Condition, float]:
    """Conditions that tripped or were told, and when first."""
    first: dict[Condition, float] = {}
    for one in outcome.told(columns):
        first.setdefault(one.condition, one.at_s)
    masks = columns["verdict.trips"].astype(np.int64)
    for trip in condition_mask.decode_trips(int(np.bitwise_or.reduce(masks))):
        at_s = float(columns["time_s"][np.argmax(masks >> int(trip) & 1)])
        first[trip] = min(at_s, first.get(trip, at_s))
    return first


def _is_so(condition: Condition, at_s: float, columns: Columns, limits: PatientLimits) -> bool:
    """True if what an alarm said at an instant had come to pass by then."""
    if condition not in TRUE_WHERE:
        return False
    ticks = int(np.searchsorted(columns["time_s"], at_s, side="right"))
    until = {name: columns[name][:ticks] for name in COLUMNS}
    return TRUE_WHERE[condition](until, limits)


def listen(columns: Columns, limits: PatientLimits) -> Spoken:
    """False and true alarms of a run, or a part of it from its start, in which nothing was wrong.

    columns: at least `COLUMNS`. limits: of the patient, as the controller has them.
    """
    said = _list_said(columns)
    held = {one for one, at_s in said.items() if _is_so(one, at_s, columns, limits)}
    if held:
        held |= {one for one in said if one in CONSEQUENCES}
    false = [one.name for one in said if one not in held]
    if not said and np.isin(columns["phase"], (Phase.ABORTING, Phase.HALTED)).any():
        false.append(BROKEN_OFF)
    return Spoken(tuple(false), tuple(one.name for one in said if one in held))


REMOVED = "truth.secretion_removed_ml"
JUDGED = tuple(dict.fromkeys((*played_cycle.JUDGED, *COLUMNS, REMOVED)))
"""Columns that are looked at."""
ON_THE_WAY = (Phase.CHECKING, Phase.PRELOADING, Phase.INSERTING)
"""Phases after which the tip is about to be inside."""


class Came(NamedTuple):
    """A fault of a cycle."""

    fault: Fault
    strength: float
    at_s: float
    """Instant, from the start."""
    counts: bool
    """Whether it could matter: the tip was inside then or later, or about to be."""


class Case(NamedTuple):
    """Judgement of a cycle."""

    number: int
    patient: str
    approach: str
    seed: int
    """Of its machine and patient."""
    faults: tuple[Came, ...]
    completed: bool
    told: bool
    """Whether people were told of anything from the first fault on."""
    false_alarms: tuple[str, ...]
    """What was said before any fault, or without one, and was not so."""
    true_alarms: tuple[str, ...]
    """And what was."""
    commands: tuple[Breach, ...]
    breaches: tuple[Harm, ...]
    """Bounds of the patient that were broken, but for what the faults make unavoidable."""
    unavoidable: tuple[Harm, ...]
    """Bounds of time that no withdrawal could have kept, with the least value of any."""
    left_inside: LeftInside | None
    """None where the tip is out."""
    endpoints: Endpoints
    watched_s: float
    """For how long, once the machine was at rest."""

    @property
    def counted(self) -> int:
        """Number of faults that came and could matter."""
        return sum(one.counts for one in self.faults)

    @property
    def is_broken(self) -> bool:
        """True if a bound was broken, or an alarm of a sound cycle was false."""
        said = self.false_alarms and not self.counted
        return bool(self.commands or self.breaches or said)


def place(drawn: Sequence[DrawnFault], healthy: HealthyCycle) -> tuple[Injection, ...]:
    """The faults of a cycle at their instants, which come whatever the first of them has done.

    healthy: the machine's own cycle without any.
    """
    return tuple(
        Injection(
            one.fault,
            FaultInstant(None, sound_machine.find_time_s(healthy, AIRWAY, one.share)),
            one.strength,
        )
        for one in drawn
    )


def _counts(prepared: Prepared, columns: Columns, at_s: float) -> bool:
    """True if a fault that came at an instant could matter."""
    if math.isnan(at_s):
        return False
    tick = round(at_s / DT_S)
    inside = exposure.find_inside(prepared.rig.machine, columns["truth.tip_mm"])
    return bool(inside[tick:].any()) or columns["phase"][tick] in ON_THE_WAY


def _list_came(prepared: Prepared, run: InjectedRun) -> tuple[Came, ...]:
    """The faults of a run; the first one always counts, for it comes when it matters."""
    first_s = min((one.at_s for one in run.faults), default=math.nan)
    return tuple(
        Came(
            one.injection.fault,
            one.injection.strength,
            one.at_s,
            one.at_s == first_s or _counts(prepared, run.columns, one.at_s),
        )
        for one in run.faults
    )


def _measure(played: Played, borne: PatientExposure) -> Endpoints:
    removed = played.run.columns[REMOVED]
    removed_ml = float(removed[played.rested] - removed[0])
    there_ml = cycle_run.secretion_ml(played.prepared, played.rested * DT_S)
    return Endpoints(
        removed_ml=removed_ml,
        removed_percent=100.0 * removed_ml / there_ml if there_ml > 0.0 else None,
        spo2_least_percent=borne.spo2_least_percent,
        lung_volume_loss_ml=borne.lung_volume_loss_ml,
        in_airway_s=borne.in_airway_s,
        suction_s=borne.suction_s,
        force_peak_n=borne.force_peak_n,
    )


def _is_completed(played: Played) -> bool:
    phase = played.run.columns["phase"]
    return bool(phase[played.rested] == Phase.PARKED and (phase == Phase.CLOSING).any())


def judge(number: int, played: Played) -> Case:
    """Hold a run against every invariant and bound."""
    prepared, columns = played.prepared, played.run.columns
    found = played.judge()
    came = _list_came(prepared, played.run)
    from_s = min((one.at_s for one in came if not math.isnan(one.at_s)), default=math.inf)
    ticks = len(columns["time_s"]) if math.isinf(from_s) else max(round(from_s / DT_S), 1)
    sound = {name: columns[name][:ticks] for name in COLUMNS}
    spoken = listen(sound, prepared.loop.controller.limits.patient)
    choice = prepared.resolved.choice
    return Case(
        number=number,
        patient=str(choice.rig.patient),
        approach=choice.approach,
        seed=choice.rig.seed,
        faults=came,
        completed=_is_completed(played),
        told=any(one.at_s >= from_s for one in found.told),
        false_alarms=spoken.false,
        true_alarms=spoken.true,
        commands=played.list_command_breaches(),
        breaches=found.breaches,
        unavoidable=found.unavoidable,
        left_inside=found.left_inside,
        endpoints=_measure(played, found.borne),
        watched_s=played.watched_s,
    )
