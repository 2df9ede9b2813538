"""The report of a recording: the page that a simulated cycle gets, from its file alone."""

from pathlib import Path
from typing import NamedTuple

from opensuction.controller.record import Settings
from opensuction.report.cycle import page
from opensuction.session.plain import Json
from opensuction.session.recorded import recorded_cycle, recorded_summary, replay_run
from opensuction.session.recorded.recorded_cycle import RecordedCycle


class Report(NamedTuple):
    """What is said of a recording."""

    summary: Json
    html: str


def sections(cycle: RecordedCycle) -> dict[str, Json]:
    """Tables for the end of the page: what was recorded, and what the controller was set to."""
    settings: Settings = cycle.settings
    recorded = {
        name: value
        for name, value in replay_run.describe(cycle.heading).items()
        if name not in page.RUN and name != "notice"
    }
    return {
        "Recording": {**recorded, "missing_ticks": cycle.missing, "tick_s": cycle.dt_s},
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


def run(paths: list[Path]) -> Report:
    """The report of a recording.

    paths: its file, or the parts of it in their order. Raises InputError for what is no recording,
    holds no cycle, or cannot be read so far.
    """
    cycle = recorded_cycle.read(paths)
    summary = recorded_summary.summary(cycle)
    return Report(summary, page.render(summary, cycle.columns, sections(cycle)))
