"""Counts of a trial: broken bounds with their confidence bounds, unnoticed faults, endpoints."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

import numpy as np
from scipy.stats import beta

from opensuction.evidence.trial.judged_cycle import Case
from opensuction.result.cycle_result import LeftInsideCount
from opensuction.result.trial_result import (
    ByFaults,
    Endpoints,
    EndpointSpread,
    LateFaults,
    PatientEndpoints,
    ShareBound,
    TrialBounds,
    Unnoticed,
)
from opensuction.simulation.injection.run_judgement import count_left_inside

CONFIDENCE = 0.95
PERCENTILES = (50.0, 5.0, 95.0)
Value = TypeVar("Value")


def bound(cycles: int, broken: int) -> ShareBound:
    """Clopper and Pearson's one-sided upper bound on the share of cycles that break something."""
    if broken >= cycles:
        return ShareBound(cycles, broken, 100.0)
    upper = float(beta.ppf(CONFIDENCE, broken + 1, cycles - broken))
    return ShareBound(cycles, broken, 100.0 * upper)


def title(case: Case) -> tuple[str, ...]:
    """Names of the faults of a cycle that counted, in the order of the alphabet."""
    return tuple(sorted(one.fault.title for one in case.faults if one.counts))


def by_faults(cases: Sequence[Case], count: Callable[[Sequence[Case]], Value]) -> ByFaults[Value]:
    """A count of the cycles by how many of their faults counted."""
    counts = range(len(ByFaults._fields))
    return ByFaults(*(count([case for case in cases if case.counted == many]) for many in counts))


def bounds(cases: Sequence[Case]) -> TrialBounds:
    """Of commands in all cycles, of patients by how many faults counted, and of false alarms."""
    sound = [case for case in cases if not case.counted]
    return TrialBounds(
        commands=bound(len(cases), sum(bool(case.commands) for case in cases)),
        patient=by_faults(
            cases, lambda some: bound(len(some), sum(bool(case.breaches) for case in some))
        ),
        false_alarms=bound(len(sound), sum(bool(case.false_alarms) for case in sound)),
    )


def count_too_late(cases: Iterable[Case]) -> LateFaults:
    """Faults that came when they could do nothing any more, by name."""
    found = Counter(one.fault.title for case in cases for one in case.faults if not one.counts)
    return LateFaults(found.total(), dict(sorted(found.items())))


def left_inside(cases: Iterable[Case]) -> LeftInsideCount:
    """Catheters left inside."""
    return count_left_inside(case.left_inside for case in cases)


def unnoticed(cases: Iterable[Case]) -> dict[str, Unnoticed]:
    """Of each fault that came alone, by name, how often nobody was told anything."""
    alone = [case for case in cases if len(case.faults) == case.counted == 1]
    every = Counter(title(case)[0] for case in alone)
    missed = Counter(title(case)[0] for case in alone if not case.told)
    return {name: Unnoticed(every[name], missed[name]) for name in sorted(every)}


def endpoints(cases: Sequence[Case]) -> PatientEndpoints:
    """Median, 5th and 95th percentile of each endpoint; what has no number in a cycle is left out.

    cases: at least one, of one patient.
    """
    columns = zip(*(case.endpoints for case in cases), strict=True)
    spreads = dict(zip(Endpoints._fields, map(_spread, columns), strict=True))
    return PatientEndpoints(len(cases), sum(case.completed for case in cases), **spreads)


def _spread(values: Sequence[float | None]) -> EndpointSpread | None:
    numbers = np.array(values, dtype=float)
    numbers = numbers[np.isfinite(numbers)]
    if not numbers.size:
        return None
    return EndpointSpread(*(float(one) for one in np.percentile(numbers, PERCENTILES)))
