"""The safety case that runs: every hazard over its faults, strengths, phases and seeds.

Details of a hazard for the page of a safety case, beyond its summary.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from opensuction import __version__
from opensuction.evidence import worker_pool
from opensuction.evidence.campaign.sound_machine import AIRWAY
from opensuction.evidence.safety_case import day_search, harm_search, hazard_case
from opensuction.evidence.safety_case.day_search import DaySearch
from opensuction.evidence.safety_case.harm_search import (
    NOT_SEARCHED,
    HarmSearch,
    SearchTask,
)
from opensuction.evidence.safety_case.hazard_case import SearchedRun
from opensuction.evidence.safety_case.hazard_claim import SAFE_STATES, SET_UP, Hazard, Response
from opensuction.evidence.safety_case.hazard_result import HazardResult
from opensuction.oracle.harm import NAMES
from opensuction.result.cycle_result import LeftInsideCount
from opensuction.result.safety_case_result import (
    FaultSummary,
    HarmSearchResult,
    HarmSearchRun,
    HazardDetail,
    HazardRun,
    HazardSummary,
    SafetyCaseResult,
    StripMark,
    WorstExposure,
)
from opensuction.safety.condition import Condition
from opensuction.simulation.injection.run_judgement import count_left_inside
from opensuction.twin.fault.fault_table import ROWS

FIRST_SEED = 1
SEARCH_SEEDS = 2
"""Machines and patients of each kind that a search has: to prepare one takes as long as ten
runs."""
LEAST = ("least_cmh2o", "least_percent")
"""Ends of the names of measures of which less is worse."""

Tell = Callable[[int, int, HazardResult], None]
"""Hears of each result: how many are done, of how many, and it."""
TellSearch = Callable[[int, int, Hazard, HarmSearch], None]
"""Hears of each hazard that was searched: how many are, of how many, and what was found."""


class HazardVerdict(NamedTuple):
    """Verdict on a hazard, from all of its runs."""

    hazard: Hazard
    results: tuple[HazardResult, ...]
    """In the order of the table."""
    search: HarmSearch = NOT_SEARCHED

    @property
    def ok(self) -> bool:
        """True if every bound held in every run, those of the search among them."""
        return all(result.ok for result in self.results) and not self.search.broken

    @property
    def worst(self) -> HazardResult:
        """The run that broke a bound, or came nearest to one."""
        return max(self.results, key=_share)


class SafetyCase(NamedTuple):
    """The whole."""

    seeds: tuple[int, ...]
    verdicts: tuple[HazardVerdict, ...]
    days: DaySearch = DaySearch((), 0)

    @property
    def ok(self) -> bool:
        """True if every hazard is answered within its bounds, and every day without one is."""
        return all(verdict.ok for verdict in self.verdicts) and not self.days.broken


def _ratio(value: float, bound: float) -> float:
    """Value over its bound; what was never reached is beyond any."""
    if math.isnan(value):
        return math.inf
    return value / bound if bound > 0.0 else (0.0 if value == 0.0 else math.inf)


def _share(result: HazardResult) -> tuple[bool, bool, float]:
    """Sort key of the worst run: broken first, then answered, then by the nearest bound."""
    nearest = _ratio(result.detected_ms, result.detected_bound_ms)
    stays = result.left_inside is not None
    if not stays:
        nearest = max(nearest, _ratio(result.safe_ms, result.safe_bound_ms))
    counts = result.answered or stays or not result.ok
    return not result.ok, counts, nearest if counts else 0.0


def seeds_of(count: int) -> tuple[int, ...]:
    """The first ``count`` seeds."""
    return tuple(range(FIRST_SEED, FIRST_SEED + count))


def run(
    hazards: Sequence[Hazard],
    seeds: tuple[int, ...],
    tell: Tell = lambda *_: None,
    search_runs: int = 0,
    tell_search: TellSearch = lambda *_: None,
) -> SafetyCase:
    """Run every case of every hazard, with a process for each core, and search each for harm.

    search_runs: of each hazard; 0 for no search. tell, tell_search: called from other threads, one
    call at a time. Raises WorkerLostError where process after process dies.
    """
    cases = [case for one in hazards for case in hazard_case.cases(one, seeds)]
    # Neighbours share a prepared cycle.
    order = sorted(
        range(len(cases)),
        key=lambda i: (cases[i].seed, cases[i].patient, cases[i].approach, i),
    )
    found: dict[int, HazardResult] = {}

    def note(number: int, result: HazardResult) -> None:
        found[order[number]] = result
        tell(len(found), len(cases), result)

    # The first one here: what it compiles, the processes find in the cache.
    note(0, hazard_case.run(cases[order[0]]))
    rest = [cases[i] for i in order[1:]]
    worker_pool.spread(
        hazard_case.run,
        rest,
        worker_pool.count_cores(),
        lambda number, result: note(number + 1, result),
    )
    searches = _search(hazards, seeds, search_runs, tell_search)
    results = [found[i] for i in range(len(cases))]
    verdicts = tuple(
        HazardVerdict(
            one, tuple(found for found in results if found.case.hazard == one.row.id), searched
        )
        for one, searched in zip(hazards, searches, strict=True)
    )
    return SafetyCase(seeds, verdicts)


def _search(
    hazards: Sequence[Hazard], seeds: tuple[int, ...], runs: int, tell: TellSearch
) -> list[HarmSearch]:
    """A search of each hazard."""
    found = [NOT_SEARCHED] * len(hazards)
    done = 0

    def note(number: int, one: HarmSearch) -> None:
        nonlocal done
        found[number], done = one, done + 1
        tell(done, len(hazards), hazards[number], one)

    if runs:
        tasks = [SearchTask(one, runs, seeds[:SEARCH_SEEDS]) for one in hazards]
        worker_pool.spread(harm_search.carry_out, tasks, worker_pool.count_cores(), note)
    return found


def _finite(value: float) -> float | None:
    return round(value, 3) if math.isfinite(value) else None


def _bear(results: Sequence[HazardResult]) -> WorstExposure:
    """Each measure of what the patient bore, of the run in which it was worst."""
    borne = [result.exposure for result in results if result.exposure is not None]

    def find_worst(name: str) -> float | None:
        values = [getattr(one, name) for one in borne]
        if not values:
            return None
        return _finite(min(values) if name.endswith(LEAST) else max(values))

    return WorstExposure._make(find_worst(name) for name in WorstExposure._fields)


def _count_left_inside(results: Iterable[HazardResult]) -> LeftInsideCount:
    return count_left_inside(result.left_inside for result in results)


def _searched(search: HarmSearch) -> HarmSearchResult:
    worst = search.worst
    return HarmSearchResult(
        runs=search.runs,
        broken=len(search.broken),
        worst=None if worst is None else _searched_run(worst),
        problems=tuple(_searched_run(one) for one in search.broken),
        unavoidable=tuple(_searched_run(one) for one in search.unavoidable),
    )


def _searched_run(run: SearchedRun) -> HarmSearchRun:
    one, bound = run.injection, run.nearest
    return HarmSearchRun(
        fault=one.fault.title,
        after_s=None if ROWS[one.fault].is_setup else one.at.after_s,
        strength=None if ROWS[one.fault].strength is None else one.strength,
        approach=run.bed.kind.approach,
        patient=run.bed.kind.patient,
        seed=run.bed.seed,
        spread=run.bed.spread,
        bound=bound.name,
        worst=_finite(bound.worst),
        limit=_finite(bound.limit),
        unit=bound.unit,
        share=_finite(run.share),
        told=run.told,
        broken=run.breaches,
        unavoidable=run.unavoidable,
    )


def run_record(result: HazardResult) -> HazardRun:
    """A run as the result holds it."""
    case = result.case
    known = ROWS[case.claim.fault].strength
    set_up = case.span == SET_UP
    return HazardRun(
        fault=case.claim.name,
        phase=None if set_up or case.at.phase is None else case.at.phase.name.lower(),
        after_s=None if math.isnan(case.at.after_s) else case.at.after_s,
        strength=None if known is None else case.strength,
        approach=case.approach,
        patient=case.patient,
        seed=case.seed,
        alarm=result.alarm.lower() or None,
        by=result.by or None,
        detected_ms=_finite(result.detected_ms),
        detected_bound_ms=round(result.detected_bound_ms, 3),
        safe_ms=_finite(result.safe_ms),
        safe_bound_ms=round(result.safe_bound_ms, 3),
        harm=tuple(one.name for one in result.harm),
        left_inside=result.left_inside is not None,
        within_limits=result.within_limits,
        ok=result.ok,
        problem=result.problem or None,
    )


def _hazard(verdict: HazardVerdict) -> HazardSummary:
    row, results = verdict.hazard.row, verdict.results
    nearest = verdict.worst
    worst = run_record(nearest)
    left = [result.left_inside for result in results if result.left_inside is not None]
    because = {one.only_because for one in verdict.hazard.claims if one.only_because}
    needed = nearest.answered or worst.left_inside or not worst.ok
    return HazardSummary(
        id=row.id,
        hazard=row.hazard,
        severity=row.severity.value,
        fault=nearest.case.title,
        alarm=worst.alarm,
        by=worst.by,
        priority=nearest.priority,
        detected_ms=worst.detected_ms,
        detected_bound_ms=worst.detected_bound_ms,
        safe_state=nearest.case.claim.safe_state,
        safe_ms=worst.safe_ms,
        safe_bound_ms=worst.safe_bound_ms,
        refused=nearest.refused,
        within_limits=not needed,
        left_inside=_count_left_inside(results),
        unavoidable=tuple(sorted({one.unavoidable for one in left if one.unavoidable})),
        person=tuple(sorted({one.person for one in left})),
        ok=verdict.ok,
        runs=len(results),
        broken=sum(not result.ok for result in results),
        harm=tuple(sorted({one.name for run in results for one in run.harm}, key=NAMES.index)),
        exposure=_bear(results),
        requirements=tuple(row.requirements),
        only_because=tuple(sorted(because)),
        worst=worst,
        searched=_searched(verdict.search),
        problems=tuple(run_record(result) for result in results if not result.ok),
    )


def summarise(found: SafetyCase, wall_s: float) -> SafetyCaseResult:
    """The result of the command. wall_s: how long it took."""
    hazards = tuple(_hazard(verdict) for verdict in found.verdicts)
    every = [result for verdict in found.verdicts for result in verdict.results]
    return SafetyCaseResult(
        version=__version__,
        in_silico=True,
        seeds=found.seeds,
        runs=len(every),
        broken=sum(one.broken for one in hazards),
        left_inside=_count_left_inside(every),
        ok=found.ok,
        hazards=hazards,
        days=day_search.summarise(found.days),
        wall_s=round(wall_s, 1),
    )


SPAN_WORDS = {SET_UP: "before the start", AIRWAY: "in the airway"}


def detail(verdict: HazardVerdict, summary: HazardSummary) -> HazardDetail:
    """A hazard's summary with the words of the table, every fault and the worst run's strip."""
    row, worst = verdict.hazard.row, verdict.worst
    claim = worst.case.claim
    condition = Condition[worst.alarm].row if worst.alarm else None
    return HazardDetail(
        summary=summary,
        cause=row.cause,
        effect=row.effect,
        detection=row.detection,
        control=row.control,
        safe_state=SAFE_STATES[claim.safe_state].words,
        because=tuple(dict.fromkeys(claim.because for claim in verdict.hazard.claims)),
        sentence=condition and f"{condition.sentence}. {condition.remedy}",
        refusal=claim.response == Response.REFUSAL or worst.refused,
        faults=_faults(verdict),
        strip=worst.strip,
        marks=_marks(worst),
    )


def _marks(result: HazardResult) -> tuple[StripMark, ...]:
    """Instants of a run: the fault, the alarm and the safe state that came."""
    after_ms = {"fault": 0.0, "alarm": result.detected_ms, "safe": result.safe_ms}
    return tuple(
        StripMark(name, result.at_s + ms / 1000.0)
        for name, ms in after_ms.items()
        if math.isfinite(ms)
    )


def _faults(verdict: HazardVerdict) -> tuple[FaultSummary, ...]:
    """Every fault of a hazard: its worst run over strengths, phases and seeds."""
    groups: dict[tuple[str, str], list[HazardResult]] = {}
    for result in verdict.results:
        case = result.case
        groups.setdefault((case.claim.name, SPAN_WORDS.get(case.span, case.span)), []).append(
            result
        )
    return tuple(
        _fault(phase, HazardVerdict(verdict.hazard, tuple(results)))
        for (_, phase), results in groups.items()
    )


def _fault(phase: str, group: HazardVerdict) -> FaultSummary:
    """A fault in a phase. group: its runs alone."""
    worst = run_record(group.worst)
    known, strengths = ROWS[group.worst.case.claim.fault].strength, ""
    if known is not None:
        listed = sorted({result.case.strength for result in group.results})
        strengths = ", ".join(f"{one:g}" for one in listed)
        strengths += "" if known.unit == "1" else f" {known.unit}"
    return FaultSummary(
        fault=worst.fault,
        phase=phase,
        strengths=strengths,
        runs=len(group.results),
        alarm=worst.alarm,
        detected_ms=worst.detected_ms,
        detected_bound_ms=worst.detected_bound_ms,
        safe_ms=worst.safe_ms,
        safe_bound_ms=worst.safe_bound_ms,
        finding=worst.problem or "within bounds",
        ok=group.ok,
    )
