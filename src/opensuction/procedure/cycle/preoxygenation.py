"""Pre-oxygenation before a pass: asked for, confirmed or skipped by a person, and on record.

The machine gives no oxygen and cannot see that somebody does. It asks at the start, and begins
nothing before there is an answer. Source: [AARC-2022], adults and children.
"""

from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import RESTING, Phase
from opensuction.kernel.requests import Requests

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
def step(
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


def pass_idle_time(answer: OxygenAnswer, duration_s: float) -> OxygenAnswer:
    """After a time in which the machine was parked and nobody answered."""
    left_s = answer.left_s - duration_s
    if not is_answered(answer) or left_s > 0.0:
        return answer._replace(left_s=max(left_s, 0.0))
    return OxygenAnswer(state=Preoxygenation.NOT_ASKED.value, left_s=0.0)
