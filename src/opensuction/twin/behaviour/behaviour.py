"""Spontaneous behaviour of a patient as a whole: one pure step at the bedside's 100 Hz.

A quiet patient does nothing: `is_lively` is off, and the bedside leaves all of this out.

Artefacts of the oximeter: a value that is too low, an old value, or none.

Motion and cold fingers cause them: they come by chance, and more often when the patient coughs. The
true saturation does not change.

Spontaneous transport of secretions: cilia and coughs carry them up, some adhere, some lie deep.

Loose ones lie in the trachea's bins, where suction can reach them. Adherent ones cling to its wall
from the tube to the carina and come loose slowly. Deep ones lie below the carina and come up with
the others. A cough brings some of the topmost out through the tube. Their total is conserved.
"""

from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Monitor
from opensuction.kernel.random_stream import RandomStream
from opensuction.twin.airway.airway import BIN_MM, Bins
from opensuction.twin.behaviour import spontaneous_event
from opensuction.twin.behaviour.spontaneous_event import (
    Chance,
    Cough,
    CoughState,
    Effort,
    EffortState,
    Posture,
    PostureState,
)

DEEP_MM = 50.0
"""[assumed] Way from where deep secretions lie to the carina."""
LEAST_RESISTANCE, MOST_RESISTANCE = 0.5, 4.0
"""[assumed] Bounds of what secretions make of the resistance."""


class Clearance(NamedTuple):
    """Clearance of one patient's secretions by cilia and coughs."""

    cilia_mm_per_s: float
    """Speed at which cilia carry them."""
    cough_mm_per_s_per_cmh2o: float
    """Speed for each cmH2O by which the muscles push."""
    expelled_share: float
    """Share of what a cough drives out of the topmost bin that leaves through the tube."""
    adherent_share: float
    """Share of the secretions that stick."""
    loosening_s: float
    """Time constant of their coming loose."""
    deep_share: float
    """Share of the secretions that lie below the carina."""
    resistance_share: float
    """Share of the airways' resistance that goes when all of the usual secretions are gone."""
    usual_ml: float
    """Secretions with which the resistance is as stated, in mL."""


class Store(NamedTuple):
    """Secretions that suction does not reach, in mL."""

    adherent_ml: float
    """On the whole wall: a second array of bins would cost every tick of the machine."""
    deep_ml: float
    expelled_ml: float
    """Coughed out so far."""


def part(clearance: Clearance, secretion_ml: Bins) -> tuple[Bins, Store]:
    """Secretions as they lie at first, parted into loose ones and the others."""
    loose_share = 1.0 - clearance.adherent_share - clearance.deep_share
    store = Store(
        adherent_ml=clearance.adherent_share * float(secretion_ml.sum()),
        deep_ml=clearance.deep_share * float(secretion_ml.sum()),
        expelled_ml=0.0,
    )
    return loose_share * secretion_ml, store


EMPTY = Store(adherent_ml=0.0, deep_ml=0.0, expelled_ml=0.0)
"""Nothing that suction does not reach."""


@compiled
def resistance_ratio(clearance: Clearance, loose_ml: Bins, store: Store) -> float:
    """Resistance of the airways over the stated one: it grows with what has gathered."""
    gathered_ml = store.adherent_ml + store.deep_ml
    for i in range(loose_ml.size):
        gathered_ml += loose_ml[i]
    ratio = 1.0 + clearance.resistance_share * (gathered_ml / clearance.usual_ml - 1.0)
    return min(max(ratio, LEAST_RESISTANCE), MOST_RESISTANCE)


@compiled
def _carry(clearance: Clearance, loose_ml: Bins, muscle_cmh2o: float, dt_s: float) -> float:
    """Move what is loose upwards by one step, upwind; returns what leaves through the tube.

    loose_ml: written. In the topmost bin cilia end: only a cough takes anything further.
    """
    coughed_mm_per_s = clearance.cough_mm_per_s_per_cmh2o * max(muscle_cmh2o, 0.0)
    coughed = min(coughed_mm_per_s * dt_s / BIN_MM, 1.0)
    share = min((clearance.cilia_mm_per_s + coughed_mm_per_s) * dt_s / BIN_MM, 1.0)
    expelled_ml = float(clearance.expelled_share * coughed * loose_ml[0])
    loose_ml[0] -= expelled_ml
    for i in range(1, loose_ml.size):
        moved_ml = share * loose_ml[i]
        loose_ml[i] -= moved_ml
        loose_ml[i - 1] += moved_ml
    return expelled_ml


@compiled
def step_clearance(
    clearance: Clearance,
    loose_ml: Bins,
    store: Store,
    produced_ml_per_s: Bins,
    carina_mm: float,
    muscle_cmh2o: float,
    dt_s: float,
) -> tuple[Bins, Store]:
    """Loose secretions and the others after a step that `secretion.step` has made already.

    produced_ml_per_s: what that added to the loose ones; shares of it stick or lie too deep. The
    arrays given stay as they are.
    """
    loose, made_ml = loose_ml.copy(), 0.0
    hidden_share = clearance.adherent_share + clearance.deep_share
    for i in range(loose.size):
        made_ml += produced_ml_per_s[i] * dt_s
        loose[i] -= hidden_share * produced_ml_per_s[i] * dt_s
    freed_ml = dt_s / (clearance.loosening_s + dt_s) * store.adherent_ml
    lowest = min(int(carina_mm / BIN_MM), loose.size - 1)
    for i in range(lowest + 1):
        loose[i] += freed_ml / (lowest + 1)
    deep_ml = store.deep_ml + clearance.deep_share * made_ml
    expelled_ml = _carry(clearance, loose, muscle_cmh2o, dt_s)
    pushed_mm_per_s = clearance.cough_mm_per_s_per_cmh2o * max(muscle_cmh2o, 0.0)
    risen_ml = min((clearance.cilia_mm_per_s + pushed_mm_per_s) * dt_s / DEEP_MM, 1.0) * deep_ml
    loose[lowest] += risen_ml
    return loose, Store(
        adherent_ml=store.adherent_ml + clearance.adherent_share * made_ml - freed_ml,
        deep_ml=deep_ml - risen_ml,
        expelled_ml=store.expelled_ml + expelled_ml,
    )


