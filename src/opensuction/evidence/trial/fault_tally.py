"""What a campaign of faults came to: how often each invariant was broken, and how sure that is."""

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

from scipy.stats import beta

from opensuction.evidence.trial.fault_campaign import Case
from opensuction.simulation.injection.run_judgement import count_left_inside

CONFIDENCE = 0.95
EXAMPLES = 5
"""Cycles that are named for each kind of breach, so that they can be played again."""


class Bound(NamedTuple):
    """Share of cycles that broke something, with its upper 95 % confidence bound."""

    cycles: int
    broken: int
    upper_percent: float


class Kind(NamedTuple):
    """Cycles that broke the same invariant under the same faults."""

    faults: str
    invariant: str
    physical: bool
    """What happened to the patient, not what was commanded."""
    cycles: int
    worst: float
    bound: float
    examples: tuple[int, ...]


class Unnoticed(NamedTuple):
    """Cycles to which a fault came alone, and those of them in which nobody was told anything."""

    cycles: int
    unnoticed: int


class Tally(NamedTuple):
    """A campaign in numbers."""

    fault_free: Bound
    """Cycles to which no fault came in time: nothing may be broken, or told."""
    false_alarms: int
    """Of those: how many were broken off or raised an alarm."""
    commands: Bound
    """Command side, every cycle."""
    single: Bound
    """Bounds of the patient, cycles with one fault."""
    double: Bound
    left_inside: dict[str, dict[str, int]]
    """By how many faults came: none, single, double; see `run_judgement.count_left_inside`."""
    unnoticed: dict[str, Unnoticed]
    """By the title of the fault."""
    breaches: tuple[Kind, ...]


def bound(cycles: int, broken: int) -> Bound:
    """Clopper and Pearson's one-sided upper bound on the share of cycles that break something."""
    if broken >= cycles:
        return Bound(cycles, broken, 100.0)
    upper = float(beta.ppf(CONFIDENCE, broken + 1, cycles - broken))
    return Bound(cycles, broken, 100.0 * upper)


def _titles(case: Case) -> str:
    return " + ".join(sorted(fault.title for fault in case.faults)) or "none"


def _kinds(cases: Iterable[Case]) -> tuple[Kind, ...]:
    found: dict[tuple[str, str, bool], list[tuple[int, float, float]]] = {}
    for case in cases:
        sides = [(False, one.invariant, one.worst, one.bound) for one in case.commands]
        sides += [(True, one.name, one.worst, one.limit) for one in case.breaches]
        for physical, name, worst, limit in sides:
            key = (_titles(case), name, physical)
            found.setdefault(key, []).append((case.drawn.number, worst, limit))
    kinds = [
        Kind(
            faults=faults,
            invariant=invariant,
            physical=physical,
            cycles=len(entries),
            worst=max(entries, key=lambda entry: abs(entry[1] - entry[2]))[1],
            bound=max(entries, key=lambda entry: abs(entry[1] - entry[2]))[2],
            examples=tuple(number for number, _, _ in entries[:EXAMPLES]),
        )
        for (faults, invariant, physical), entries in found.items()
    ]
    return tuple(sorted(kinds, key=lambda kind: (-kind.cycles, kind.faults, kind.invariant)))


def _physical(cases: list[Case], faults: int) -> Bound:
    chosen = [case for case in cases if len(case.faults) == faults]
    return bound(len(chosen), sum(bool(case.breaches) for case in chosen))


def tally(cases: list[Case]) -> Tally:
    """A campaign's cases counted."""
    alone = [case for case in cases if len(case.faults) == 1]
    every = Counter(case.faults[0].title for case in alone)
    missed = Counter(case.faults[0].title for case in alone if not case.told)
    return Tally(
        fault_free=_physical(cases, 0),
        false_alarms=sum(case.told for case in cases if not case.faults),
        commands=bound(len(cases), sum(bool(case.commands) for case in cases)),
        single=_physical(cases, 1),
        double=_physical(cases, 2),
        left_inside={
            name: count_left_inside(
                case.left_inside for case in cases if len(case.faults) == faults
            )
            for faults, name in enumerate(("none", "single", "double"))
        },
        unnoticed={title: Unnoticed(every[title], missed[title]) for title in sorted(every)},
        breaches=_kinds(cases),
    )
