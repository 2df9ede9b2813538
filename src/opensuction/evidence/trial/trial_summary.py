"""The result of a trial: counts with their bounds, what was broken, and the endpoints.

Counts of a trial: broken bounds with their confidence bounds, unnoticed faults, endpoints.
"""

import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from scipy.special import betaincinv

from opensuction.evidence.campaign import played_cycle
from opensuction.evidence.trial.judged_cycle import Case
from opensuction.evidence.trial.trial import Heading, PlayedPart
from opensuction.result.cycle_result import LeftInsideCount
from opensuction.result.plain import measured
from opensuction.result.trial_result import (
    ByFaults,
    CatheterLeftInside,
    Endpoints,
    EndpointSpread,
    LateFaults,
    LeftInsideCycles,
    LeftInsideReason,
    PatientEndpoints,
    SaidCycle,
    ShareBound,
    Trial,
    TrialBounds,
    TrialCycle,
    TrialResult,
    Unnoticed,
    Violation,
    WatchedTime,
)
from opensuction.simulation.injection.run_judgement import count_left_inside

CONFIDENCE = 0.95
PERCENTILES = (50.0, 5.0, 95.0)
Value = TypeVar("Value")


def bound(cycles: int, broken: int) -> ShareBound:
    """Clopper and Pearson's one-sided upper bound on the share of cycles that break something."""
    if broken >= cycles:
        return ShareBound(cycles, broken, 100.0)
    upper = float(betaincinv(broken + 1, cycles - broken, CONFIDENCE))
    return ShareBound(cycles, broken, 100.0 * upper)


def title(case: Case) -> tuple[str, ...]:
    """Names of the faults of a cycle that counted, in the order of the alphabet."""
    return tuple(sorted(one.fault.title for one in case.faults if one.counts))


def by_faults(cases: Sequence[Case], count: Callable[[Sequence[Case]], Value]) -> ByFaults[Value]:
    """A count of the cycles by how many of their faults counted."""
    counts = range(len(ByFaults._fields))
    return ByFaults(*(count([case for case in cases if case.counted == many]) for many in counts))


def count_bounds(cases: Sequence[Case]) -> TrialBounds:
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


USUAL = Trial()


class Effort(NamedTuple):
    """Effort of a trial."""

    workers: int
    wall_s: float
    cycles: int
    """Played in that time; others were kept from before."""
    date_utc: str


def play_command(trial: Trial, number: int | str) -> str:
    """The command line that plays a cycle again."""
    words = [f"opensuction trial --play {number} --faults {trial.faults}"]
    for name, usual in USUAL._asdict().items():
        chosen = getattr(trial, name)
        if name != "faults" and chosen != usual:
            words.append(f"--{name} {shlex.quote(str(chosen))}")
    return " ".join(words)


def list_violations(trial: Trial, cases: Iterable[Case]) -> tuple[Violation, ...]:
    """Every bound that was broken, by the number of its cycle."""
    found = []
    for case in cases:
        sides = [(one.invariant, True, one.worst, one.bound) for one in case.commands]
        sides += [(one.name, False, one.worst, one.limit) for one in case.breaches]
        found += [
            Violation(
                number=case.number,
                patient=case.patient,
                approach=case.approach,
                faults=title(case),
                counted=case.counted,
                bound=name,
                is_command=is_command,
                worst=worst,
                limit=limit,
                play=play_command(trial, case.number),
            )
            for name, is_command, worst, limit in sides
        ]
    return tuple(sorted(found, key=lambda one: (one.number, one.bound)))


def _left_inside(cases: Sequence[Case]) -> LeftInsideCycles:
    left = [(case, case.left_inside) for case in cases if case.left_inside is not None]
    reasons = Counter((one.unavoidable, one.person) for _, one in left)
    faults = {
        reason: Counter(
            " + ".join(title(case)) for case, one in left if (one.unavoidable, one.person) == reason
        )
        for reason in reasons
    }
    return LeftInsideCycles(
        total=left_inside(cases),
        by_faults=by_faults(cases, left_inside),
        slowest_told_s=max((one.told_s for _, one in left if one.in_time), default=None),
        because=tuple(
            LeftInsideReason(*reason, count, dict(faults[reason].most_common()))
            for reason, count in reasons.most_common()
        ),
    )


