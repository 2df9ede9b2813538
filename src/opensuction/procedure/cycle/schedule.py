"""Schedule of cycles: on request, at timed intervals, or a prompt to look at the patient.

Guidelines prefer suctioning as needed: it is as good as scheduled suctioning [AARC-2022], and more
than six a day are a risk factor for desaturation and bleeding [Maggiore-2013]. Timed cycles
are the paper's (section II); the prompt asks a person, who starts a cycle or finds none needed.

Passes at one patient: how many may follow each other, and the rest between them.

A pass is an insertion, however it ends. Passes follow each other, however far apart, until a person
says that they have looked at the patient: a machine that goes on by itself would hide a blocked
tube, or an airway that bleeds (docs/decisions/0017).

Pre-oxygenation before a pass: asked for, confirmed or skipped by a person, and on record.

The machine gives no oxygen and cannot see that somebody does. It asks at the start, and begins
nothing before there is an answer. Source: [AARC-2022], adults and children.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Requests
from opensuction.kernel.vocabulary import RESTING, Phase

VALID_S = 120.0
"""How long before a start an answer may lie: a ventilator's 100 % lasts some 120 s [K]; whoever
confirmed longer ago is asked again [design]."""


class Preoxygenation(IntEnum):
    """State of pre-oxygenation for a pass. The numbers are stored in recordings: never renumber."""

    NOT_REQUIRED = 0
    NOT_ASKED = 1
    """Nobody has wanted to start yet."""
    REQUESTED = 2
    """A start waits for an answer."""
    CONFIRMED = 3
    """A person says that it has been given."""
    SKIPPED = 4
    """A person has decided to go without it."""


class OxygenAnswer(NamedTuple):
    """Answer about oxygen for the next pass; during a pass, for this one."""

    state: int
    """A `Preoxygenation`."""
    left_s: float
    """How long the answer holds for a start."""


NONE = OxygenAnswer(state=0, left_s=0.0)
"""At power-up: not answered."""


@compiled
def is_answered(answer: OxygenAnswer) -> bool:
    """True where a start may be granted."""
    return answer.state in (Preoxygenation.CONFIRMED, Preoxygenation.SKIPPED)


@compiled
def hear(required: bool, answer: OxygenAnswer, phase: int, requests: Requests) -> OxygenAnswer:
    """The answer after the buttons of a tick. phase: as the tick begins."""
    if not required:
        return NONE
    if phase != Phase.PARKED:
        return answer
    if requests.oxygenated:
        return OxygenAnswer(state=Preoxygenation.CONFIRMED.value, left_s=VALID_S)
    if requests.oxygen_skipped and answer.state != Preoxygenation.CONFIRMED:
        return OxygenAnswer(state=Preoxygenation.SKIPPED.value, left_s=VALID_S)
    return answer


@compiled
def step_oxygen(
    required: bool, answer: OxygenAnswer, before: int, phase: int, asked: bool, dt_s: float
) -> OxygenAnswer:
    """One tick. before, phase: last and present phase. asked: a start was, granted or not."""
    if not required:
        return NONE
    if phase not in RESTING:
        return answer._replace(left_s=0.0)  # on record for this pass
    left_s = answer.left_s - dt_s
    if phase != Phase.PARKED or before not in RESTING:
        left_s = 0.0  # it was for another start
    if is_answered(answer) and left_s > 0.0:
        return answer._replace(left_s=left_s)
    waiting = phase == Phase.PARKED and (asked or answer.state == Preoxygenation.REQUESTED)
    if waiting and not is_answered(answer):
        return OxygenAnswer(state=Preoxygenation.REQUESTED.value, left_s=0.0)
    return OxygenAnswer(state=Preoxygenation.NOT_ASKED.value, left_s=0.0)


def pass_oxygen_time(answer: OxygenAnswer, duration_s: float) -> OxygenAnswer:
    """After a time in which the machine was parked and nobody answered."""
    left_s = answer.left_s - duration_s
    if not is_answered(answer) or left_s > 0.0:
        return answer._replace(left_s=max(left_s, 0.0))
    return OxygenAnswer(state=Preoxygenation.NOT_ASKED.value, left_s=0.0)


class PassRule(NamedTuple):
    """Rule for passes on one patient; `opensuction.procedure.planning.guideline` has it by age."""

    most_passes: int
    """So many may follow each other; 0: nobody is there, and none is counted (bench)."""
    rest_s: float
    """Least time from the end of a pass to the next start."""
    asks_for_oxygen: bool
    """Whether a start needs an answer about pre-oxygenation."""


class Episode(NamedTuple):
    """Passes since a person last looked at the patient."""

    passes: int
    exceeded: bool
    """One more was asked for and refused: secretions may remain."""
    rest_left_s: float
    """What is left of the rest after the last pass; all of it while the pass goes on."""


NEW = Episode(passes=0, exceeded=False, rest_left_s=0.0)
"""Nothing has been done."""


@compiled
def is_exhausted(rule: PassRule, state: Episode) -> bool:
    """True once a person must look at the patient before another pass."""
    return 0 < rule.most_passes <= state.passes


@compiled
def assess(state: Episode, phase: int) -> Episode:
    """After a person has looked at the patient; with a catheter inside there is more to come."""
    if phase not in RESTING:
        return state
    return state._replace(passes=0, exceeded=False)


@compiled
def step_episode(rule: PassRule, state: Episode, before: int, phase: int, dt_s: float) -> Episode:
    """One tick. before, phase: last and present phase."""
    passes, left_s = state.passes, state.rest_left_s
    if phase == Phase.INSERTING and before != Phase.INSERTING:
        passes, left_s = passes + 1, rule.rest_s
    if left_s > 0.0:
        # The rest begins when the pass is over, and anew after a recovery that moved the catheter.
        left_s = max(left_s - dt_s, 0.0) if phase in RESTING else rule.rest_s
    return Episode(passes=passes, exceeded=state.exceeded, rest_left_s=left_s)


def pass_idle_time_episode(state: Episode, duration_s: float) -> Episode:
    """After a time in which the machine was parked."""
    return state._replace(rest_left_s=max(state.rest_left_s - duration_s, 0.0))


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
