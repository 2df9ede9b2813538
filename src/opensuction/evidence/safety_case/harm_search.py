"""A search for harm: the instant, strength, machine and patient at which a hazard does most.

The rows of the table ask at drawn instants. This asks where a detector may be blind: about the
edges of phases, at the ends of a fault's strengths, and then near whatever was worst. Half of
the instants lie anywhere in a phase, for some harm grows with the way that the tip has gone. An
evolution strategy: a first part of the runs is spread over all of it, each of the others changes a
value or two of one of the worst so far. Faults of the set-up have strength, machine and patient
alone.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

from opensuction.evidence.campaign.sound_machine import Kind
from opensuction.evidence.safety_case import hazard_case
from opensuction.evidence.safety_case.hazard_case import Bed, Place, SearchedRun
from opensuction.evidence.safety_case.hazard_claim import PHASES, SET_UP, Hazard
from opensuction.kernel import random_stream
from opensuction.twin.fault.fault_table import ROWS

EDGE_MS, STEP_MS = 100, 5
"""How far about the begin of a phase instants are asked for, and in which steps."""
OFFSETS_MS = tuple(range(-EDGE_MS, EDGE_MS + 1, STEP_MS))
SPREADS = (1.0, 2.0)
"""How far from nominal machines and patients are drawn by turns: as usual, and twice as far, where
one value in eight lies at three standard deviations."""
SPREAD_SHARE = 0.4
"""Of the runs: spread over everything before anything is followed."""
WITHIN = 2
"""One in so many of the spread runs has its instant anywhere in the phase, not at its edge."""
ENDS = (1.0, 0.0)
"""Ends of a range of strengths; half of the spread runs have one."""
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Multiples of it, less their whole part, are spread evenly, however many there are."""
KEPT = 8
"""Worst ones that are followed."""
FOLLOWED_MS = (-20, -10, -5, 5, 10, 20)
"""Steps of the instant."""
TRIES = 5
"""How often another place is looked for where one was tried before."""
NEAR = 0.1
"""Standard deviation of a step of the strength, as a share of its range, and of an instant within a
phase, as a share of that."""
ON_FROM_EDGE = 0.25
"""How often a step of an instant about an edge leads into the phase."""
LAST = 0.999
"""Latest instant within a phase, as a share of it."""
CHANGED_TWICE = 0.3
"""How often a second value is changed, too."""
PURPOSE = 73
"""Number of the noise stream of searches."""

Choice = TypeVar("Choice")


class HarmSearch(NamedTuple):
    """Result of a search."""

    runs: int
    worst: SearchedRun | None
    """None where no run was possible."""
    broken: tuple[SearchedRun, ...]
    """Runs that broke a bound."""
    unavoidable: tuple[SearchedRun, ...]
    """Runs that broke a bound of time which no withdrawal could have kept."""


NOT_SEARCHED = HarmSearch(0, None, (), ())


class SearchTask(NamedTuple):
    """The search of one hazard, for one process."""

    hazard: Hazard
    runs: int
    seeds: tuple[int, ...]


Play = Callable[[Hazard, Place, Sequence[Bed]], SearchedRun | None]
"""What comes of a hazard's place, at these beds; None where that has no such instant or cycle."""


def beds_of(hazard: Hazard, seeds: Sequence[int]) -> list[Bed]:
    """Every patient by every approach that any fault of a hazard is claimed for.

    Of each kind the first seed draws as usual, the second as far as `SPREADS` says, and so on.
    """
    kinds = {
        Kind(patient, approach): None
        for claim in hazard.claims
        for patient in claim.patients
        for approach in claim.approaches
    }
    drawn = zip(seeds, itertools.cycle(SPREADS), strict=False)
    return [Bed(kind, seed, spread) for seed, spread in drawn for kind in kinds]


