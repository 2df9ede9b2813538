"""Spontaneous behaviour of a patient as a whole: one pure step at the bedside's 100 Hz.

A quiet patient does nothing: `is_lively` is off, and the bedside leaves all of this out.
"""

from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.twin.behaviour import artefact, cough, effort, posture
from opensuction.twin.behaviour.artefact import Artefact, ArtefactState
from opensuction.twin.behaviour.clearance import Clearance
from opensuction.twin.behaviour.cough import Cough, CoughState
from opensuction.twin.behaviour.effort import Effort, EffortState
from opensuction.twin.behaviour.posture import Posture, PostureState

BEHAVIOUR_PURPOSE = 5_000_000
"""Streams from here on are what a patient does in run 0, 1, 2, ..."""
BLOCK = 1 << 32
"""Blocks of random numbers between one kind of event and the next, so that none changes another."""


class Behaviour(NamedTuple):
    """Behaviour of one patient of their own accord."""

    is_lively: bool
    """Whether they do any of it."""
    cough: Cough
    effort: Effort
    posture: Posture
    artefact: Artefact
    clearance: Clearance
    leak_ml_per_s_per_cmh2o: float
    """Gas that leaves beside the tube, for each cmH2O in the lung."""
    perfusion_ratio: float
    """Blood flow that closed lung keeps, over the usual one."""
    shortening_mm_per_cmh2o: float
    """Way of the carina towards the tube for each cmH2O by which the muscles push."""


class BehaviourState(NamedTuple):
    """Behaviour of a patient at present."""

    cough: CoughState
    effort: EffortState
    posture: PostureState
    artefact: ArtefactState


class Around(NamedTuple):
    """Stimulus that a patient feels, and the saturation that the oximeter would show."""

    stimulus: float
    """Of the airway by the catheter, 0 to 1; see `opensuction.twin.patient.heart`."""
    is_inside: bool
    """Whether the catheter's tip is inside."""
    spo2_percent: float


def begin(behaviour: Behaviour, seed: int, run: int) -> BehaviourState:
    """Nothing has happened yet. seed: the patient's. run: another one brings other events."""
    source = random_stream.stream(seed, BEHAVIOUR_PURPOSE + run)
    first, second, third, fourth = (source._replace(counter=BLOCK * i) for i in range(4))
    return BehaviourState(
        cough=cough.silent(first),
        effort=effort.silent(behaviour.effort, second),
        posture=posture.settled(third),
        artefact=artefact.clear(fourth),
    )


@compiled
def muscle_cmh2o(behaviour: Behaviour, state: BehaviourState) -> float:
    """Pressure of the muscles on the lung: coughs push, breaths pull. Who coughs breathes not."""
    pushed = cough.pressure_cmh2o(behaviour.cough, state.cough)
    if pushed != 0.0:
        return pushed
    return effort.pressure_cmh2o(behaviour.effort, state.effort)


@compiled
def carina_shift_mm(behaviour: Behaviour, state: BehaviourState) -> float:
    """Depth of the carina beyond that at the start: by posture, and less in a cough."""
    pushed = muscle_cmh2o(behaviour, state)
    return state.posture.carina_mm - behaviour.shortening_mm_per_cmh2o * pushed


@compiled
def step(
    behaviour: Behaviour, state: BehaviourState, around: Around, dt_s: float
) -> BehaviourState:
    """Advance by one step."""
    coughing = cough.step(behaviour.cough, state.cough, around.stimulus, dt_s)
    return BehaviourState(
        cough=coughing,
        effort=effort.step(behaviour.effort, state.effort, dt_s),
        posture=posture.step(behaviour.posture, state.posture, around.is_inside, dt_s),
        artefact=artefact.step(
            behaviour.artefact, state.artefact, coughing.since_s, around.spo2_percent, dt_s
        ),
    )
