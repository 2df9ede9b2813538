"""The report of a recording: the page that a simulated cycle gets, from its file alone."""

from pathlib import Path
from typing import Annotated, NamedTuple

from opensuction.controller.record import Settings
from opensuction.report.cycle import page
from opensuction.result.cycle_result import CycleResult
from opensuction.result.plain import FLAT, Json
from opensuction.session.recorded import recorded_cycle, recorded_summary, replay_run
from opensuction.session.recorded.on_record import OnRecord
from opensuction.session.recorded.recorded_cycle import RecordedCycle


class Report(NamedTuple):
    """Report on a recording."""

    result: CycleResult
    html: str
    flaw: str | None
    """Why the file is not whole."""
    is_damaged: bool


class ReportedCycle(NamedTuple):
    """A recorded cycle, and what the records say of its file."""

    cycle: Annotated[CycleResult, FLAT]
    on_record: OnRecord


def sections(
    cycle: RecordedCycle, shown: CycleResult, on_record: str | None = None
) -> dict[str, Json]:
    """Tables for the end of the page: what was recorded, and what the controller was set to.

    shown: what the page says of it already. on_record: what the records say of the file, where it
    was held against them.
    """
    settings: Settings = cycle.settings
    recorded = {
        name: value
        for name, value in replay_run.describe(cycle.heading).items()
        if name not in page.ran(shown) and name != "notice"
    }
    said = {} if on_record is None else {"on_record": on_record}
    return {
        "Recording": {
            **recorded,
            **said,
            "missing_ticks": cycle.missing,
            "tick_s": cycle.dt_s,
        },
        "Plan": {
            "preload_s": settings.plan.preload_s,
            "dwell_s": settings.plan.dwell_s,
            "vacuum_mmhg": settings.plan.vacuum_mmhg,
            "nothing_comes_s": settings.plan.pace.nothing_comes_s,
            **settings.plan.motion._asdict(),
        },
        "Governor limits": {
            name: value
            for name, value in settings.limits._asdict().items()
            if isinstance(value, float)
        },
        "Insertion servo": settings.insertion_servo._asdict(),
    }


def run(paths: list[Path], on_record: str | None = None) -> Report:
    """The report of a recording.

    paths: its file, or the parts of it in their order. on_record: see `sections`. Raises InputError
    for what is no recording, holds no cycle, or cannot be read so far.
    """
    cycle = recorded_cycle.read(paths)
    found = recorded_summary.summary(cycle)
    html = page.render(found, cycle.columns, sections(cycle, found, on_record))
    return Report(found, html, cycle.flaw, cycle.is_damaged)
