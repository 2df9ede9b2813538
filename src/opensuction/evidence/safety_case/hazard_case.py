"""The runs of a hazard: fault, instant, strength, patient, seed; how each is prepared and run."""

import math
from functools import lru_cache

from opensuction.evidence import healthy_cycle
from opensuction.evidence.healthy_cycle import HealthyCycle
from opensuction.evidence.safety_case import hazard_claim, hazard_result
from opensuction.evidence.safety_case.hazard_claim import (
    PATIENTS,
    PHASES,
    SET_UP,
    Hazard,
    HazardClaim,
)
from opensuction.evidence.safety_case.hazard_result import COLUMNS, HazardCase, HazardResult
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.simulation.injection.injection import Injected
from opensuction.simulation.injection.row_buffer import RowBuffer
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

COMPENSATION = "exact-inverse"
"""The command's own."""
WATCHED_S = 60.0
"""How long the machine and the patient are watched once it rests: no bound is longer."""
STRATA = 5
"""Parts of a span; as many seeds see each of them, on every patient and by every approach."""
KINDS = tuple((patient, approach) for patient in PATIENTS for approach in PHASES)
"""Patients and approaches: within its part of the span each has an instant of its own."""


def find_share(patient: str, approach: str, seed: int, row: int) -> float:
    """Place in its span at which the fault of a run comes, 0 to 1, both edges included.

    A Latin square: every patient and approach sees each part of the span with one of five seeds,
    and each seed sees every part with some of them; so do the rows of a table.
    """
    kind = KINDS.index((patient, approach))
    part = (seed + kind + row) % STRATA
    return (len(KINDS) * part + kind) / (len(KINDS) * STRATA - 1)


def find_strengths(
    claim: HazardClaim, patient: str, approach: str, seed: int, runs: int
) -> list[float]:
    """Strengths that a fault has in the runs of a patient by an approach with a seed.

    All of them; where there are so many runs that each strength meets each part of the span all
    the same, they take turns. runs: of one strength in one span; 0 with too few seeds for that.
    """
    strengths = claim.strengths or [ROWS[claim.fault].default_strength]
    if runs < STRATA * len(strengths):
        return strengths
    return [strengths[(seed + 2 * KINDS.index((patient, approach))) % len(strengths)]]


def _of_claim(
    one: Hazard, row: int, claim: HazardClaim, seeds: tuple[int, ...]
) -> list[HazardCase]:
    found = []
    kinds = [
        (patient, approach)
        for patient, approach in KINDS
        if patient in claim.patients and approach in claim.approaches
    ]
    runs = len(kinds) * len(seeds) if len(seeds) >= STRATA else 0
    for patient, approach in kinds:
        for number, span in enumerate(hazard_claim.spans_of(claim, approach)):
            for after_s in claim.after_s or [math.nan]:
                found += [
                    HazardCase(
                        hazard=one.row.id,
                        claim=claim,
                        strength=strength,
                        span=span,
                        at=AT_START if span == SET_UP else FaultInstant(None, after_s),
                        share=find_share(patient, approach, seed, row + number),
                        patient=patient,
                        approach=approach,
                        seed=seed,
                    )
                    for seed in seeds
                    for strength in find_strengths(claim, patient, approach, seed, runs)
                ]
    return found


def cases(one: Hazard, seeds: tuple[int, ...]) -> list[HazardCase]:
    """Every run of a hazard."""
    found = []
    for row, claim in enumerate(one.claims):
        found += _of_claim(one, row, claim, seeds)
    return found


def write(fault: Fault, strength: float) -> str:
    """The fault of a set-up as a person writes it."""
    return fault.title if ROWS[fault].strength is None else f"{fault.title}={strength!r}"


@lru_cache(maxsize=4)
def prepare(approach: str, patient: str, seed: int, set_up: tuple[str, ...]) -> Prepared:
    """A cycle ready to run; raises InputError where it is refused."""
    rig = RigChoice(patient=patient, seed=seed)
    choice = CycleChoice(rig, approach=approach, compensation=COMPENSATION, faults=set_up)
    return cycle_run.prepare(resolution.resolve(choice))


@lru_cache(maxsize=4)
def _healthy(approach: str, patient: str, seed: int) -> HealthyCycle:
    return healthy_cycle.play(prepare(approach, patient, seed, ()))


@lru_cache(maxsize=1)
def _room() -> RowBuffer:
    return injection.make_room(WATCHED_S, names=COLUMNS)


def _place(case: HazardCase, healthy: HealthyCycle) -> HazardCase:
    """The case with the instant of its fault."""
    if case.span == SET_UP:
        return case
    if math.isnan(case.at.after_s):
        return case._replace(at=healthy_cycle.find_instant(healthy, case.span, case.share))
    return case._replace(at=FaultInstant(Phase[case.span.upper()], case.at.after_s))


def run(case: HazardCase) -> HazardResult:
    """Run a case and hold it against its claim."""
    claim = case.claim
    planned = (write(claim.fault, case.strength),) if ROWS[claim.fault].is_planned else ()
    try:
        prepared = prepare(case.approach, case.patient, case.seed, planned)
    except InputError as refusal:
        return hazard_result.refused(case, str(refusal))
    healthy = _healthy(case.approach, case.patient, case.seed)
    case = _place(case, healthy)
    one = Injection(claim.fault, case.at, case.strength)
    later = () if planned else (one,)
    done = injection.run(
        prepared.loop, prepared.start, later, after_s=WATCHED_S, seed=case.seed, room=_room()
    )
    found = done.faults[0] if later else Injected(one, 0.0, None)
    return hazard_result.judge(case, prepared, done.columns, found, healthy)
