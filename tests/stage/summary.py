"""One line for both stages of a run, from what each hands over."""

import datetime
from collections import Counter

import pytest

RESULT = "OPENSUCTION_TEST_RESULT"
"""Environment variable: the file into which a stage writes what came of it."""
COUNTED = ("failed", "passed", "skipped", "xfailed", "xpassed", "error")
WIDTH = 80
LONGEST = 300
"""Characters that are shown of what a test failed with."""


def failure(kind: str, report: pytest.TestReport | pytest.CollectReport) -> str:
    """Such as ``ERROR tests/test_a.py::test_b at teardown: OSError: ...``, in one line.

    All that is seen of a run may be its last lines. A fixture of the whole session that fails as it
    ends is told at the last test of its process, which has nothing to do with it.
    """
    told = f"{kind.upper()} {report.nodeid}"
    when = getattr(report, "when", "call")
    if when in ("setup", "teardown"):
        told += f" at {when}"
    crash = getattr(report.longrepr, "reprcrash", None)
    message = crash.message if crash else report.longreprtext
    message = " ".join(message.split())
    if len(message) > LONGEST:
        message = f"{message[:LONGEST]} ..."
    return f"{told}: {message}" if message else told


def reason(report: pytest.TestReport | pytest.CollectReport) -> str:
    """Reason for which a test was skipped, such as ``chromium is not installed``."""
    told = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longreprtext
    return " ".join(told.removeprefix("Skipped: ").split())


def skips(reasons: Counter[str]) -> list[str]:
    """A line for each reason: a machine without a browser skips a hundred tests for the same."""
    return [f"SKIPPED {count}: {told}" for told, count in reasons.most_common()]


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
