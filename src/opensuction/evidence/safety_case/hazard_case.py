"""The runs of a hazard: fault, instant, strength, patient, seed; how each is prepared and run.

A run of a search for harm: a fault at a place of its hazard's space, played and judged.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import JUDGED, Played
from opensuction.evidence.campaign.sound_machine import HealthyCycle, Kind, SoundMachine
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
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure, harm
from opensuction.oracle.harm import LEFT_INSIDE, Harm
from opensuction.simulation.injection import fault_allowance
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
        return case._replace(at=sound_machine.find_instant(healthy, case.span, case.share))
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


class Bed(NamedTuple):
    """A machine and a patient, by which they are drawn."""

    kind: Kind
    seed: int
    spread: float = 1.0
    """How many times as far from the nominal ones as usual."""


class Place(NamedTuple):
    """Place of a run in the space of a hazard."""

    claim: int
    """Number of the fault in the hazard's row."""
    bed: int
    phase: str
    """Or before the start."""
    within: float
    """Share of the phase's duration in the sound cycle, 0 to less than 1."""
    off_ms: int
    """From there."""
    strength: float
    """Share of the fault's range, 0 to 1."""


class SearchedRun(NamedTuple):
    """Result of a run."""

    bed: Bed
    injection: Injection
    nearest: Harm
    """The bound that it came nearest to, with what the fault makes unavoidable added."""
    share: float
    """How much of the way from the sound cycle's value to this bound it went, infinite where
    any bound was broken."""
    breaches: tuple[str, ...]
    """Bounds of the patient and of the command side that were broken."""
    unavoidable: tuple[str, ...]
    """Bounds of time that were broken and that no withdrawal could have kept."""
    told: bool
    """Whether people were told of anything from the fault on."""

    @property
    def title(self) -> str:
        """Fault, instant, strength, patient and seed, as the command line writes them."""
        one, kind = self.injection, self.bed.kind
        strength = "" if ROWS[one.fault].strength is None else f"={one.strength:g}"
        at = "" if ROWS[one.fault].is_setup else one.at.title
        fault = f"{one.fault.title}{at}{strength}"
        spread = "" if self.bed.spread == 1.0 else f", spread {self.bed.spread:g}"
        return f"{fault}, {kind.patient} by {kind.approach}, seed {self.bed.seed}{spread}"


class Sound(NamedTuple):
    """A machine without the fault."""

    machine: SoundMachine
    bounds: tuple[Harm, ...]
    """How near its own cycle comes to each."""


@lru_cache(maxsize=64)
def _sound_run(bed: Bed) -> Sound | None:
    """The cycle without a fault; None where the machine cannot do it."""
    room = played_cycle.share_room(JUDGED)
    try:
        prepared = sound_machine.prepare(bed.kind, bed.seed, COMPENSATION, spread=bed.spread)
        machine = sound_machine.play(prepared, room)
    except InputError:
        return None
    return Sound(machine, _measure(played_cycle.play_sound(prepared, room)))


def _measure(played: Played) -> tuple[Harm, ...]:
    prepared = played.prepared
    machine = prepared.rig.machine
    borne = played.alone.add_to(exposure.measure(machine, played.run.columns))
    return harm.measure(machine, borne, prepared.loop.controller.limits.cap_mm)


def run_searched(hazard: Hazard, place: Place, beds: Sequence[Bed]) -> SearchedRun | None:
    """Play a place; None where it has no such instant or no cycle."""
    claim, bed = hazard.claims[place.claim], beds[place.bed]
    sound = _sound_run(bed)
    if sound is None:
        return None
    strength = sound_machine.find_strength(claim.fault, place.strength)
    one = Injection(claim.fault, AT_START, strength)
    room = played_cycle.share_room(JUDGED)
    if ROWS[one.fault].is_planned:
        try:
            prepared = sound_machine.prepare(
                bed.kind, bed.seed, COMPENSATION, planned=one, spread=bed.spread
            )
        except InputError:
            return None
        return _judge(bed, sound, played_cycle.play_planned(prepared, one, room))
    if place.phase != SET_UP:
        spans = sound.machine.healthy.spans
        if place.phase not in spans:
            return None
        begin_s, end_s = spans[place.phase]
        at_s = begin_s + place.within * (end_s - begin_s) + 0.001 * place.off_ms
        at_s = round(at_s, 3)
        if at_s <= 0.0:
            return None
        one = one._replace(at=FaultInstant(None, at_s))
    return _judge(bed, sound, played_cycle.play_faulty(sound.machine, (one,), bed.seed, room))


def _judge(bed: Bed, sound: Sound, played: Played) -> SearchedRun:
    """Hold a run against every invariant and bound, with the allowances of trials."""
    ((one, at_s, *_),) = played.run.faults
    judged = played.judge()
    bounds = fault_allowance.raise_limits(_measure(played), () if math.isnan(at_s) else (one,))
    broken = {each.name for each in judged.breaches}
    excused = {each.name for each in judged.harm} - broken
    breaches = (
        *(each.invariant for each in played.list_command_breaches()),
        *(each.name for each in judged.breaches),
    )
    shares = {
        each: _find_share(each, before)
        for each, before in zip(bounds, sound.bounds, strict=True)
        if each.name not in excused and (each.is_broken or each.name != LEFT_INSIDE)
    }
    nearest = max(shares, key=lambda each: shares[each])
    return SearchedRun(
        bed,
        one,
        nearest,
        math.inf if breaches else shares[nearest],
        breaches,
        tuple(each.name for each in judged.unavoidable),
        any(each.at_s >= one.at.after_s for each in judged.told),
    )


def _find_share(found: Harm, sound: Harm) -> float:
    """Share of the way from the sound cycle's value to a bound; below 0 for a lesser value."""
    if found.is_broken:
        return math.inf
    way = found.limit - sound.worst
    share = (found.worst - sound.worst) / way if math.isfinite(way) and way != 0.0 else 0.0
    return 0.0 if math.isnan(share) else share
