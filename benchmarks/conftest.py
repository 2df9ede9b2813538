"""Shared parts of the benchmarks: a line for each ratio at the end of the run.

Absolute times depend on the computer and on who else uses it; what is compared here is compared
within one run. Nothing is asserted about time. With ``--benchmark-disable`` every benchmark runs
once, to show that it still works; then there are no ratios.
"""

from collections.abc import Callable

import pytest

from tests.conftest import Component, component

__all__ = ["Component", "component"]

Tell = Callable[[str], None]

_LINES = pytest.StashKey[list[str]]()


@pytest.fixture
def tell(request: pytest.FixtureRequest) -> Tell:
    """Add a line to the summary of the run."""
    return request.config.stash.setdefault(_LINES, []).append


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Write the lines of `tell` below the results."""
    config = terminalreporter.config
    lines = config.stash.get(_LINES, [])
    if lines and not config.getoption("benchmark_disable"):
        terminalreporter.section("ratios of this run")
        for line in lines:
            terminalreporter.write_line(line)