SHORTEST_S, LONGEST_S = 2.0, 12.0
"""[assumed] How long one lasts."""
LARGEST_PERCENT = 15.0
"""[assumed] Reads by so much too low at most."""
LOW_SHARE, FROZEN_SHARE = 0.5, 0.25
"""[assumed] So many read too low, so many stand still; the others are missing."""
RESTLESS_S = 5.0
"""[assumed] How long after the start of a cough a finger moves."""


class Artefact(NamedTuple):
    """Rate of artefacts of one patient's oximeter."""

    per_s: float
    cough_ratio: float
    """Times as often during a cough."""


class ArtefactState(NamedTuple):
    """Artefact of the present, if there is any."""

    left_s: float
    """For so long still; at most 0 where nothing is."""
    low_percent: float
    """Reads by so much too low."""
    is_frozen: bool
    frozen_percent: float
    """What it then shows."""
    is_missing: bool
    coming: Chance


def clear(source: RandomStream) -> ArtefactState:
    """Nothing is wrong."""
    return ArtefactState(0.0, 0.0, False, 0.0, False, spontaneous_event.draw(source))


@compiled
def _begin(state: ArtefactState, spo2_percent: float) -> ArtefactState:
    kind = state.coming.share
    lasts, depth, later = random_stream.uniform_pair(state.coming.stream)
    is_low = kind < LOW_SHARE
    is_frozen = LOW_SHARE <= kind < LOW_SHARE + FROZEN_SHARE
    low_percent = 0.0
    if is_low:
        low_percent = LARGEST_PERCENT * depth
    return ArtefactState(
        left_s=spontaneous_event.between(SHORTEST_S, LONGEST_S, lasts),
        low_percent=low_percent,
        is_frozen=is_frozen,
        frozen_percent=spo2_percent,
        is_missing=not (is_low or is_frozen),
        coming=spontaneous_event.draw(later),
    )


@compiled
def step_artefact(
    artefact: Artefact,
    state: ArtefactState,
    coughed_since_s: float,
    spo2_percent: float,
    dt_s: float,
) -> ArtefactState:
    """Advance by one step.

    coughed_since_s: time since the start of the last cough. spo2_percent: what is right.
    """
    if state.left_s > 0.0:
        return state._replace(left_s=state.left_s - dt_s)
    rate_per_s = artefact.per_s
    if coughed_since_s < RESTLESS_S:
        rate_per_s *= artefact.cough_ratio
    state = state._replace(coming=spontaneous_event.wear(state.coming, rate_per_s, dt_s))
    if spontaneous_event.is_due(state.coming):
        return _begin(state, spo2_percent)
    return state


@compiled
def distort(state: ArtefactState, monitor: Monitor) -> Monitor:
    """Distort the monitor's values by an artefact; a value that is missing anyway stays so."""
    if state.left_s <= 0.0 or not monitor.spo2_valid:
        return monitor
    if state.is_missing:
        return monitor._replace(spo2_percent=0.0, spo2_valid=False)
    if state.is_frozen:
        return monitor._replace(spo2_percent=state.frozen_percent)
    return monitor._replace(spo2_percent=max(monitor.spo2_percent - state.low_percent, 0.0))


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
    """Of the airway by the catheter, 0 to 1; see `opensuction.twin.patient.patient_monitor`."""
    is_inside: bool
    """Whether the catheter's tip is inside."""
    spo2_percent: float


def begin(behaviour: Behaviour, seed: int, run: int) -> BehaviourState:
    """Nothing has happened yet. seed: the patient's. run: another one brings other events."""
    source = random_stream.stream(seed, BEHAVIOUR_PURPOSE + run)
    first, second, third, fourth = (source._replace(counter=BLOCK * i) for i in range(4))
    return BehaviourState(
        cough=spontaneous_event.silent(first),
        effort=spontaneous_event.silent_effort(behaviour.effort, second),
        posture=spontaneous_event.settled(third),
        artefact=clear(fourth),
    )


@compiled
def muscle_cmh2o(behaviour: Behaviour, state: BehaviourState) -> float:
    """Pressure of the muscles on the lung: coughs push, breaths pull. Who coughs breathes not."""
    pushed = spontaneous_event.pressure_cmh2o(behaviour.cough, state.cough)
    if pushed != 0.0:
        return pushed
    return spontaneous_event.pressure_cmh2o_effort(behaviour.effort, state.effort)


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
    coughing = spontaneous_event.step(behaviour.cough, state.cough, around.stimulus, dt_s)
    return BehaviourState(
        cough=coughing,
        effort=spontaneous_event.step_effort(behaviour.effort, state.effort, dt_s),
        posture=spontaneous_event.step_posture(
            behaviour.posture, state.posture, around.is_inside, dt_s
        ),
        artefact=step_artefact(
            behaviour.artefact, state.artefact, coughing.since_s, around.spo2_percent, dt_s
        ),
    )
