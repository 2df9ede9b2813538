"""A run of a search for harm: a fault at a place of its hazard's space, played and judged."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from opensuction.evidence.campaign import fault_placement, played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import JUDGED, Played
from opensuction.evidence.campaign.sound_machine import Kind, SoundMachine
from opensuction.evidence.safety_case.hazard_case import COMPENSATION
from opensuction.evidence.safety_case.hazard_claim import SET_UP, Hazard
from opensuction.kernel.errors import InputError
from opensuction.oracle import exposure, harm
from opensuction.oracle.harm import LEFT_INSIDE, Harm
from opensuction.simulation.injection import fault_allowance
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.twin.fault.fault_table import ROWS


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
def _sound(bed: Bed) -> Sound | None:
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


def run(hazard: Hazard, place: Place, beds: Sequence[Bed]) -> SearchedRun | None:
    """Play a place; None where it has no such instant or no cycle."""
    claim, bed = hazard.claims[place.claim], beds[place.bed]
    sound = _sound(bed)
    if sound is None:
        return None
    strength = fault_placement.find_strength(claim.fault, place.strength)
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
    ((one, at_s, _),) = played.run.faults
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
        any(each.at_s >= one.at.after_s for each in judged.told),
    )


def _find_share(found: Harm, sound: Harm) -> float:
    """Share of the way from the sound cycle's value to a bound; below 0 for a lesser value."""
    if found.is_broken:
        return math.inf
    way = found.limit - sound.worst
    share = (found.worst - sound.worst) / way if math.isfinite(way) and way != 0.0 else 0.0
    return 0.0 if math.isnan(share) else share
