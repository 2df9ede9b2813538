"""A search for harm: the instant, strength, machine and patient at which a hazard does most.

The rows of the table ask at drawn instants. This asks where a detector may be blind: about the
edges of phases, at the ends of a fault's strengths, and then near whatever was worst. An evolution
strategy: a first part of the runs is spread over all of it, each of the others changes a value or
two of one of the worst so far.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeVar

from opensuction.evidence.safety_case.hazard_claim import PHASES, Hazard, HazardClaim
from opensuction.evidence.trial import draw, judged_cycle, sound_machine
from opensuction.evidence.trial.cohort import Kind
from opensuction.evidence.trial.sound_machine import SoundMachine
from opensuction.kernel import random_stream
from opensuction.kernel.errors import InputError
from opensuction.oracle import harm
from opensuction.oracle.harm import Harm
from opensuction.simulation.injection import fault_allowance, invariant, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.room import Room
from opensuction.twin.fault.fault_table import ROWS

COMPENSATION = "exact-inverse"
"""As the rows of the table have it."""
EDGE_MS, STEP_MS = 100, 5
"""How far about the begin of a phase instants are asked for, and in which steps."""
OFFSETS_MS = tuple(range(-EDGE_MS, EDGE_MS + 1, STEP_MS))
SPREAD_SHARE = 0.4
"""Of the runs: spread over everything before anything is followed."""
ENDS = (1.0, 0.0)
"""Ends of a range of strengths; half of the spread runs have one."""
KEPT = 8
"""Worst ones that are followed."""
NEAR = 0.1
"""Standard deviation of a step of the strength, as a share of its range."""
CHANGED_TWICE = 0.3
"""How often a second value is changed, too."""
PURPOSE = 73
"""Number of the noise stream of searches."""

Choice = TypeVar("Choice")


class Bed(NamedTuple):
    """A machine and a patient, by which they are drawn."""

    kind: Kind
    seed: int


class Place(NamedTuple):
    """Where in the space of a hazard a run is."""

    claim: int
    """Number of the fault in the hazard's row."""
    bed: int
    phase: str
    off_ms: int
    """From the phase's begin."""
    strength: float
    """Share of the fault's range, 0 to 1."""


class SearchedRun(NamedTuple):
    """What a run came to."""

    bed: Bed
    injection: Injection
    nearest: Harm
    """The bound that it came nearest to, with what the fault makes unavoidable added."""
    breaches: tuple[str, ...]
    """Bounds of the patient and of the command side that were broken."""
    told: bool
    """Whether people were told of anything from the fault on."""

    @property
    def title(self) -> str:
        """Fault, instant, strength, patient and seed, as the command line writes them."""
        one, kind = self.injection, self.bed.kind
        strength = "" if ROWS[one.fault].strength is None else f"={one.strength:g}"
        fault = f"{one.fault.title}{one.at.title}{strength}"
        return f"{fault}, {kind.patient} by {kind.approach}, seed {self.bed.seed}"

    @property
    def share(self) -> float:
        """How bad it is: of the nearest bound how much was borne, infinite where one broke."""
        return math.inf if self.breaches else self.nearest.share


class HarmSearch(NamedTuple):
    """What a search came to."""

    runs: int
    worst: SearchedRun | None
    """None where no run was possible."""
    broken: tuple[SearchedRun, ...]
    """Runs that broke a bound."""


NOT_SEARCHED = HarmSearch(0, None, ())


class SearchTask(NamedTuple):
    """The search of one hazard, for one process."""

    hazard: Hazard
    runs: int
    seeds: tuple[int, ...]


Play = Callable[[Hazard, Place, Sequence[Bed]], SearchedRun | None]
"""What comes of a hazard's place, at these beds; None where that has no such instant or cycle."""


def beds_of(hazard: Hazard, seeds: Sequence[int]) -> list[Bed]:
    """Every patient by every approach that any fault of a hazard is claimed for."""
    kinds = {
        Kind(patient, approach): None
        for claim in hazard.claims
        for patient in claim.patients
        for approach in claim.approaches
    }
    return [Bed(kind, seed) for seed in seeds for kind in kinds]


@lru_cache(maxsize=1)
def _room() -> Room:
    return judged_cycle.make_room()


@lru_cache(maxsize=32)
def _sound(bed: Bed) -> SoundMachine | None:
    """The cycle without a fault; None where the machine cannot do it."""
    try:
        return sound_machine.play(sound_machine.prepare(bed.kind, bed.seed, COMPENSATION), _room())
    except InputError:
        return None


def run(hazard: Hazard, place: Place, beds: Sequence[Bed]) -> SearchedRun | None:
    """Play a place; None where it has no such instant or no cycle."""
    claim, bed = hazard.claims[place.claim], beds[place.bed]
    machine = _sound(bed)
    if machine is None or place.phase not in machine.healthy.spans:
        return None
    at_s = round(machine.healthy.spans[place.phase][0] + 0.001 * place.off_ms, 3)
    if at_s <= 0.0:
        return None
    strength = draw.find_strength(claim.fault, place.strength)
    one = Injection(claim.fault, FaultInstant(None, at_s), strength)
    played = judged_cycle.play_faulty(machine, (one,), bed.seed, _room())
    return _judge(claim, bed, machine, one, played)


