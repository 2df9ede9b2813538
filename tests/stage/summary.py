"""One line for both stages of a run, from what each hands over."""

import datetime
from collections import Counter

import pytest

RESULT = "OPENSUCTION_TEST_RESULT"
"""Environment variable: the file into which a stage writes what came of it."""
COUNTED = ("failed", "passed", "skipped", "xfailed", "xpassed", "error")
WIDTH = 80


def status(statuses: list[int]) -> int:
    """A stage without a test is none that failed, unless there was none in any."""
    empty = pytest.ExitCode.NO_TESTS_COLLECTED
    wrong = [one for one in statuses if one not in (pytest.ExitCode.OK, empty)]
    if wrong:
        return wrong[0]
    return int(empty) if all(one == empty for one in statuses) else 0


def line(counts: Counter[str], seconds: float) -> str:
    """Such as ``==== 1 failed, 8 passed in 90.00s (0:01:30) ====``."""
    told = ", ".join(f"{counts[kind]} {kind}" for kind in COUNTED if counts[kind])
    took = datetime.timedelta(seconds=round(seconds))
    return f" {told or 'no tests ran'} in {seconds:.2f}s ({took}) ".center(WIDTH, "=")