class Chance:
    """Random numbers of a search, the same for the same seed and purpose."""

    def __init__(self, seed: int, purpose: int) -> None:
        self._source = random_stream.stream(seed, purpose)

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
        self._chance = Chance(seed, PURPOSE)
        self._faults = [ROWS[one.fault] for one in hazard.claims]
        self._beds: dict[tuple[int, str], list[int]] = {}
        for claim, one in enumerate(hazard.claims):
            for bed, kind in enumerate(each.kind for each in beds):
                if kind.patient not in one.patients or kind.approach not in one.approaches:
                    continue
                phases = (SET_UP,) if ROWS[one.fault].is_setup else PHASES[kind.approach]
                for phase in phases:
                    self._beds.setdefault((claim, phase), []).append(bed)
        self._order = sorted(self._beds, key=lambda _: self._chance.uniform())
        self._from = [self._chance.uniform() for _ in self._order]

    def spread(self, number: int) -> Place:
        """One of those that are spread over everything: each fault in each phase takes its turn."""
        again, turn = divmod(number, len(self._order))
        claim, phase = self._order[turn]
        share = (self._from[turn] + GOLDEN * again) % 1.0
        strength = ENDS[again // 2 % 2] if again % 2 else self._chance.uniform()
        bed = self._chance.one_of(self._beds[claim, phase])
        within, off_ms = 0.0, 0
        if phase != SET_UP and (again + turn) % WITHIN == 0:
            within = LAST * share
        elif phase != SET_UP:
            off_ms = OFFSETS_MS[int(share * len(OFFSETS_MS))]
        return Place(claim, bed, phase, within, off_ms, self._strength(claim, strength))

    def follow(self, worst: Sequence[Place]) -> Place:
        """One near one of the worst: the first is taken twice as often as the second, and so on."""
        at = 0
        while at < len(worst) - 1 and self._chance.uniform() < 0.5:
            at += 1
        place = self._change(worst[at])
        return self._change(place) if self._chance.uniform() < CHANGED_TWICE else place

    def _strength(self, claim: int, strength: float) -> float:
        return 0.0 if self._faults[claim].strength is None else min(max(strength, 0.0), 1.0)

    def _change(self, place: Place) -> Place:
        what = ["bed"]
        what += [] if self._faults[place.claim].strength is None else ["strength"]
        what += [] if place.phase == SET_UP else ["instant", "instant", "phase"]
        chosen = self._chance.one_of(what)
        if chosen == "instant" and (place.within > 0.0 or self._chance.uniform() < ON_FROM_EDGE):
            # Far and near steps: what is worst may last for a tenth of the phase.
            within = place.within + NEAR * self._chance.uniform() * self._chance.normal()
            return place._replace(within=min(max(within, 1.0 - LAST), LAST), off_ms=0)
        if chosen == "instant":
            off_ms = place.off_ms + self._chance.one_of(FOLLOWED_MS)
            return place._replace(off_ms=min(max(off_ms, -EDGE_MS), EDGE_MS))
        if chosen == "strength":
            strength = place.strength + NEAR * self._chance.normal()
            return place._replace(strength=self._strength(place.claim, strength))
        if chosen == "bed":
            return place._replace(bed=self._chance.one_of(self._beds[place.claim, place.phase]))
        phases = [
            phase
            for (claim, phase), beds in self._beds.items()
            if claim == place.claim and place.bed in beds
        ]
        return place._replace(phase=self._chance.one_of(phases))


def search(
    hazard: Hazard,
    runs: int,
    seeds: Sequence[int],
    seed: int = 1,
    play: Play = hazard_case.run_searched,
) -> HarmSearch:
    """Search the faults of a hazard.

    runs: how many at most. seeds: of the machines and their patients. seed: chance of the search.
    play: a place. No place is played twice: the search of a space that is small ends sooner.
    """
    beds = beds_of(hazard, seeds)
    space = _Space(hazard, beds, seed)
    known: dict[Place, SearchedRun | None] = {}
    worst: list[tuple[Place, SearchedRun]] = []
    for number in range(runs):
        follows = worst and number >= SPREAD_SHARE * runs
        for _ in range(TRIES):
            place = space.follow([one for one, _ in worst]) if follows else space.spread(number)
            if place not in known:
                break
        else:
            continue
        found = known[place] = play(hazard, place, beds)
        if found is not None:
            worst = sorted([*worst, (place, found)], key=lambda one: -one[1].share)[:KEPT]
    played = [one for one in known.values() if one is not None]
    return HarmSearch(
        runs=len(known),
        worst=worst[0][1] if worst else None,
        broken=tuple(one for one in played if one.breaches),
        unavoidable=tuple(one for one in played if one.unavoidable),
    )


def carry_out(task: SearchTask) -> HarmSearch:
    """`search`, as a process is asked for it."""
    return search(task.hazard, task.runs, task.seeds)
