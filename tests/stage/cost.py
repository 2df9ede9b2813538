"""Processor time of tests: ``make test ARGS="--costs 40"`` names the costliest tests and files.

Other work on the same computer makes a test last longer, and hardly changes this. It holds what
fixtures took that a test was the first to ask for, and children that ended in it: a browser's
whole time counts for the last test of its file.
"""

import resource
from collections import defaultdict
from collections.abc import Iterable, Iterator

import pytest

PROPERTY = "processor_s"
_BEGUN = pytest.StashKey[float]()


def processor_s() -> float:
    """Processor time of this process and of its children that have ended, in s."""
    of = (resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in of)


def begin(item: pytest.Item) -> None:
    """Note the time before a test's fixtures."""
    item.stash[_BEGUN] = processor_s()


def note(item: pytest.Item, report: pytest.TestReport) -> None:
    """Note in the report of its end how much a test took."""
    if report.when == "teardown" and _BEGUN in item.stash:
        report.user_properties.append((PROPERTY, processor_s() - item.stash[_BEGUN]))


def costs(reports: Iterable[object]) -> dict[str, float]:
    """Seconds of each test, by the reports of a run."""
    return {
        one.nodeid: spent_s
        for one in reports
        if isinstance(one, pytest.TestReport)
        for name, spent_s in one.user_properties
        if name == PROPERTY and isinstance(spent_s, float)
    }


def table(of: dict[str, float], most: int) -> Iterator[str]:
    """Lines of the costliest tests, and of the costliest files. most: how many of each."""
    files: defaultdict[str, float] = defaultdict(float)
    for test, spent_s in of.items():
        files[test.partition("::")[0]] += spent_s
    yield f"{sum(of.values()):.0f} s in {len(of)} tests"
    for each in (of, files):
        yield ""
        for name in sorted(each, key=lambda one: -each[one])[:most]:
            yield f"{each[name]:8.1f} s  {name}"
