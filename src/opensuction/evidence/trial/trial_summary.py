"""The JSON object of a trial: counts with their bounds, what was broken, and the endpoints.

Keys and units are a contract (docs/reference/results.md).
"""

import shlex
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from opensuction.evidence.trial import post_cycle_observation, tally
from opensuction.evidence.trial.draw import Trial
from opensuction.evidence.trial.judged_cycle import Case
from opensuction.evidence.trial.part import PlayedPart
from opensuction.evidence.trial.trial_log import Heading
from opensuction.result.plain import Json, without_nan

USUAL = Trial()


class Effort(NamedTuple):
    """What it took."""

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


def _violations(trial: Trial, cases: Sequence[Case]) -> list[Json]:
    return [
        {
            **one._asdict(),
            "faults": list(one.faults),
            "play": play_command(trial, one.number),
        }
        for one in tally.list_violations(cases)
    ]


def _left_inside(cases: Sequence[Case]) -> Json:
    by_faults = tally.left_inside(cases)
    left = [(case, case.left_inside) for case in cases if case.left_inside is not None]
    reasons = Counter((one.unavoidable, one.person) for _, one in left)
    told_s = [one.told_s for _, one in left if one.in_time]
    return {
        **{
            key: sum(one[key] for one in by_faults.values())
            for key in ("count", "unavoidable", "told")
        },
        "by_faults": by_faults,
        "slowest_told_s": max(told_s, default=None),
        "because": [
            {
                "unavoidable": reason,
                "person": person,
                "count": count,
                "faults": dict(
                    Counter(
                        " + ".join(tally.title(case))
                        for case, one in left
                        if (one.unavoidable, one.person) == (reason, person)
                    ).most_common()
                ),
            }
            for (reason, person), count in reasons.most_common()
        ],
    }


def _said(trial: Trial, cases: Sequence[Case]) -> list[Json]:
    """Cycles without a fault that counts of which something was said."""
    return [
        {
            "number": case.number,
            "patient": case.patient,
            "approach": case.approach,
            "seed": case.seed,
            "completed": case.completed,
            "false": list(case.false_alarms),
            "true": list(case.true_alarms),
            "play": play_command(trial, case.number),
        }
        for case in cases
        if not case.counted and (case.false_alarms or case.true_alarms)
    ]


def _endpoints(cases: Sequence[Case]) -> Json:
    found: Json = {}
    for patient in dict.fromkeys(case.patient for case in cases):
        chosen = [case for case in cases if case.patient == patient]
        found[patient] = {
            "cycles": len(chosen),
            "completed": sum(case.completed for case in chosen),
            **{name: one._asdict() for name, one in tally.endpoints(chosen).items()},
        }
    return found


def plain_case(trial: Trial, case: Case) -> Json:
    """What a trial says of one of its cycles."""
    return {
        "number": case.number,
        "play": play_command(trial, case.number),
        "counted": case.counted,
        "told": case.told,
        "false_alarms": list(case.false_alarms),
        "true_alarms": list(case.true_alarms),
        "left_inside": None if case.left_inside is None else case.left_inside._asdict(),
        "violations": _violations(trial, [case]),
        "endpoints": case.endpoints._asdict(),
        "watched_s": case.watched_s,
    }


def is_good(data: Json) -> bool:
    """Whether all that is claimed held: two faults at once are counted, and nothing is claimed."""
    broken = sum(data["bounds"][name]["broken"] for name in ("commands", "none", "single"))
    return bool(data["complete"]) and broken + data["false_alarms"] == 0


def plain(heading: Heading, parts: Sequence[PlayedPart], effort: Effort) -> Json:
    """The JSON object. parts: at least one, of a trial that may not be complete."""
    trial = heading.trial
    cases = sorted((case for one in parts for case in one.cases), key=lambda case: case.number)
    bounds = tally.bounds(cases)
    too_late = tally.count_too_late(cases)
    watched = [case.watched_s for case in cases]
    sound = [case for case in cases if not case.counted]
    return without_nan(
        {
            "version": heading.version,
            "sources": heading.sources,
            "in_silico": True,
            "date_utc": effort.date_utc,
            "trial": trial._asdict(),
            "cycles": len(cases),
            "asked": heading.cycles,
            "complete": len(cases) == heading.cycles,
            "machines": len({(case.patient, case.approach, case.seed) for case in cases}),
            "refused": [line for one in parts for line in one.refused],
            "counted": {name: bounds[name].cycles for name in tally.COUNTS},
            "not_counted": {"faults": too_late.total(), "by_fault": dict(sorted(too_late.items()))},
            "bounds": {name: one._asdict() for name, one in bounds.items()},
            "command_breaches": bounds["commands"].broken,
            "violations": _violations(trial, cases),
            "left_inside": _left_inside(cases),
            "false_alarms": bounds["false_alarms"].broken,
            "false_before_fault": sum(bool(case.false_alarms) for case in cases if case.counted),
            "true_alarms": sum(bool(case.true_alarms) for case in sound),
            "broken_off": sum(not case.completed for case in sound),
            "said": _said(trial, cases),
            "untold": {name: one._asdict() for name, one in tally.unnoticed(cases).items()},
            "endpoints": _endpoints(cases),
            "watched_s": {
                "mean": sum(watched) / len(watched),
                "whole": sum(one >= post_cycle_observation.WATCHED_S for one in watched),
                "most": post_cycle_observation.WATCHED_S,
            },
            "workers": effort.workers,
            "wall_s": round(effort.wall_s, 1),
            "cycles_per_s": round(effort.cycles / effort.wall_s, 2) if effort.cycles else None,
        }
    )
