"""Random events of a patient: coughs, breaths and moves, at a rate that may change all the time.

An exponential number is drawn once for each event, and the rate reduces it; when nothing is left
the event comes. So a rate that rises and falls gives the right number of events, and no random
number is drawn in between.

Coughs: some come by themselves, more while a catheter stimulates the airway.

A cough is a short effort to breathe in, then a push of the muscles of expiration. The tube keeps
the glottis open, so nothing is held back first: pressure and flow rise together.

Own breaths: the patient pulls now and then, at no time that the ventilator has agreed to.

The ventilator is triggered by none of them; it gives what its pressure control lets through.

Head and neck are moved now and then: the carina lies elsewhere, and the conduit bends otherwise.

Mostly between cycles: nobody turns a patient with a catheter inside, but for the patient.
"""

import math
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream


class Chance(NamedTuple):
    """Expected events until the next one, and the source of its random numbers."""

    left: float
    """Expected number of events until it comes."""
    share: float
    """A uniform number in (0, 1) for whoever asks what the coming event is like."""
    stream: RandomStream


@compiled
def draw(source: RandomStream) -> Chance:
    """The next event."""
    first, share, later = random_stream.uniform_pair(source)
    return Chance(left=-math.log(first), share=share, stream=later)


@compiled
def wear(chance: Chance, rate_per_s: float, dt_s: float) -> Chance:
    """The same after a step at a rate; the event has come where `is_due`."""
    return chance._replace(left=chance.left - rate_per_s * dt_s)


@compiled
def is_due(chance: Chance) -> bool:
    """True once the event has come; `draw` then gives the next one."""
    return chance.left <= 0.0


@compiled
def between(low: float, high: float, share: float) -> float:
    """The number that lies at a share of the way from one to another."""
    return low + (high - low) * share


INSPIRATION_S = 0.3
"""[assumed] How long the effort before the push lasts."""
INSPIRED_SHARE = 0.1
"""[assumed] Its pressure, as a share of the push's."""
WEAKEST, STRONGEST = 0.6, 1.4
"""[assumed] A patient's coughs lie between these shares of the usual one."""
NEVER_S = 1.0e9
"""Time since the last cough of somebody who has not coughed yet."""


class Cough(NamedTuple):
    """Coughs of one patient."""

    spontaneous_per_s: float
    provoked_per_s: float
    """More of them at the strongest stimulus; see
    `opensuction.twin.patient.patient_monitor.stimulus`."""
    peak_cmh2o: float
    """Highest pressure of the muscles in a usual cough."""
    push_s: float
    """How long they push."""
    refractory_s: float
    """Least time from the end of a cough to the next."""


class CoughState(NamedTuple):
    """The cough that is, or was last."""

    since_s: float
    """Time since it began."""
    peak_cmh2o: float
    coming: Chance


def silent(source: RandomStream) -> CoughState:
    """Nobody has coughed yet."""
    return CoughState(since_s=NEVER_S, peak_cmh2o=0.0, coming=draw(source))


@compiled
def pressure_cmh2o(cough: Cough, state: CoughState) -> float:
    """Pressure of the muscles on the lung; below 0 while the patient breathes in for it."""
    pushed_s = state.since_s - INSPIRATION_S
    if pushed_s >= cough.push_s:
        return 0.0
    if pushed_s < 0.0:
        wave = math.sin(math.pi * state.since_s / INSPIRATION_S)
        return -INSPIRED_SHARE * state.peak_cmh2o * wave * wave
    wave = math.sin(math.pi * pushed_s / cough.push_s)
    return state.peak_cmh2o * wave * wave


@compiled
def step(cough: Cough, state: CoughState, stimulus: float, dt_s: float) -> CoughState:
    """Advance by one step. stimulus: of the airway by the catheter, 0 to 1."""
    since_s = state.since_s + dt_s
    if since_s < INSPIRATION_S + cough.push_s + cough.refractory_s:
        return state._replace(since_s=since_s)
    rate_per_s = cough.spontaneous_per_s + cough.provoked_per_s * stimulus
    coming = wear(state.coming, rate_per_s, dt_s)
    if not is_due(coming):
        return state._replace(since_s=since_s, coming=coming)
    return CoughState(
        since_s=0.0,
        peak_cmh2o=cough.peak_cmh2o * between(WEAKEST, STRONGEST, coming.share),
        coming=draw(coming.stream),
    )


