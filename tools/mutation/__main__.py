"""``python -m tools.mutation``: which mistakes in the safety code would no test notice?

Progress on stderr, one JSON object on stdout or in a file. Exit 1 if a module's score is below
``--least``.
"""

import argparse
import json
import os
import sys
from pathlib import Path

from tools.mutation import campaign
from tools.mutation.campaign import ROOT, Result, Target

ALARM_TESTS = (
    "tests/safety/alarm/test_alarm.py",
    "tests/safety/alarm/test_alarm_*.py",
    "tests/docs/test_alarm_table.py",
)
SOUND_TESTS = (
    "tests/safety/alarm/test_visual_signal.py",
    "tests/safety/alarm/test_auditory_signal.py",
    "tests/docs/test_alarm_table.py",
    "tests/docs/test_catalogue.py",  # the committed pages hold every number
)
GOVERNOR_TESTS = ("tests/safety/governor/test_governor_*.py",)
"""Its examples. Its properties are slow, and left to the governor itself: a lower bound."""
WATCH_TESTS = ("tests/safety/watch/test_watch*.py", *GOVERNOR_TESTS)
PATIENT_TESTS = ("tests/safety/governor/test_governor_patient.py",)
EXTRA: dict[str, tuple[str, ...]] = {
    "safety.alarm.alarm": ALARM_TESTS,
    "safety.alarm.alarm_clock": ALARM_TESTS,
    "safety.alarm.alarm_state": ALARM_TESTS,
    "safety.condition_mask": ALARM_TESTS,
    "safety.handling": ("tests/safety/test_condition.py",),
    "safety.head.drive_force": ("tests/safety/governor/test_governor_drive.py",),
    "safety.governor.governor": GOVERNOR_TESTS,
    "safety.governor.judgement": GOVERNOR_TESTS,
    "safety.governor.limiter": GOVERNOR_TESTS,
    "safety.limits": (
        *GOVERNOR_TESTS,
        *("tests/safety/watch/test_patient_watch.py",),
        *WATCH_TESTS,
    ),
    "safety.watch.patient_watch": PATIENT_TESTS,
    "safety.alarm.alarm_signal": SOUND_TESTS,
    "safety.head.head_vote": (*WATCH_TESTS, *("tests/safety/head/test_head_vote.py",)),
    "safety.invalid_ticks": WATCH_TESTS,
    "safety.watch.head_watch": WATCH_TESTS,
    "safety.watch.watch_state": WATCH_TESTS,
    "safety.watch.watch": GOVERNOR_TESTS,
    "procedure.cycle.transition": ("tests/docs/test_phase_page.py",),
}
"""Tests of a module beyond those of its own name."""


def target(place: str) -> Target:
    """A module by room and name, as ``safety.condition``, with the tests that mirror it.

    Those that end soonest for most mistakes come first. ``MODULE:FUNCTION`` is a function of it.
    """
    short, _, function = place.partition(":")
    *rooms, name = short.split(".")
    mirrors = (f"test_{name}_limit.py", f"test_{name}_*.py", f"test_{name}.py")
    patterns = tuple(f"tests/{'/'.join(rooms)}/{file}" for file in mirrors)
    return Target(f"opensuction.{short}", (*patterns, *EXTRA.get(short, ())), function)


def everything() -> list[str]:
    """Every module of safety, and the table of transitions."""
    package = ROOT / "src" / "opensuction"
    sources = sorted((package / "safety").rglob("[!_]*.py"))
    names = (".".join(source.relative_to(package).with_suffix("").parts) for source in sources)
    return [*names, "procedure.cycle.transition"]


def as_json(results: list[Result]) -> str:
    """The whole campaign as one JSON object."""
    mutants = sum(result.mutants for result in results)
    killed = sum(result.killed for result in results)
    modules = [
        {
            **result._asdict(),
            "survivors": [survivor._asdict() for survivor in result.survivors],
            "score_percent": round(result.score_percent, 1),
            "seconds": round(result.seconds, 1),
        }
        for result in results
    ]
    summary = {
        "mutants": mutants,
        "killed": killed,
        "score_percent": round(100.0 * killed / mutants, 1) if mutants else None,
        "modules": modules,
    }
    return json.dumps(summary, indent=2)


def main() -> int:
    """Run the campaign."""
    parser = argparse.ArgumentParser(prog="python -m tools.mutation", description=__doc__)
    parser.add_argument(
        "modules", nargs="*", metavar="MODULE[:FUNCTION]", help="as safety.condition; none: all"
    )
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--every", type=int, default=1, help="try only each so many-th mutant")
    parser.add_argument("--least", type=float, default=0.0, help="lowest score accepted, percent")
    parser.add_argument("--out", type=Path, help="file for the JSON, instead of stdout")
    options = parser.parse_args()
    chosen = options.modules or everything()
    known = everything()
    unknown = [name for name in chosen if name.partition(":")[0] not in known]
    if unknown:
        parser.error(f"unknown module {unknown[0]}; one of {', '.join(known)}")

    def tell(line: str) -> None:
        print(line, file=sys.stderr, flush=True)  # noqa: T201

    out = options.out.resolve() if options.out else None
    campaign.prepare()
    results = []
    for name in chosen:
        result = campaign.run(target(name), options.workers, tell, options.every)
        results.append(result)
        tell(
            f"{name}: {result.killed} of {result.mutants} noticed, "
            f"{result.score_percent:.1f} %, {result.seconds:.0f} s"
        )
    if out:
        out.write_text(as_json(results) + "\n", encoding="utf-8")
    else:
        print(as_json(results))  # noqa: T201
    return int(any(result.score_percent < options.least for result in results))


if __name__ == "__main__":
    sys.exit(main())
