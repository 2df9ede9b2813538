"""Counts of a trial: broken bounds with their confidence bounds, unnoticed faults, endpoints."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import beta

from opensuction.evidence.trial.judged_cycle import Case, Endpoints
from opensuction.simulation.injection.run_judgement import count_left_inside

CONFIDENCE = 0.95
COUNTS = ("none", "single", "double")
"""How many faults of a cycle counted."""
PERCENTILES = (50.0, 5.0, 95.0)


class Bound(NamedTuple):
    """Share of cycles that broke something, with its upper 95 % confidence bound."""

    cycles: int
    broken: int
    upper_percent: float


class Violation(NamedTuple):
    """A bound that a cycle broke; the number plays it again."""

    number: int
    patient: str
    approach: str
    faults: tuple[str, ...]
    counted: int
    bound: str
    is_command: bool
    """What was commanded, not what happened to the patient."""
    worst: float
    limit: float


class Unnoticed(NamedTuple):
    """Cycles to which a fault came alone, and those of them in which nobody was told anything."""

    cycles: int
    unnoticed: int


class EndpointSpread(NamedTuple):
    """An endpoint over cycles."""

    median: float
    p5: float
    p95: float


def bound(cycles: int, broken: int) -> Bound:
    """Clopper and Pearson's one-sided upper bound on the share of cycles that break something."""
    if broken >= cycles:
        return Bound(cycles, broken, 100.0)
    upper = float(beta.ppf(CONFIDENCE, broken + 1, cycles - broken))
    return Bound(cycles, broken, 100.0 * upper)


def title(case: Case) -> tuple[str, ...]:
    """Names of the faults of a cycle that counted, in the order of the alphabet."""
    return tuple(sorted(one.fault.title for one in case.faults if one.counts))


def bounds(cases: Sequence[Case]) -> dict[str, Bound]:
    """Of commands in all cycles, of patients by how many faults counted, and of false alarms."""
    found = {"commands": bound(len(cases), sum(bool(case.commands) for case in cases))}
    for count, name in enumerate(COUNTS):
        chosen = [case for case in cases if case.counted == count]
        found[name] = bound(len(chosen), sum(bool(case.breaches) for case in chosen))
    sound = [case for case in cases if not case.counted]
    found["false_alarms"] = bound(len(sound), sum(bool(case.false_alarms) for case in sound))
    return found


def list_violations(cases: Iterable[Case]) -> list[Violation]:
    """Every bound that was broken, by the number of its cycle."""
    found = []
    for case in cases:
        sides = [(one.invariant, True, one.worst, one.bound) for one in case.commands]
        sides += [(one.name, False, one.worst, one.limit) for one in case.breaches]
        for name, is_command, worst, limit in sides:
            found.append(
                Violation(
                    case.number,
                    case.patient,
                    case.approach,
                    title(case),
                    case.counted,
                    name,
                    is_command,
                    worst,
                    limit,
                )
            )
    return sorted(found, key=lambda one: (one.number, one.bound))


def count_too_late(cases: Iterable[Case]) -> Counter[str]:
    """Faults that came when they could do nothing any more, by name."""
    return Counter(one.fault.title for case in cases for one in case.faults if not one.counts)


def left_inside(cases: Sequence[Case]) -> dict[str, dict[str, int]]:
    """Catheters left inside by how many faults counted."""
    return {
        name: count_left_inside(case.left_inside for case in cases if case.counted == count)
        for count, name in enumerate(COUNTS)
    }


def unnoticed(cases: Iterable[Case]) -> dict[str, Unnoticed]:
    """Of each fault that came alone, by name, how often nobody was told anything."""
    alone = [case for case in cases if len(case.faults) == case.counted == 1]
    every = Counter(title(case)[0] for case in alone)
    missed = Counter(title(case)[0] for case in alone if not case.told)
    return {name: Unnoticed(every[name], missed[name]) for name in sorted(every)}


def endpoints(cases: Sequence[Case]) -> dict[str, EndpointSpread]:
    """Median, 5th and 95th percentile of each endpoint; what has no number in a cycle is left out.

    cases: at least one.
    """
    found = {}
    for name in Endpoints._fields:
        values = np.array([getattr(case.endpoints, name) for case in cases])
        values = values[np.isfinite(values)]
        if values.size:
            found[name] = EndpointSpread(
                *(float(one) for one in np.percentile(values, PERCENTILES))
            )
    return found