def _said(trial: Trial, cases: Sequence[Case]) -> tuple[SaidCycle, ...]:
    """Cycles without a fault that counts of which something was said."""
    return tuple(
        SaidCycle(
            number=case.number,
            patient=case.patient,
            approach=case.approach,
            seed=case.seed,
            completed=case.completed,
            false=case.false_alarms,
            true=case.true_alarms,
            play=play_command(trial, case.number),
        )
        for case in cases
        if not case.counted and (case.false_alarms or case.true_alarms)
    )


def _endpoints(cases: Sequence[Case]) -> dict[str, PatientEndpoints]:
    return {
        patient: endpoints([case for case in cases if case.patient == patient])
        for patient in dict.fromkeys(case.patient for case in cases)
    }


def _watched(cases: Sequence[Case]) -> WatchedTime:
    watched = [case.watched_s for case in cases]
    most = played_cycle.WATCHED_S
    return WatchedTime(
        mean=sum(watched) / len(watched), whole=sum(one >= most for one in watched), most=most
    )


def summarise_case(trial: Trial, case: Case) -> TrialCycle:
    """Summary of one cycle of a trial."""
    left = case.left_inside
    return measured(
        TrialCycle(
            number=case.number,
            play=play_command(trial, case.number),
            counted=case.counted,
            told=case.told,
            false_alarms=case.false_alarms,
            true_alarms=case.true_alarms,
            left_inside=None if left is None else CatheterLeftInside(*left),
            violations=list_violations(trial, [case]),
            endpoints=case.endpoints,
            watched_s=case.watched_s,
        )
    )


def is_good(result: TrialResult) -> bool:
    """True if every claim held; two faults at once are only counted, with no claim."""
    patient = result.bounds.patient
    broken = result.bounds.commands.broken + patient.none.broken + patient.single.broken
    return result.complete and broken + result.false_alarms == 0


def summarise(heading: Heading, parts: Sequence[PlayedPart], effort: Effort) -> TrialResult:
    """The result. parts: at least one, of a trial that may not be complete."""
    trial = heading.trial
    cases = sorted((case for one in parts for case in one.cases), key=lambda case: case.number)
    bounds = count_bounds(cases)
    sound = [case for case in cases if not case.counted]
    return measured(
        TrialResult(
            version=heading.version,
            sources=heading.sources,
            in_silico=True,
            date_utc=effort.date_utc,
            trial=trial,
            cycles=len(cases),
            asked=heading.cycles,
            complete=len(cases) == heading.cycles,
            machines=len({(case.patient, case.approach, case.seed) for case in cases}),
            refused=tuple(line for one in parts for line in one.refused),
            counted=by_faults(cases, len),
            not_counted=count_too_late(cases),
            bounds=bounds,
            command_breaches=bounds.commands.broken,
            violations=list_violations(trial, cases),
            left_inside=_left_inside(cases),
            too_slow=sum(bool(case.unavoidable) for case in cases),
            false_alarms=bounds.false_alarms.broken,
            false_before_fault=sum(bool(case.false_alarms) for case in cases if case.counted),
            true_alarms=sum(bool(case.true_alarms) for case in sound),
            broken_off=sum(not case.completed for case in sound),
            said=_said(trial, cases),
            untold=unnoticed(cases),
            endpoints=_endpoints(cases),
            watched_s=_watched(cases),
            workers=effort.workers,
            wall_s=round(effort.wall_s, 1),
            cycles_per_s=round(effort.cycles / effort.wall_s, 2) if effort.cycles else None,
        )
    )
