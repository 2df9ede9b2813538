"""One cycle of a trial: played, and judged by the truth alone.

A fault comes while it matters: the tip is in the airway, or will be within a second. One that comes
second, when the first has already had the catheter drawn out, can do no more: it is not counted.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from opensuction.evidence import healthy_cycle
from opensuction.evidence.healthy_cycle import AIRWAY, HealthyCycle
from opensuction.evidence.trial import alarm_classification, post_cycle_observation, sound_machine
from opensuction.evidence.trial.draw import DrawnFault
from opensuction.evidence.trial.sound_machine import SoundMachine
from opensuction.kernel.phase import Phase
from opensuction.oracle import exposure
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import Harm
from opensuction.result.trial_result import Endpoints
from opensuction.session.cycle import cycle_run
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection, invariant, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun, is_linked
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.simulation.injection.invariant import Breach
from opensuction.simulation.injection.row_buffer import RowBuffer
from opensuction.simulation.injection.run_judgement import LeftInside, PatientAlone
from opensuction.simulation.trace import Columns
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault

REMOVED = "truth.secretion_removed_ml"
JUDGED = tuple(
    dict.fromkeys(
        (
            *invariant.JUDGED,
            *run_judgement.COLUMNS,
            *healthy_cycle.COLUMNS,
            *alarm_classification.COLUMNS,
            REMOVED,
        )
    )
)
"""Columns that are looked at."""
LOOKS_BACK_S = (link.RING_TICKS + 1) * DT_S
"""For so long a link remembers what passed: it is played that long before it fails."""
LOOKS_BACK_FURTHER = (Fault.MONITOR_LATE,)
"""Faults of a link that hand on what is older: played from the start."""
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


def make_room(names: Sequence[str] = JUDGED) -> RowBuffer:
    """Room for the longest cycle of a trial."""
    return injection.make_room(post_cycle_observation.WATCHED_S, names=names)


def place(drawn: Sequence[DrawnFault], healthy: HealthyCycle) -> tuple[Injection, ...]:
    """The faults of a cycle at their instants, which come whatever the first of them has done.

    healthy: the machine's own cycle without any.
    """
    return tuple(
        Injection(
            one.fault,
            FaultInstant(None, healthy_cycle.find_time_s(healthy, AIRWAY, one.share)),
            one.strength,
        )
        for one in drawn
    )


def _find_begin_s(injections: Sequence[Injection]) -> float:
    """From when on a cycle with faults must be played."""
    first_s = min(one.at.after_s for one in injections)
    if any(one.fault in LOOKS_BACK_FURTHER for one in injections):
        return 0.0
    return max(first_s - LOOKS_BACK_S, 0.0) if is_linked(injections) else first_s


class Played(NamedTuple):
    """A run, and what came after it."""

    run: InjectedRun
    watched_s: float
    """How long machine and patient were watched once the machine was at rest."""
    alone: PatientAlone
    """What the patient went through in the rest of the longest watch."""

    @property
    def rested(self) -> int:
        """Tick in which the machine had come to rest."""
        return len(self.run.columns["phase"]) - 1 - round(self.watched_s / DT_S)


def _finish(
    prepared: Prepared, going: FaultyRun, injections: Sequence[Injection], whole: bool
) -> Played:
    """Play a run to its end. whole: machine and patient together for the longest time."""
    machine = prepared.rig.machine
    watched_s = post_cycle_observation.watch(going, machine, injections, whole)
    alone = post_cycle_observation.follow_alone(
        going, machine, post_cycle_observation.WATCHED_S - watched_s
    )
    return Played(injection.take(going, injections), watched_s, alone)


def play_sound(prepared: Prepared, room: RowBuffer, whole: bool = False) -> Played:
    """Play a cycle in which nothing is wrong. whole: as `_finish`."""
    going = FaultyRun(prepared.loop, prepared.start, (), room, seed=0)
    return _finish(prepared, going, (), whole)


def play_faulty(
    machine: SoundMachine,
    injections: Sequence[Injection],
    seed: int,
    room: RowBuffer,
    whole: bool = False,
) -> Played:
    """Play a cycle with faults from the last mark before them.

    seed: their chance. whole: as `_finish`.
    """
    injection.check(injections)
    prepared = machine.prepared
    going = FaultyRun(prepared.loop, prepared.start, injections, room, seed)
    mark = sound_machine.find_mark(machine, round(_find_begin_s(injections) / DT_S))
    if mark.tick > prepared.start.tick:
        room.fill(machine.rows, mark.tick - prepared.start.tick)
        going.begin_at(mark)
    return _finish(prepared, going, injections, whole)


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


def _measure(prepared: Prepared, played: Played, borne: PatientExposure) -> Endpoints:
    removed = played.run.columns[REMOVED]
    removed_ml = float(removed[played.rested] - removed[0])
    there_ml = cycle_run.secretion_ml(prepared, played.rested * DT_S)
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


def judge(number: int, prepared: Prepared, played: Played) -> Case:
    """Hold a run against every invariant and bound."""
    run, settings = played.run, prepared.loop.controller
    columns = run.columns
    found = run_judgement.judge(
        prepared.rig.machine,
        settings.limits.cap_mm,
        columns,
        run.faults,
        alone=played.alone,
    )
    came = _list_came(prepared, run)
    from_s = min((one.at_s for one in came if not math.isnan(one.at_s)), default=math.inf)
    ticks = len(columns["time_s"]) if math.isinf(from_s) else max(round(from_s / DT_S), 1)
    sound = {name: columns[name][:ticks] for name in alarm_classification.COLUMNS}
    spoken = alarm_classification.listen(sound, settings.limits.patient)
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
        commands=tuple(invariant.command_side(run.sent, settings)),
        breaches=found.breaches,
        left_inside=found.left_inside,
        endpoints=_measure(prepared, played, found.borne),
        watched_s=played.watched_s,
    )
