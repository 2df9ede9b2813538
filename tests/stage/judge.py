"""Tests in real time are judged only on a computer that kept its word.

A test that is marked ``real_time`` states how long the computer may stand still while it runs
(`Premise`). One that fails though the computer never did for that long has failed. One that fails
on a computer that did is repeated with everything it needs made anew, up to three times; what
cannot be judged even so is listed at the end, and more than three such tests fail the run.
"""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import NamedTuple

import pytest
from _pytest.runner import runtestprotocol

from opensuction.safety.governor.judgement import LATE_TICKS

REPEATS = 3
NOT_JUDGED_MOST = 3
"""Tests; more fail the run."""


class Standstill(NamedTuple):
    """The longest within some time, s, of each class of processes."""

    real_time_s: float
    ordinary_s: float
    late_ticks: int = 0
    """Of a real-time process with a period of 1 ms: as many in a row began a period late."""


class Premise(NamedTuple):
    """For how long, s, the computer may stand still before a failure of the test says nothing."""

    machine_s: float = 0.02
    """With the processes of the machine, which have real-time priority where the kernel grants it;
    as a rule the patience of the drives."""
    others_s: float = 0.5
    """With ordinary processes: console, browser, the test itself; as a rule the time after which
    a process that gives no sign of life is missed."""
    late_ticks: int = LATE_TICKS - 2
    """How many ticks in a row may begin late: at `LATE_TICKS` a machine halts, and a bare loop is
    late less often than one that has something to do."""

    def breach(self, stood: Standstill) -> str:
        """How the computer broke it; empty where it kept it."""
        pairs = (
            ("a real-time process", stood.real_time_s, self.machine_s),
            ("an ordinary process", stood.ordinary_s, self.others_s),
        )
        broken = [
            f"{who} stood still for {1e3 * found:.0f} ms, {1e3 * most:.0f} ms are allowed"
            for who, found, most in pairs
            if found > most
        ]
        if stood.late_ticks > self.late_ticks:
            broken.append(
                f"a real-time process was late for {stood.late_ticks} ticks in a row, "
                f"{self.late_ticks} are allowed"
            )
        return "; ".join(broken)


def premise_of(item: pytest.Item) -> Premise | None:
    """What its marker says; None of a test that is not in real time."""
    marker = item.get_closest_marker("real_time")
    return None if marker is None else Premise(**marker.kwargs)


class RealTimeJudge:
    """Repeats what could not be judged, and says so at the end."""

    def __init__(self, longest: Callable[[int], Standstill]) -> None:
        """Judge by the longest standstill since an instant of the monotonic clock, ns."""
        self._longest = longest
        self.repeated: list[str] = []
        self.not_judged: list[str] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> object:
        """Run a test in real time, once where the computer keeps its word."""
        premise = premise_of(item)
        if premise is None:
            return None
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        reports = self._judged(item, nextitem, premise)
        for report in reports:
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True

    def _judged(
        self, item: pytest.Item, nextitem: pytest.Item | None, premise: Premise
    ) -> Sequence[pytest.TestReport]:
        breach = ""
        for left in reversed(range(1 + REPEATS)):
            begun_ns = time.monotonic_ns()
            reports = runtestprotocol(item, nextitem=nextitem, log=False)
            if not any(report.failed for report in reports):
                break
            stood = self._longest(begun_ns)
            for report in reports:
                if report.failed:
                    report.sections.append(("The computer's longest standstills", str(stood)))
            breach = premise.breach(stood)
            if not breach:
                break
            # A machine that was halted by it serves no other try, and no other test.
            with suppress(Exception):
                item.session._setupstate.teardown_exact(None)
            if left:
                self.repeated.append(f"{item.nodeid}: {breach}")
            else:
                self.not_judged.append(f"{item.nodeid}: {breach}")
                _leave_unjudged(reports, breach)
        return reports

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Fail a run of which too much could not be judged."""
        if len(self.not_judged) > NOT_JUDGED_MOST and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """List what was repeated and what was not judged, each with the standstill."""
        for title, found in (
            ("repeated: the computer stood still", self.repeated),
            (f"not judged, at most {NOT_JUDGED_MOST} may be", self.not_judged),
        ):
            if found:
                terminalreporter.section(title)
                for line in found:
                    terminalreporter.write_line(line)


def _leave_unjudged(reports: Sequence[pytest.TestReport], breach: str) -> None:
    """Make a failure that says nothing a test that was skipped, with the reason."""
    for report in reports:
        if report.failed:
            file, line, _ = report.location
            report.outcome = "skipped"
            report.longrepr = (file, line or 0, f"not judged: {breach}")
