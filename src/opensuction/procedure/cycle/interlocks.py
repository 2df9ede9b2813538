"""Between cycles: who may start and reset what, and when a cycle is due.

The catheter's life, the schedule, passes and the rest between them, pre-oxygenation, lock-out: what
each remembers is one field of `Interlocks`, which whoever keeps the catheter's age over a
power-down hands to the next controller (`controller.restart`).
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import lock_out, schedule
from opensuction.procedure.cycle.lock_out import LockOut, Refusal
from opensuction.procedure.cycle.schedule import (
    Episode,
    OxygenAnswer,
    PassRule,
    Schedule,
    ScheduleState,
)
from opensuction.safety.condition import Condition

LIFE_S = 86400.0
"""A catheter is used for 24 h from its first use. Source: [paper] II-A."""
NEW_CATHETER_S = 0.0
"""Age of a catheter at its first use."""


class Service(NamedTuple):
    """Settings of the interlocks."""

    life_s: float
    """Longest use of a catheter."""
    cycle_s: float
    """Longest that a cycle may take."""
    schedule: Schedule
    passes: PassRule


class Interlocks(NamedTuple):
    """State that is kept from cycle to cycle."""

    catheter_age_s: float
    schedule: ScheduleState
    refusal: int
    """Of the last start or reset; NONE again when a start is accepted."""
    episode: Episode
    oxygen: OxygenAnswer
    lock: LockOut


class Counters(NamedTuple):
    """Counters in a recording, as a tick ended."""

    passes: int
    """Since a person last looked at the patient."""
    rest_left_s: float
    """Before another pass may begin."""
    resets: int
    """With the same cause, since the last whole cycle."""
    locked_out: bool
    preoxygenation: int
    """A `Preoxygenation`: of the pass that goes on, else of the next one."""
    refusal: int
    late_share: float
    """Of the controller's ticks, averaged as the governor does."""


def start(catheter_age_s: float) -> Interlocks:
    """At power-up. catheter_age_s: since the catheter's first use; not known (nan) is over.

    Intervals begin anew.
    """
    age_s = catheter_age_s if catheter_age_s >= 0.0 else float("inf")
    return Interlocks(
        catheter_age_s=age_s,
        schedule=schedule.restart(),
        refusal=0,
        episode=schedule.NEW,
        oxygen=schedule.NONE,
        lock=lock_out.NONE,
    )


def carry_over(fresh: Interlocks, kept: Interlocks, off_s: float) -> Interlocks:
    """At power-up, with what was remembered before and how long the power was off.

    fresh: as the new controller begins. Passes, rest and lock-out go on; intervals begin anew.
    """
    rested = schedule.pass_idle_time_episode(kept.episode, off_s)
    left_s = max(rested.rest_left_s, fresh.episode.rest_left_s)
    return fresh._replace(episode=rested._replace(rest_left_s=left_s), lock=kept.lock)


def rest_first(upkeep: Interlocks, rule: PassRule) -> Interlocks:
    """At power-up with the catheter perhaps in the airway: the patient rests before a start."""
    return upkeep._replace(episode=upkeep.episode._replace(rest_left_s=rule.rest_s))


@compiled
def count(upkeep: Interlocks, late_share: float) -> Counters:
    """Counters of the interlocks for a recording."""
    return Counters(
        passes=upkeep.episode.passes,
        rest_left_s=upkeep.episode.rest_left_s,
        resets=upkeep.lock.resets,
        locked_out=upkeep.lock.locked,
        preoxygenation=upkeep.oxygen.state,
        refusal=upkeep.refusal,
        late_share=late_share,
    )


def pass_idle_time(upkeep: Interlocks, duration_s: float) -> Interlocks:
    """After a time in which the machine was parked and nobody asked for anything."""
    return upkeep._replace(
        catheter_age_s=upkeep.catheter_age_s + duration_s,
        schedule=schedule.pass_idle_time(upkeep.schedule, duration_s),
        episode=schedule.pass_idle_time_episode(upkeep.episode, duration_s),
        oxygen=schedule.pass_oxygen_time(upkeep.oxygen, duration_s),
    )


@compiled
def hear(service: Service, upkeep: Interlocks, phase: int, requests: Requests) -> Interlocks:
    """Take the answers of people in a tick: the patient was looked at, oxygen was given.

    phase: as the tick begins. Heard before a start of the same tick; an abort means nothing else.
    """
    if requests.abort:
        return upkeep
    looked = requests.assessed or requests.not_needed
    passes = upkeep.episode
    return upkeep._replace(
        episode=schedule.assess(passes, phase) if looked else passes,
        oxygen=schedule.hear(service.passes.asks_for_oxygen, upkeep.oxygen, phase, requests),
    )


