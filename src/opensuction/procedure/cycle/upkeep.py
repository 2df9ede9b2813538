"""Between cycles: the catheter's life, who may start, and when a cycle is due."""

from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import Phase
from opensuction.kernel.requests import Requests
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.schedule import Schedule, ScheduleState
from opensuction.safety.condition import Condition

LIFE_S = 86400.0
"""A catheter is used for 24 h from its first use. Source: [paper] II-A."""
NEW_CATHETER_S = 0.0
"""Age of a catheter at its first use."""


class Refusal(IntEnum):
    """Why a start was refused. The numbers are stored in recordings: never renumber."""

    NONE = 0
    CATHETER_LIFE_OVER = 1
    CATHETER_LIFE_ENDS = 2
    """It would end within the cycle."""
    OUT_OF_SERVICE = 3
    HALTED = 4
    NOT_TAUGHT = 5
    """The plan is one that a travel length is taught with."""
    MONITOR_LINK_LOST = 6
    PATIENT_UNSAFE = 7
    """The monitor shows a value out of its limits."""


SENTENCES: dict[Refusal, str] = {
    Refusal.NONE: "nothing was refused",
    Refusal.CATHETER_LIFE_OVER: "the catheter has been used for 24 h: change it",
    Refusal.CATHETER_LIFE_ENDS: "the catheter's 24 h would end within the cycle: change it",
    Refusal.OUT_OF_SERVICE: "the machine is out of service",
    Refusal.HALTED: "the machine is halted: deal with the cause and reset it",
    Refusal.NOT_TAUGHT: "no travel length has been set",
    Refusal.MONITOR_LINK_LOST: "the patient monitor cannot be read: check its cables",
    Refusal.PATIENT_UNSAFE: "the patient monitor shows a value out of its limits: look at the "
    "patient first",
}
"""For people."""


class Service(NamedTuple):
    """What is set."""

    life_s: float
    """Longest use of a catheter."""
    cycle_s: float
    """Longest that a cycle may take."""
    schedule: Schedule


class Upkeep(NamedTuple):
    """What is remembered from cycle to cycle."""

    catheter_age_s: float
    schedule: ScheduleState
    refusal: int
    """Of the last start; NONE again when one is accepted."""


def start(catheter_age_s: float) -> Upkeep:
    """At power-up. catheter_age_s: since the catheter's first use; not known (nan) is over.

    Intervals begin anew.
    """
    age_s = catheter_age_s if catheter_age_s >= 0.0 else float("inf")
    return Upkeep(catheter_age_s=age_s, schedule=schedule.restart(), refusal=0)


def pass_idle_time(upkeep: Upkeep, duration_s: float) -> Upkeep:
    """After a time in which the machine was parked and nobody asked for anything."""
    return upkeep._replace(
        catheter_age_s=upkeep.catheter_age_s + duration_s,
        schedule=schedule.pass_idle_time(upkeep.schedule, duration_s),
    )


@compiled
def refusal(service: Service, upkeep: Upkeep, phase: int, travel_known: bool, patient: int) -> int:
    """Why a start would be refused in a phase that waits for a person.

    patient: bit mask of what is wrong with the patient; see `patient_watch`.
    """
    if phase == Phase.OUT_OF_SERVICE:
        return Refusal.OUT_OF_SERVICE
    if phase == Phase.HALTED:
        return Refusal.HALTED
    if not travel_known:
        return Refusal.NOT_TAUGHT
    if upkeep.catheter_age_s >= service.life_s:
        return Refusal.CATHETER_LIFE_OVER
    if upkeep.catheter_age_s + service.cycle_s > service.life_s:
        return Refusal.CATHETER_LIFE_ENDS
    if patient >> Condition.MONITOR_LINK_LOST & 1:
        return Refusal.MONITOR_LINK_LOST
    if patient != 0:
        return Refusal.PATIENT_UNSAFE
    return Refusal.NONE


@compiled
def is_asked(service: Service, upkeep: Upkeep, phase: int, requests: Requests) -> bool:
    """Whether a person or the clock asks for a cycle; while one runs nobody can."""
    if requests.abort:
        return False
    if phase == Phase.PARKED:
        return requests.start or schedule.starts(service.schedule, upkeep.schedule)
    return requests.start and phase in (Phase.HALTED, Phase.OUT_OF_SERVICE)


@compiled
def is_prompting(service: Service, upkeep: Upkeep, phase: int) -> bool:
    """Whether an assessment is due and the machine could act on it."""
    return phase == Phase.PARKED and schedule.prompts(service.schedule, upkeep.schedule)


@compiled
def step(
    upkeep: Upkeep,
    before: int,
    phase: int,
    asked: bool,
    refused: int,
    requests: Requests,
    dt_s: float,
) -> Upkeep:
    """One tick. before, phase: last and present phase. refused: what the start met if asked."""
    serviced = before == Phase.OUT_OF_SERVICE
    renewed = serviced and requests.changed
    attended = phase == Phase.PARKED and (serviced or before == Phase.HALTED)
    began = phase == Phase.CHECKING and before == Phase.PARKED
    return Upkeep(
        catheter_age_s=0.0 if renewed else upkeep.catheter_age_s + dt_s,
        schedule=schedule.step(upkeep.schedule, began, requests.not_needed, attended, dt_s),
        refusal=refused if asked else upkeep.refusal,
    )
