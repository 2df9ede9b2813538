"""``safety-case``: every hazard run on the twin, alarm and safe state timed."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import CommandResult, OutputChoice, delivering, to_text
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence.safety_case.day_search import DaySearch
    from opensuction.evidence.safety_case.harm_search import HarmSearch
    from opensuction.evidence.safety_case.hazard_claim import Hazard
    from opensuction.evidence.safety_case.hazard_result import HazardResult
    from opensuction.result.cycle_result import LeftInsideCount
    from opensuction.result.safety_case_result import SafetyCaseResult

EVERY_RUNS = 50
"""A line of progress after so many runs."""
DAYS = 2
"""Of each patient by each approach, beside the whole table."""


class SafetyCaseOptions(NamedTuple):
    """Options of ``safety-case``."""

    table: Path | None = None
    seeds: int = 5
    search: int = 200
    days: int | None = None
    hazard: str | None = None
    results: OutputChoice = OutputChoice()


def _compute(options: SafetyCaseOptions, progress: "ProgressTeller", _: Path) -> CommandResult:
    from opensuction.evidence.safety_case import day_search, hazard, safety_case
    from opensuction.report import sheet
    from opensuction.report.safety_case import safety_case_page

    def tell(done: int, total: int, result: "HazardResult") -> None:
        if not result.ok:
            case = result.case
            progress.tell(f"{case.hazard} broken: {case.title}: {result.problem}")
        if done % EVERY_RUNS == 0 or done == total:
            progress.tell(f"{done} of {total} runs")

    def tell_search(done: int, total: int, one: "Hazard", found: "HarmSearch") -> None:
        for run in found.broken[:1]:
            progress.tell(
                f"{one.row.id} broken in {len(found.broken)} of {found.runs} searched runs: "
                f"{run.title}: {', '.join(run.breaches)}"
            )
        progress.tell(f"{done} of {total} hazards searched")

    def tell_days(done: int, total: int, found: "DaySearch") -> None:
        for day in found.broken:
            progress.tell(
                f"a bound broken without a fault, cycle {day.broken[0].cycle}: {day.place.title}"
            )
        progress.tell(f"days of {done} of {total} patients and approaches searched")

    hazards = hazard.pick(hazard.load(options.table), options.hazard)
    many = "" if len(hazards) == 1 else "s"
    drawn = "seed 1" if options.seeds == 1 else f"seeds 1 to {options.seeds}"
    progress.tell(
        f"{len(hazards)} hazard{many} on the digital twin, {drawn}: each fault "
        "at its instants and strengths"
    )
    seeds = safety_case.seeds_of(options.seeds)
    done = safety_case.run(hazards, seeds, tell, options.search, tell_search)
    whole = options.table is None and options.hazard is None
    days = options.days if options.days is not None else DAYS * whole
    done = done._replace(days=day_search.search_all(days, tell_days))
    found = safety_case.summarise(done, progress.elapsed_s)
    pairs = zip(done.verdicts, found.hazards, strict=True)
    details = [safety_case.detail(verdict, one) for verdict, one in pairs]
    html = sheet.render(safety_case_page.page(found, details))
    data = to_json(found)
    return CommandResult(
        data,
        {"report.html": html, "safety-case.json": to_text(data)},
        lambda console, folder: _summarise(console, found, folder),
        is_good=found.ok,
    )


def _ms(value: float | None, bound: float) -> str:
    return f"{'-' if value is None else format(value, '.0f')} / {bound:.0f}"


def _left_inside(found: "LeftInsideCount") -> str:
    """Number of runs that ended with the tip inside, and of those that were unavoidable."""
    if not found.count:
        return "-"
    if found.unavoidable == found.count:
        return f"{found.count} unavoidable"
    return f"{found.count}, {found.unavoidable} unavoidable"


def _summarise(console: "Console", found: "SafetyCaseResult", folder: Path) -> None:
    from rich.table import Table

    from opensuction.report.safety_case.safety_case_page import (
        describe_days,
        describe_search,
    )

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("hazard", ratio=1)
    table.add_column("alarm,\npriority", ratio=1)
    for column in ("alarm, ms\n/ bound", "safe, ms\n/ bound"):
        table.add_column(column, justify="right", no_wrap=True)
    for column in ("left\ninside", "broken", "searched"):
        table.add_column(column, justify="right")
    for one in found.hazards:
        alarm = (one.alarm or "no expected alarm").replace("_", " ")
        if one.refused:
            alarm = "refused before the start"
        elif one.within_limits:
            alarm = "not needed: within every limit"
        elif one.alarm:
            alarm = f"{alarm}, {one.priority}"
        table.add_row(
            f"{one.id} {one.hazard}",
            alarm,
            _ms(one.detected_ms, one.detected_bound_ms),
            _ms(one.safe_ms, one.safe_bound_ms),
            _left_inside(one.left_inside),
            f"{one.broken} of {one.runs}",
            describe_search(one.searched),
            style=None if one.ok else "bold red",
        )
    console.print(table)
    held = sum(one.ok for one in found.hazards)
    console.print(
        f"{held} of {len(found.hazards)} hazards within their bounds in {found.runs} runs; "
        "times are those of each hazard's worst run. In-silico: the machine is a simulated one.",
        soft_wrap=True,
    )
    left = found.left_inside
    console.print(
        f"Left inside at the end: {left.count} of {found.runs} runs; {left.unavoidable} of "
        f"them nothing could have prevented, {left.told} were told high in time.",
        soft_wrap=True,
    )
    if found.days.days:
        console.print(describe_days(found.days), soft_wrap=True)
    console.print(f"Report: {folder / 'report.html'}", soft_wrap=True)


COMMAND = Command(
    name="safety-case",
    options=SafetyCaseOptions,
    run=delivering("safety-case", "Running", _compute),
    sentence="Every hazard on the twin: its faults injected, alarm and safe state timed against "
    "bounds.",
    details="Every fault comes on every patient, by both approaches, at instants spread over the "
    "time that the tip is inside; five seeds see each fifth of it. A hazard whose bound is broken "
    "is shown as broken, a catheter left inside is counted on its own. The report has a strip "
    "chart of each hazard's worst run. Then each hazard is searched for harm, from .1 s before to "
    ".1 s after each phase begins and over all strengths. Then days of 30 cycles without a "
    "fault are searched. A process for each core shares the work. Seeds are 1 on.",
    examples="""\b
