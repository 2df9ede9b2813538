"""The runs of a hazard: fault, instant, strength, patient, seed; how each is prepared and run."""

import math
from functools import lru_cache

from opensuction.evidence.campaign import fault_placement, played_cycle, sound_machine
from opensuction.evidence.campaign.healthy_cycle import HealthyCycle
from opensuction.evidence.campaign.sound_machine import Kind, SoundMachine
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
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.twin.fault.fault_table import ROWS

COMPENSATION = "exact-inverse"
"""The command's own."""
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


@lru_cache(maxsize=4)
def _sound(kind: Kind, seed: int) -> SoundMachine:
    prepared = sound_machine.prepare(kind, seed, COMPENSATION)
    return sound_machine.play(prepared, played_cycle.share_room(COLUMNS))


def _place(case: HazardCase, healthy: HealthyCycle) -> HazardCase:
    """The case with the instant of its fault."""
    if case.span == SET_UP:
        return case
    if math.isnan(case.at.after_s):
        return case._replace(at=fault_placement.find_instant(healthy, case.span, case.share))
    return case._replace(at=FaultInstant(Phase[case.span.upper()], case.at.after_s))


def run(case: HazardCase) -> HazardResult:
    """Run a case and hold it against its claim."""
    kind, room = Kind(case.patient, case.approach), played_cycle.share_room(COLUMNS)
    one = Injection(case.claim.fault, case.at, case.strength)
    if ROWS[one.fault].is_planned:
        try:
            prepared = sound_machine.prepare(kind, case.seed, COMPENSATION, planned=one)
        except InputError as refusal:
            return hazard_result.refused(case, str(refusal))
        sound = _sound(kind, case.seed)
        played = played_cycle.play_planned(prepared, one, room, whole=True)
    else:
        sound = _sound(kind, case.seed)
        case = _place(case, sound.healthy)
        one = one._replace(at=case.at)
        played = played_cycle.play_faulty(sound, (one,), case.seed, room, whole=True)
    return hazard_result.judge(case, played, sound.healthy)
