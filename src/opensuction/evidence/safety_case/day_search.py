"""A search for harm over days of cycles in which nothing breaks.

Machine and patient are drawn up to three times as far from the nominal ones as usual, three
standard deviations at most; a drawn patient coughs, breathes and is moved. Half of the days measure
gap and offset as they go (`session.day.day_calibration`). The first days of a search draw anew;
each of the others stays near one of the worst so far: the same machine and patient drawn further or
less far, with the other calibration, or others drawn as far.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from opensuction.evidence import worker_pool
from opensuction.evidence.campaign.sound_machine import Kind
from opensuction.evidence.safety_case.harm_search import KEPT, SPREAD_SHARE, TRIES, Chance
from opensuction.evidence.safety_case.hazard_case import KINDS
from opensuction.kernel.errors import InputError
from opensuction.oracle import exposure, harm
from opensuction.oracle.harm import LEFT_INSIDE, SATURATION, TIP_PAST_CAP, Harm
from opensuction.result.safety_case_result import DaySearchResult, SearchedDayRun
from opensuction.session.choice import CycleChoice, DayChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.day import day_run
from opensuction.session.day.day_run import Day, DayCycle
from opensuction.simulation import outcome
from opensuction.simulation.trace import Columns

CYCLES, EVERY_MIN = 30, 30.0
"""Fifteen hours, a cycle each half hour: within the 24 h of a catheter [design]."""
MOST_SPREAD = 3.0
STEP = 0.3
"""Standard deviation of a step of the spread."""
PURPOSE = 74
"""Number of the noise stream of these searches."""
FULL_PERCENT = 100.0


class DayPlace(NamedTuple):
    """A day: machine and patient, and whether it is calibrated as it goes."""

    kind: Kind
    self_calibrates: bool
    seed: int
    spread: float
    """Rounded to .01: as the command line is told it."""

    @property
    def title(self) -> str:
        """The day as the command line writes it."""
        calibrates = " --self-calibrate" if self.self_calibrates else ""
        return (
            f"cycle --patient {self.kind.patient} --approach {self.kind.approach} "
            f"--seed {self.seed} --spread {self.spread:g} --repeat {CYCLES} "
            f"--every {EVERY_MIN:g}{calibrates}"
        )


class CycleHarm(NamedTuple):
    """A bound, and how near to it a cycle of a day came."""

    cycle: int
    """From 1."""
    bound: Harm
    told: bool
    """Whether people were told of anything in this cycle."""


class SearchedDay(NamedTuple):
    """Result of a day."""

    place: DayPlace
    cycles: int
    """As many as were begun."""
    aborted: int
    """Of them: broken off."""
    nearest: CycleHarm
    share: float
    """Worst value over its bound, infinite where one was broken."""
    broken: tuple[CycleHarm, ...]


class DaySearch(NamedTuple):
    """Result of a search."""

    days: tuple[SearchedDay, ...]
    refused: int
    """Days whose machine cannot do its protocol: no cycle begins."""

    @property
    def worst(self) -> SearchedDay | None:
        """The day that came nearest to a bound; None where none was played."""
        return max(self.days, key=lambda day: day.share, default=None)

    @property
    def broken(self) -> tuple[SearchedDay, ...]:
        """Days in which a bound was broken."""
        return tuple(day for day in self.days if day.broken)


class DayTask(NamedTuple):
    """The search of one patient's days by one approach, for one process."""

    kind: Kind
    days: int


Play = Callable[[DayPlace], SearchedDay | None]
"""The result of a day; None where its machine cannot do the protocol."""
Tell = Callable[[int, int, DaySearch], None]
"""Hears of each patient and approach that was searched: how many are, of how many, and what was
found."""


def find_share(found: Harm) -> float:
    """Worst value over its bound, of saturation what is missing to 100 %; infinite beyond it.

    Where the tip rests, and how deep it goes, is planned: it counts only where it is broken.
    """
    if found.is_broken:
        return math.inf
    if found.name in (LEFT_INSIDE, TIP_PAST_CAP):
        return 0.0
    if found.name == SATURATION:
        return (FULL_PERCENT - found.worst) / (FULL_PERCENT - found.limit)
    return max(found.worst / found.limit, 0.0)


def play(place: DayPlace) -> SearchedDay | None:
    """Play a day and hold each cycle, until the end of its observation, against every bound.

    The saturation between the cycles is the patient's own.
    """
    kind = place.kind
    rig = RigChoice(patient=kind.patient, seed=place.seed, spread=place.spread)
    choice = CycleChoice(rig, approach=kind.approach)
    asked = DayChoice(CYCLES, EVERY_MIN, place.self_calibrates)
    found: list[CycleHarm] = []

    def judge(cycle: DayCycle, ready: Prepared, columns: Columns) -> None:
        machine, cap_mm = ready.rig.machine, ready.loop.controller.limits.cap_mm
        borne = exposure.measure(machine, columns)
        told = bool(outcome.told(columns))
        found.extend(
            CycleHarm(cycle.number, one, told) for one in harm.measure(machine, borne, cap_mm)
        )

    try:
        day = day_run.play(cycle_run.prepare(resolution.resolve(choice)), asked, judge)
    except InputError:
        return None
    return _sum_up(place, day, found)


