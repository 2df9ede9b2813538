"""The report of each cycle of a day, made when it is over: its trace is too large to be kept."""

from typing import NamedTuple

from opensuction.report import headline
from opensuction.report.cycle import page
from opensuction.report.figure import FigureVerdict
from opensuction.result.day_result import CycleNews
from opensuction.session.cycle import cycle_summary, machine_summary
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.trace import Columns

MOST_PAGES = 48
"""Of a longer day only the cycles that need a look have a page beyond these: 150 kB each."""


class CycleReport(NamedTuple):
    """Report of one cycle of a day."""

    file: str
    """Name of its page; empty where it has none."""
    html: str
    first: headline.Headline
    """What a person must know of it."""


def make(number: int, prepared: Prepared, columns: Columns) -> CycleReport:
    """The report of one cycle. number: its place in the day, from 1. columns: from its start."""
    data = cycle_summary.summary(prepared, columns)
    first = headline.headline(data)
    if number > MOST_PAGES and first.verdict is FigureVerdict.GOOD:
        return CycleReport("", "", first)
    html = page.render(data, columns, machine_summary.sections(prepared), is_one_of_many=True)
    return CycleReport(f"cycle-{number:03d}.html", html, first)


def news(report: CycleReport) -> CycleNews:
    """First thing to know of a cycle, for its row in the day's result."""
    return CycleNews(report.first.text, report.first.verdict.value, report.file or None)


def list_pages(reports: list[CycleReport]) -> dict[str, str]:
    """Pages by the names of their files."""
    return {report.file: report.html for report in reports if report.file}