@compiled
def _machine_refusal(service: Service, upkeep: Interlocks, phase: int, travel_known: bool) -> int:
    """Reason why the machine cannot begin a cycle."""
    if phase == Phase.OUT_OF_SERVICE:
        return Refusal.OUT_OF_SERVICE
    if upkeep.lock.locked:
        return Refusal.LOCKED_OUT
    if phase == Phase.HALTED:
        return Refusal.HALTED
    if not travel_known:
        return Refusal.NOT_TAUGHT
    if upkeep.catheter_age_s >= service.life_s:
        return Refusal.CATHETER_LIFE_OVER
    if upkeep.catheter_age_s + service.cycle_s > service.life_s:
        return Refusal.CATHETER_LIFE_ENDS
    return Refusal.NONE


@compiled
def _patient_refusal(rule: PassRule, upkeep: Interlocks, patient: int) -> int:
    """Reason why the patient shall have no pass now."""
    if patient >> Condition.MONITOR_LINK_LOST & 1:
        return Refusal.MONITOR_LINK_LOST
    if patient != 0:
        return Refusal.PATIENT_UNSAFE
    if schedule.is_exhausted(rule, upkeep.episode):
        return Refusal.PASS_LIMIT
    if upkeep.episode.rest_left_s > 0.0:
        return Refusal.RESTING
    if rule.asks_for_oxygen and not schedule.is_answered(upkeep.oxygen):
        return Refusal.OXYGEN_UNANSWERED
    return Refusal.NONE


@compiled
def refusal(
    service: Service, upkeep: Interlocks, phase: int, travel_known: bool, patient: int
) -> int:
    """Reason why a start would be refused in a phase that waits for a person.

    patient: bit mask of what is wrong with the patient; see `patient_watch`.
    """
    refused = _machine_refusal(service, upkeep, phase, travel_known)
    if refused != Refusal.NONE:
        return refused
    return _patient_refusal(service.passes, upkeep, patient)


@compiled
def is_asked(service: Service, upkeep: Interlocks, phase: int, requests: Requests) -> bool:
    """True where a person or the clock asks for a cycle; while one runs nobody can."""
    if requests.abort:
        return False
    if phase == Phase.PARKED:
        return requests.start or schedule.starts(service.schedule, upkeep.schedule)
    return requests.start and phase in (Phase.HALTED, Phase.OUT_OF_SERVICE)


@compiled
def is_prompting(service: Service, upkeep: Interlocks, phase: int) -> bool:
    """True while a person shall look at the patient and the machine could act on it."""
    due = schedule.prompts(service.schedule, upkeep.schedule)
    return phase == Phase.PARKED and (due or schedule.is_exhausted(service.passes, upkeep.episode))


@compiled
def step(
    service: Service,
    upkeep: Interlocks,
    before: int,
    phase: int,
    asked: bool,
    refused: int,
    requests: Requests,
    dt_s: float,
) -> Interlocks:
    """One tick, but for the lock-out. before, phase: last and present phase.

    upkeep: what was answered in this tick is heard (`hear`). refused: what the start met if asked.
    """
    serviced = before == Phase.OUT_OF_SERVICE
    renewed = serviced and requests.changed
    attended = phase == Phase.PARKED and (serviced or before == Phase.HALTED)
    began = phase == Phase.CHECKING and before == Phase.PARKED
    looked = requests.not_needed or requests.assessed
    passes = schedule.step_episode(service.passes, upkeep.episode, before, phase, dt_s)
    if asked and refused == Refusal.PASS_LIMIT:
        passes = passes._replace(exceeded=True)
    return upkeep._replace(
        catheter_age_s=0.0 if renewed else upkeep.catheter_age_s + dt_s,
        schedule=schedule.step(upkeep.schedule, began, looked, attended, dt_s),
        refusal=refused if asked else upkeep.refusal,
        episode=passes,
        oxygen=schedule.step_oxygen(
            service.passes.asks_for_oxygen, upkeep.oxygen, before, phase, asked, dt_s
        ),
    )


@compiled
def watch_resets(
    upkeep: Interlocks, before: int, phase: int, asked: bool, granted: bool, trips: int
) -> Interlocks:
    """The lock-out, one tick on.

    asked, granted: a reset of a halted machine. trips: mask of what is wrong; in the tick of a
    reset only of what still is.
    """
    refused = asked and not granted
    return upkeep._replace(
        refusal=Refusal.LOCKED_OUT.value if refused else upkeep.refusal,
        lock=lock_out.step(upkeep.lock, before, phase, granted, trips),
    )