def _judge(
    claim: HazardClaim,
    bed: Bed,
    machine: SoundMachine,
    one: Injection,
    played: judged_cycle.Played,
) -> SearchedRun:
    built, settings = machine.prepared.rig.machine, machine.prepared.loop.controller
    cap_mm, found, strictly = settings.limits.cap_mm, played.run, ()
    judged = run_judgement.judge(
        built, cap_mm, found.columns, found.faults, strictly=strictly, alone=played.alone
    )
    came = [each.injection for each in found.faults if not math.isnan(each.at_s)]
    bounds = fault_allowance.raise_limits(harm.measure(built, judged.borne, cap_mm), came, strictly)
    broken = {each.name for each in judged.breaches}
    excused = {each.name for each in judged.harm} - broken
    commands = invariant.command_side(found.sent, settings)
    return SearchedRun(
        bed,
        one,
        max((each for each in bounds if each.name not in excused), key=_share),
        (*(each.invariant for each in commands), *(each.name for each in judged.breaches)),
        any(each.at_s >= one.at.after_s for each in judged.told),
    )


def _share(bound: Harm) -> float:
    return -1.0 if math.isnan(bound.share) else bound.share


class _Chance:
    """Random numbers, the same for the same seed."""

    def __init__(self, seed: int) -> None:
        self._source = random_stream.stream(seed, PURPOSE)

    def uniform(self) -> float:
        """From 0 to less than 1."""
        first, _, self._source = random_stream.uniform_pair(self._source)
        return float(first)

    def normal(self) -> float:
        """Of mean 0 and deviation 1."""
        first, _, self._source = random_stream.normal_pair(self._source)
        return float(first)

    def one_of(self, several: Sequence[Choice]) -> Choice:
        """Any of them, as often as any other."""
        return several[int(self.uniform() * len(several))]


class _Space:
    """The places of a hazard, and how one is come by."""

    def __init__(self, hazard: Hazard, beds: Sequence[Bed], seed: int) -> None:
        self._chance = _Chance(seed)
        self._spots = [
            (claim, bed, phase)
            for claim, one in enumerate(hazard.claims)
            if not ROWS[one.fault].is_setup
            for bed, lies in enumerate(beds)
            if lies.kind.patient in one.patients and lies.kind.approach in one.approaches
            for phase in PHASES[lies.kind.approach]
        ]
        self._order = sorted(self._spots, key=lambda _: self._chance.uniform())

    @property
    def is_empty(self) -> bool:
        """Whether nothing can come to a machine that runs."""
        return not self._spots

    def spread(self, number: int) -> Place:
        """One of those that are spread over everything."""
        spot = self._order[number % len(self._order)]
        strength = ENDS[number // 2 % 2] if number % 2 else self._chance.uniform()
        return Place(*spot, self._chance.one_of(OFFSETS_MS), strength)

    def follow(self, worst: Sequence[Place]) -> Place:
        """One near one of the worst: the first is taken twice as often as the second, and so on."""
        at = 0
        while at < len(worst) - 1 and self._chance.uniform() < 0.5:
            at += 1
        place = self._change(worst[at])
        return self._change(place) if self._chance.uniform() < CHANGED_TWICE else place

    def _change(self, place: Place) -> Place:
        what = self._chance.one_of(("instant", "strength", "phase", "bed"))
        if what == "instant":
            off_ms = place.off_ms + STEP_MS * self._chance.one_of((-4, -2, -1, 1, 2, 4))
            return place._replace(off_ms=min(max(off_ms, -EDGE_MS), EDGE_MS))
        if what == "strength":
            strength = place.strength + NEAR * self._chance.normal()
            return place._replace(strength=min(max(strength, 0.0), 1.0))
        kept = place.bed if what == "phase" else place.phase
        others = [one for one in self._spots if one[0] == place.claim and kept in one[1:]]
        return Place(*self._chance.one_of(others), place.off_ms, place.strength)


def search(
    hazard: Hazard, runs: int, seeds: Sequence[int], seed: int = 1, play: Play = run
) -> HarmSearch:
    """Search the faults of a hazard that come while the machine runs.

    runs: how many. seeds: of the machines and their patients. seed: chance of the search. play: a
    place. A place that was tried is not tried again, and counts. A hazard whose faults are all
    there before the start has no instant, and is not searched.
    """
    beds = beds_of(hazard, seeds)
    space = _Space(hazard, beds, seed)
    known: dict[Place, SearchedRun | None] = {}
    worst: list[tuple[Place, SearchedRun]] = []
    for number in range(0 if space.is_empty else runs):
        follows = worst and number >= SPREAD_SHARE * runs
        place = space.follow([one for one, _ in worst]) if follows else space.spread(number)
        if place in known:
            continue
        found = known[place] = play(hazard, place, beds)
        if found is not None:
            worst = sorted([*worst, (place, found)], key=lambda one: -one[1].share)[:KEPT]
    broken = tuple(one for one in known.values() if one is not None and one.breaches)
    return HarmSearch(len(known), worst[0][1] if worst else None, broken)


def carry_out(task: SearchTask) -> HarmSearch:
    """`search`, as a process is asked for it."""
    return search(task.hazard, task.runs, task.seeds)
