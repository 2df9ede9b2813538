"""Passes at one patient: how many may follow each other, and the rest between them.

A pass is an insertion, however it ends. Passes follow each other, however far apart, until a person
says that they have looked at the patient: a machine that goes on by itself would hide a blocked
tube, or an airway that bleeds (docs/decisions/0017).
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import RESTING, Phase


class PassRule(NamedTuple):
    """Rule for passes on one patient; `opensuction.procedure.planning.pass_rule` has it by age."""

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
def step(rule: PassRule, state: Episode, before: int, phase: int, dt_s: float) -> Episode:
    """One tick. before, phase: last and present phase."""
    passes, left_s = state.passes, state.rest_left_s
    if phase == Phase.INSERTING and before != Phase.INSERTING:
        passes, left_s = passes + 1, rule.rest_s
    if left_s > 0.0:
        # The rest begins when the pass is over, and anew after a recovery that moved the catheter.
        left_s = max(left_s - dt_s, 0.0) if phase in RESTING else rule.rest_s
    return Episode(passes=passes, exceeded=state.exceeded, rest_left_s=left_s)


def pass_idle_time(state: Episode, duration_s: float) -> Episode:
    """After a time in which the machine was parked."""
    return state._replace(rest_left_s=max(state.rest_left_s - duration_s, 0.0))
