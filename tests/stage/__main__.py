"""Both stages of the tests: ``python -m tests.stage -m EXPRESSION [pytest's options]``.

Stage one: what depends on no clock, on all cores. Stage two: the tests in real time, one after the
other with nothing beside them. At the end one line in pytest's own form sums up both. With
``--benchmarks`` each benchmark runs once in stage one, without a time.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.stage import summary

REAL_TIME = "real_time"
UNCACHED = "PYTHONDONTWRITEBYTECODE"
"""A variable of Python's with which each process would compile all that it imports."""
STAGES = {
    "1 of 2, on all cores": (
        "not real_time",
        ("-n", "auto", "--dist", "loadfile", "--no-loadscope-reorder"),
    ),
    "2 of 2, in real time, one after the other": (REAL_TIME, ("-p", "no:xdist")),
}
"""Title of each: its tests, and how they are run."""
TOLD = ("-r", "fExX")
"""Of each test what came of it, but for the skipped ones: their reasons are told at the end."""
NO_BENCHMARKS = ("-p", "no:benchmark")
BENCHMARKS = ("--benchmark-disable", "benchmarks", "src", "tests")
"""The benchmarks first: what they compile is there for the tests."""


def main(arguments: list[str]) -> int:
    """Run both; 0 where nothing failed, else pytest's exit status of the first that did."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("-m", dest="expression", default="")
    parser.add_argument("--benchmarks", action="store_true")
    asked, others = parser.parse_known_args(arguments)
    counts: Counter[str] = Counter()
    skipped: Counter[str] = Counter()
    failed: list[str] = []
    statuses: list[int] = []
    begun_s = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for title, (own, options) in STAGES.items():
            _say(f"Stage {title}:")
            expression = f"({asked.expression}) and {own}" if asked.expression else own
            result = Path(folder) / "result.json"
            command = [sys.executable, "-m", "pytest", "-m", expression, *options, *TOLD, *others]
            command += BENCHMARKS if asked.benchmarks and own != REAL_TIME else NO_BENCHMARKS
            command += _files(own, others)
            ran = subprocess.run(command, env=_environment(result), check=False)
            statuses.append(ran.returncode)
            if not result.exists():  # it was interrupted, or misunderstood what was asked
                return statuses[-1]
            told = json.loads(result.read_text(encoding="utf-8"))
            result.unlink()
            counts.update(told["counts"])
            failed.extend(told["failed"])
            skipped.update(told["skipped"])
    _say(*summary.skips(skipped), *failed, summary.line(counts, time.monotonic() - begun_s))
    return summary.status(statuses)


def _files(own: str, others: list[str]) -> list[str]:
    """Where the tests in real time are, unless files were named: to look for them takes long."""
    if own != REAL_TIME or any(Path(one.split("::")[0]).exists() for one in others):
        return []
    files = sorted(Path("tests").rglob("test_*.py"))
    return [str(one) for one in files if REAL_TIME in one.read_text(encoding="utf-8")]


def _environment(result: Path) -> dict[str, str]:
    """The environment of a stage; result: what it writes."""
    others = {name: value for name, value in os.environ.items() if name != UNCACHED}
    return {**others, summary.RESULT: str(result)}


def _say(*lines: str) -> None:
    sys.stdout.writelines(f"{line}\n" for line in lines)
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