SOONEST, LATEST = 0.6, 1.4
"""[assumed] Time between two breaths lies between these shares of the mean."""
EFFORT_WEAKEST, EFFORT_STRONGEST = 0.6, 1.4
"""[assumed] Their pressures likewise."""
LONGEST_S = 1.0
"""[assumed] How long a breath pulls at most."""
LONGEST_SHARE = 0.4
"""[assumed] And at most this share of the mean time between two."""


class Effort(NamedTuple):
    """Breathing of one patient against the ventilator."""

    per_s: float
    """0 for nobody who breathes."""
    peak_cmh2o: float
    """Usual highest pull of the muscles, positive."""


class EffortState(NamedTuple):
    """The breath that is, or was last, and the next one."""

    left_s: float
    """Time until the next."""
    since_s: float
    """Time since the last began."""
    peak_cmh2o: float
    """Its pull."""
    coming: Chance
    """Only its random numbers are used: these breaths come nearly evenly."""


def silent_effort(effort: Effort, source: RandomStream) -> EffortState:
    """Between two breaths."""
    coming = draw(source)
    left_s = coming.share / effort.per_s if effort.per_s > 0.0 else 0.0
    return EffortState(left_s, since_s=LONGEST_S, peak_cmh2o=0.0, coming=coming)


@compiled
def pressure_cmh2o_effort(effort: Effort, state: EffortState) -> float:
    """Pressure of the muscles on the lung, at most 0."""
    if effort.per_s <= 0.0:
        return 0.0
    lasts_s = min(LONGEST_S, LONGEST_SHARE / effort.per_s)
    if state.since_s >= lasts_s:
        return 0.0
    return -state.peak_cmh2o * math.sin(math.pi * state.since_s / lasts_s)


@compiled
def step_effort(effort: Effort, state: EffortState, dt_s: float) -> EffortState:
    """Advance by one step."""
    if effort.per_s <= 0.0:
        return state
    left_s = state.left_s - dt_s
    if left_s > 0.0:
        return state._replace(left_s=left_s, since_s=state.since_s + dt_s)
    drawn = draw(state.coming.stream)
    # Two uniform numbers: the one that an event's time is drawn from, and the other.
    return EffortState(
        left_s=between(SOONEST, LATEST, math.exp(-drawn.left)) / effort.per_s,
        since_s=0.0,
        peak_cmh2o=effort.peak_cmh2o * between(EFFORT_WEAKEST, EFFORT_STRONGEST, drawn.share),
        coming=drawn,
    )


MOVING_S = 0.5
"""[assumed] Time constant of a move."""
FURTHEST = 10.0 / 3.0
"""Moves are cut off at this many standard deviations: 10 mm where one is 3."""


class Posture(NamedTuple):
    """Changes of one patient's posture: how often, and how far."""

    per_s: float
    """While no catheter is inside."""
    inside_share: float
    """Share of it while one is."""
    carina_mm: float
    """Standard deviation of the carina's depth over postures."""
    gap_ratio: float
    """Standard deviation of the conduit's gap over them, as a share of it."""


class PostureState(NamedTuple):
    """Posture of the patient at present."""

    carina_mm: float
    """How much deeper the carina is than at the start."""
    gap_ratio: float
    """Gap of the conduit over that at the start."""
    carina_goal_mm: float
    gap_goal_ratio: float
    coming: Chance


def settled(source: RandomStream) -> PostureState:
    """As at the start."""
    return PostureState(0.0, 1.0, 0.0, 1.0, draw(source))


@compiled
def _cut(deviations: float) -> float:
    return min(max(deviations, -FURTHEST), FURTHEST)


@compiled
def _move(posture: Posture, state: PostureState) -> PostureState:
    """The patient is moved: both goals are drawn anew, for a move does not add to the last."""
    depth, bend, later = random_stream.normal_pair(state.coming.stream)
    return state._replace(
        carina_goal_mm=posture.carina_mm * _cut(depth),
        gap_goal_ratio=1.0 + posture.gap_ratio * _cut(bend),
        coming=draw(later),
    )


@compiled
def step_posture(posture: Posture, state: PostureState, inside: bool, dt_s: float) -> PostureState:
    """Advance by one step. inside: the catheter's tip is."""
    rate_per_s = posture.per_s
    if inside:
        rate_per_s *= posture.inside_share
    state = state._replace(coming=wear(state.coming, rate_per_s, dt_s))
    if is_due(state.coming):
        state = _move(posture, state)
    share = dt_s / (MOVING_S + dt_s)
    return state._replace(
        carina_mm=state.carina_mm + share * (state.carina_goal_mm - state.carina_mm),
        gap_ratio=state.gap_ratio + share * (state.gap_goal_ratio - state.gap_ratio),
    )
