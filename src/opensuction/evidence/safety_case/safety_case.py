"""The safety case that runs: every hazard over its faults, strengths, phases and seeds."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from opensuction import __version__
from opensuction.evidence import crew
from opensuction.evidence.safety_case import hazard_case
from opensuction.evidence.safety_case.hazard_claim import SET_UP, Hazard
from opensuction.evidence.safety_case.hazard_result import HazardResult
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import NAMES
from opensuction.simulation.injection.run_judgement import count_left_inside
from opensuction.twin.fault.fault_table import ROWS

FIRST_SEED = 1
LEAST = ("least_cmh2o", "least_percent")
"""Ends of the names of measures of which less is worse."""

Tell = Callable[[int, int, HazardResult], None]
"""Hears of each result: how many are done, of how many, and it."""


class HazardVerdict(NamedTuple):
    """What all runs of a hazard came to."""

    hazard: Hazard
    results: tuple[HazardResult, ...]
    """In the order of the table."""

    @property
    def ok(self) -> bool:
        """Whether every bound held in every run."""
        return all(result.ok for result in self.results)

    @property
    def worst(self) -> HazardResult:
        """The run that broke a bound, or came nearest to one."""
        return max(self.results, key=_share)


class SafetyCase(NamedTuple):
    """The whole."""

    seeds: tuple[int, ...]
    verdicts: tuple[HazardVerdict, ...]

    @property
    def ok(self) -> bool:
        """Whether every hazard is answered within its bounds."""
        return all(verdict.ok for verdict in self.verdicts)


def _ratio(value: float, bound: float) -> float:
    """Value over its bound; what was never reached is beyond any."""
    if math.isnan(value):
        return math.inf
    return value / bound if bound > 0.0 else (0.0 if value == 0.0 else math.inf)


def _share(result: HazardResult) -> tuple[bool, bool, float]:
    """How bad a run is: broken first, then what was answered, then the bound that is nearest."""
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
) -> SafetyCase:
    """Run every case of every hazard, with a process for each core.

    tell: called from other threads, one call at a time. Raises WorkerLostError where process after
    process dies.
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
    crew.spread(
        hazard_case.run,
        rest,
        crew.count_cores(),
        lambda number, result: note(number + 1, result),
    )
    results = [found[i] for i in range(len(cases))]
    verdicts = tuple(
        HazardVerdict(one, tuple(found for found in results if found.case.hazard == one.row.id))
        for one in hazards
    )
    return SafetyCase(seeds, verdicts)


def _finite(value: float) -> float | None:
    return round(value, 3) if math.isfinite(value) else None


def _bear(results: Sequence[HazardResult]) -> dict[str, float | None]:
    """Each measure of what the patient bore, of the run in which it was worst."""
    borne = [result.exposure for result in results if result.exposure is not None]
    worst = {}
    for name in PatientExposure._fields:
        if name in ("inside_at_end", "outside_mm"):
            continue
        values = [getattr(one, name) for one in borne]
        least = name.endswith(LEAST)
        worst[name] = _finite(min(values) if least else max(values)) if values else None
    return worst


def _run(result: HazardResult) -> dict[str, Any]:
    """One run in plain data."""
    case = result.case
    known = ROWS[case.claim.fault].strength
    set_up = case.span == SET_UP
    return {
        "fault": case.claim.name,
        "phase": None if set_up or case.at.phase is None else case.at.phase.name.lower(),
        "after_s": case.at.after_s,
        "strength": None if known is None else case.strength,
        "approach": case.approach,
        "patient": case.patient,
        "seed": case.seed,
        "alarm": result.alarm.lower() or None,
        "by": result.by or None,
        "detected_ms": _finite(result.detected_ms),
        "detected_bound_ms": _finite(result.detected_bound_ms),
        "safe_ms": _finite(result.safe_ms),
        "safe_bound_ms": _finite(result.safe_bound_ms),
        "harm": [one.name for one in result.harm],
        "left_inside": result.left_inside is not None,
        "within_limits": result.within_limits,
        "ok": result.ok,
        "problem": result.problem or None,
    }


def entry(verdict: HazardVerdict) -> dict[str, Any]:
    """One hazard of the JSON object; times are those of its worst run."""
    row, worst, results = verdict.hazard.row, verdict.worst, verdict.results
    claim = worst.case.claim
    left = [result.left_inside for result in results if result.left_inside is not None]
    return {
        "id": row.id,
        "hazard": row.hazard,
        "severity": row.severity.value,
        "fault": worst.case.title,
        "alarm": worst.alarm.lower() or None,
        "by": worst.by or None,
        "priority": worst.priority,
        "detected_ms": _finite(worst.detected_ms),
        "detected_bound_ms": _finite(worst.detected_bound_ms),
        "safe_state": claim.safe_state,
        "safe_ms": _finite(worst.safe_ms),
        "safe_bound_ms": _finite(worst.safe_bound_ms),
        "refused": worst.refused,
        "within_limits": worst.ok and not worst.answered and worst.left_inside is None,
        "left_inside": count_left_inside(result.left_inside for result in results),
        "unavoidable": sorted({one.unavoidable for one in left if one.unavoidable}),
        "person": sorted({one.person for one in left}),
        "ok": verdict.ok,
        "runs": len(results),
        "broken": sum(not result.ok for result in results),
        "harm": sorted({one.name for result in results for one in result.harm}, key=NAMES.index),
        "exposure": _bear(results),
        "requirements": row.requirements,
        "only_because": sorted(
            {one.only_because for one in verdict.hazard.claims if one.only_because}
        ),
        "worst": _run(worst),
        "problems": [_run(result) for result in results if not result.ok],
    }


def plain(found: SafetyCase, wall_s: float) -> dict[str, Any]:
    """The JSON object of the command."""
    hazards = [entry(verdict) for verdict in found.verdicts]
    every = [result for verdict in found.verdicts for result in verdict.results]
    return {
        "version": __version__,
        "in_silico": True,
        "seeds": list(found.seeds),
        "runs": sum(one["runs"] for one in hazards),
        "broken": sum(one["broken"] for one in hazards),
        "left_inside": count_left_inside(result.left_inside for result in every),
        "ok": found.ok,
        "hazards": hazards,
        "wall_s": round(wall_s, 1),
    }
