"""Hooks of the stages: a run in real time watches for standstills, and hands over its results."""

import json
import os
import sys
from collections import Counter
from collections.abc import Generator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadFileScheduling

from tests.stage import cost, summary
from tests.stage.judge import RealTimeJudge, premise_of
from tests.stage.standstill import StandstillWatch
from tests.stage.summary import COUNTED, RESULT

APART = ("tests/docs/test_examples.py", "tests/docs/test_notebooks.py")
"""Files of which each test is long and shares nothing with the others."""


class FileScheduling(LoadFileScheduling):  # type: ignore[misc]  # xdist is not typed
    """A file's tests go to one process, but for those of `APART`."""

    def _split_scope(self, nodeid: str) -> str:
        file: str = super()._split_scope(nodeid)
        return nodeid if file in APART else file


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> FileScheduling:
    """How pytest-xdist shares out the tests of stage one."""
    return FileScheduling(config, log)


def write_result(reporter: pytest.TerminalReporter, file: Path) -> None:
    """Write how many tests came to which end, which failed, and why some were skipped, as JSON."""
    counts = {kind: len(reporter.stats.get(kind, ())) for kind in COUNTED}
    failed = [
        summary.failure(kind, report)
        for kind in ("failed", "error")
        for report in reporter.stats.get(kind, ())
    ]
    skipped = Counter(map(summary.reason, reporter.stats.get("skipped", ())))
    told = {"counts": counts, "failed": failed, "skipped": skipped}
    file.write_text(json.dumps(told), encoding="utf-8")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Watch for standstills where a test in real time is to be run."""
    config = session.config
    if config.option.collectonly or "PYTEST_XDIST_WORKER" in os.environ:
        return
    if any(premise_of(item) is not None for item in session.items):
        watch = StandstillWatch()
        watch.__enter__()
        config.add_cleanup(watch.__exit__)
        config.pluginmanager.register(RealTimeJudge(watch.longest), "real-time-judge")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of a run."""
    parser.addoption(
        "--costs",
        type=int,
        default=0,
        metavar="N",
        help="name the N tests and files that took most processor time",
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None, None, None]:
    """Note the processor time before a test's fixtures."""
    cost.begin(item)
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: "pytest.CallInfo[None]"
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note what a test took, and tell with one that failed what its machines did."""
    report = yield
    cost.note(item, report)
    rooms = sys.modules.get("tests.runtime.machine_room")
    if report.failed and rooms is not None:
        for room in rooms.OPEN:
            with suppress(Exception):  # a machine may have begun no control
                report.sections.append((f"Machine of {item.name}, {call.when}", room.state()))
    return report


@pytest.hookimpl(trylast=True)
def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Hand what came of the run to whoever runs the stages."""
    most = terminalreporter.config.getoption("costs", 0)
    if most:
        reports = [one for kind in terminalreporter.stats.values() for one in kind]
        terminalreporter.section("processor time")
        for line in cost.table(cost.costs(reports), most):
            terminalreporter.write_line(line)
    file = os.environ.get(RESULT)
    if file and "PYTEST_XDIST_WORKER" not in os.environ:
        write_result(terminalreporter, Path(file))
