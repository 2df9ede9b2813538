"""Schedule of cycles: on request, at timed intervals, or a prompt to look at the patient.

Guidelines prefer suctioning as needed: it is as good as scheduled suctioning [AARC-2022], and more
than six a day are a risk factor for desaturation and bleeding [Maggiore-2013]. Timed cycles
are the paper's (section II); the prompt asks a person, who starts a cycle or finds none needed.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError

LEAST_INTERVAL_S = 900.0
"""Shortest interval: lung volume and saturation recover in some 10 min [Yildirim-2024]."""
OFTEN_A_DAY = 6
"""More suctionings a day are a risk factor [Maggiore-2013]."""
DAY_S = 86400.0


class ScheduleMode(IntEnum):
    """Trigger of cycles. The numbers are stored in recordings: never renumber."""

    ON_REQUEST = 0
    TIMED = 1
    """It starts by itself every interval."""
    PROMPT = 2
    """Every interval a person is asked to look."""


class Schedule(NamedTuple):
    """Times at which cycles are due."""

    mode: int
    interval_s: float
    """From the start of one cycle (or assessment) to the next; no meaning on request."""


ON_REQUEST_ONLY = Schedule(mode=0, interval_s=0.0)
"""Nothing begins by itself."""


class ScheduleState(NamedTuple):
    """Time since something began, s."""

    since_cycle_s: float
    since_assessment_s: float


def schedule(mode: ScheduleMode, interval_s: float) -> Schedule:
    """A schedule that may be used. Raises InputError for an interval that is too short."""
    if mode == ScheduleMode.ON_REQUEST:
        return ON_REQUEST_ONLY
    if not math.isfinite(interval_s) or interval_s < LEAST_INTERVAL_S:
        raise InputError(
            f"an interval of {interval_s / 60.0:g} min is not at least "
            f"{LEAST_INTERVAL_S / 60.0:g} min: lungs need that long to recover; give more"
        )
    return Schedule(mode=int(mode), interval_s=interval_s)


def notes(chosen: Schedule) -> list[str]:
    """Advice of guidelines on a schedule, in sentences; empty where they give none."""
    if chosen.mode == ScheduleMode.ON_REQUEST:
        return []
    said = ["Guidelines prefer suctioning as needed to suctioning by the clock (AARC 2022)."]
    a_day = DAY_S / chosen.interval_s
    if chosen.mode == ScheduleMode.TIMED and a_day > OFTEN_A_DAY:
        said.append(
            f"Every {chosen.interval_s / 60.0:g} min is {a_day:.3g} times a day: more than "
            f"{OFTEN_A_DAY} a day are a risk factor for desaturation and bleeding (Maggiore 2013)."
        )
    return said


def restart() -> ScheduleState:
    """State in which all intervals begin now, as at power-up."""
    return ScheduleState(since_cycle_s=0.0, since_assessment_s=0.0)


def pass_idle_time(state: ScheduleState, duration_s: float) -> ScheduleState:
    """After a time in which nothing happened."""
    return ScheduleState(*(since_s + duration_s for since_s in state))


@compiled
def starts(chosen: Schedule, state: ScheduleState) -> bool:
    """True where a cycle shall start by itself."""
    return chosen.mode == ScheduleMode.TIMED and state.since_cycle_s >= chosen.interval_s


@compiled
def prompts(chosen: Schedule, state: ScheduleState) -> bool:
    """True where a person shall look at the patient."""
    return chosen.mode == ScheduleMode.PROMPT and state.since_assessment_s >= chosen.interval_s


@compiled
def step(
    state: ScheduleState, began: bool, assessed: bool, attended: bool, dt_s: float
) -> ScheduleState:
    """One tick. began: a cycle did. assessed: a person found none needed.

    attended: a person has just put a halted or serviced machine back to work. What had become due
    meanwhile is not made up for: the machine must not start in that person's hands.
    """
    cycle = 0.0 if began or attended else state.since_cycle_s + dt_s
    assessment = 0.0 if began or assessed or attended else state.since_assessment_s + dt_s
    return ScheduleState(since_cycle_s=cycle, since_assessment_s=assessment)