def _sum_up(place: DayPlace, day: Day, found: Sequence[CycleHarm]) -> SearchedDay:
    nearest = max(found, key=lambda one: find_share(one.bound))
    return SearchedDay(
        place=place,
        cycles=len(day.cycles),
        aborted=sum(not cycle.outcome.completed for cycle in day.cycles),
        nearest=nearest,
        share=find_share(nearest.bound),
        broken=tuple(one for one in found if one.bound.is_broken),
    )


class _Space:
    """The days of one patient by one approach, and how one is come by."""

    def __init__(self, kind: Kind, seed: int) -> None:
        self._kind, self._chance = kind, Chance(seed, PURPOSE + KINDS.index(kind))
        self._seed = 0

    def spread(self, number: int) -> DayPlace:
        """A machine and a patient drawn anew, ever further from the nominal ones by turns."""
        # However few there are of each kind, the kinds together have all of it.
        turn = number + KINDS.index(self._kind)
        calibrates, far = turn % 2 == 1, turn // 2 % 3
        return DayPlace(self._kind, calibrates, self._draw(), MOST_SPREAD * (far + 1) / 3.0)

    def follow(self, worst: Sequence[DayPlace]) -> DayPlace:
        """A day near one of the worst: the first is taken twice as often as the second."""
        at = 0
        while at < len(worst) - 1 and self._chance.uniform() < 0.5:
            at += 1
        place, what = worst[at], self._chance.one_of(("spread", "spread", "seed", "calibration"))
        if what == "seed":
            return place._replace(seed=self._draw())
        if what == "calibration":
            return place._replace(self_calibrates=not place.self_calibrates)
        spread = round(place.spread + STEP * self._chance.normal(), 2)
        return place._replace(spread=min(max(spread, 0.0), MOST_SPREAD))

    def _draw(self) -> int:
        """The next seed of this kind: no two kinds share one."""
        self._seed += 1
        return len(KINDS) * self._seed + KINDS.index(self._kind)


def search(kind: Kind, days: int, seed: int = 1, play_day: Play = play) -> DaySearch:
    """Search the days of one patient by one approach.

    days: how many at most. seed: chance of the search. play_day: plays one. No day is played twice.
    """
    space = _Space(kind, seed)
    known: dict[DayPlace, SearchedDay | None] = {}
    worst: list[SearchedDay] = []
    for number in range(days):
        follows = worst and number >= SPREAD_SHARE * days
        for _ in range(TRIES):
            place = space.follow([one.place for one in worst]) if follows else space.spread(number)
            if place not in known:
                break
        else:
            continue
        found = known[place] = play_day(place)
        if found is not None:
            worst = sorted([*worst, found], key=lambda one: -one.share)[:KEPT]
    played = tuple(one for one in known.values() if one is not None)
    return DaySearch(played, len(known) - len(played))


def carry_out(task: DayTask) -> DaySearch:
    """`search`, as a process is asked for it."""
    return search(task.kind, task.days)


def search_all(days: int, tell: Tell = lambda *_: None) -> DaySearch:
    """Search the days of every patient by both approaches, with a process for each core.

    days: of each patient by each approach; 0 for none. tell: called from other threads, one call at
    a time. Raises WorkerLostError where process after process dies.
    """
    kinds = [DayTask(Kind(*kind), days) for kind in KINDS] if days else []
    found: dict[int, DaySearch] = {}

    def note(number: int, one: DaySearch) -> None:
        found[number] = one
        tell(len(found), len(kinds), one)

    worker_pool.spread(carry_out, kinds, worker_pool.count_cores(), note)
    several = [found[number] for number in range(len(kinds))]
    return DaySearch(
        tuple(day for one in several for day in one.days), sum(one.refused for one in several)
    )


def summarise(found: DaySearch) -> DaySearchResult:
    """The result as the safety case has it."""
    worst = found.worst
    return DaySearchResult(
        days=len(found.days),
        cycles=sum(day.cycles for day in found.days),
        aborted=sum(day.aborted for day in found.days),
        refused=found.refused,
        broken=len(found.broken),
        untold=sum(any(not one.told for one in day.broken) for day in found.broken),
        worst=None if worst is None else _shown(worst, worst.nearest),
        problems=tuple(_shown(day, day.broken[0]) for day in found.broken),
    )


def _shown(day: SearchedDay, shown: CycleHarm) -> SearchedDayRun:
    """A day by one of its bounds."""
    place, bound = day.place, shown.bound
    return SearchedDayRun(
        command=place.title,
        patient=place.kind.patient,
        approach=place.kind.approach,
        self_calibrates=place.self_calibrates,
        seed=place.seed,
        spread=place.spread,
        cycles=day.cycles,
        aborted=day.aborted,
        cycle=shown.cycle,
        bound=bound.name,
        worst=round(bound.worst, 3),
        limit=round(bound.limit, 3),
        unit=bound.unit,
        share=round(day.share, 3) if math.isfinite(day.share) else None,
        told=shown.told,
        broken=tuple(dict.fromkeys(one.bound.name for one in day.broken)),
    )