Examples:
  opensuction safety-case                    reports and figures under runs/
  opensuction safety-case --seeds 1 --search 0   one machine of each patient
  opensuction safety-case --hazard OS-H14 --search 5000  one hazard, long
  opensuction safety-case --table mine.toml  hazards of your own
  opensuction safety-case --json | jq '.hazards[] | select(.ok | not)'
  opensuction cycle --fault pump-runaway@suctioning  one of its faults

\b
A row of a hazard table (docs/how-to/safety-case.md says what the keys mean):
  [[hazard]]
  id = "OS-H17"
  hazard = "Vacuum above the patient's limit"
  cause = "Pump runs away"
  effect = "Mucosal haemorrhage"
  severity = "serious"                 # negligible, minor, serious, critical
  detection = "Line vacuum above its limit"
  control = "Valve closed, pump off; out"
  alarm = ["VACUUM_EXCEEDED"]          # any of these
  priority = "high"                    # of the first of them
  safe_state = "out-without-suction"
  detected_ms = 2000
  safe_ms = 10000
  because = "The line takes 2 s to climb that far; 8 s to come out."
  requirements = ["OS-R07"]
  [[hazard.fault]]                     # any key above may be here too
  name = "pump-runaway"
  phases = ["inserting"]               # default: any time with it inside
  patient = "neonate"                  # default: all; approach likewise""",
    ends="0 every bound holds, 1 one is broken, or process after process died",
)
