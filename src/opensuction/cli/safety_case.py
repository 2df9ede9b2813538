"""The ``safety-case`` command: every hazard run on the twin, alarm and safe state timed."""

import json
import time
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console
from rich.table import Table

from opensuction.cli import output_folder
from opensuction.cli.cycle import interruptible

EVERY_RUNS = 50
"""A line of progress after so many runs."""


class Options(NamedTuple):
    """Options of the command as a person gave them."""

    table: Path | None
    seeds: int
    out: Path | None
    force: bool
    as_json: bool


def run(options: Options) -> int:
    """Carry the command out; returns the exit status. Raises InputError for bad input."""
    began_s = time.monotonic()
    progress = Console(stderr=True, highlight=False)
    folder = output_folder.chosen(options.out, "safety-case")
    # Heavy imports.
    from opensuction.evidence.safety_case import hazard

    hazards = hazard.load(options.table)
    with output_folder.whole(folder, options.force) as staging:
        progress.print(
            f"{len(hazards)} hazards on the digital twin, seeds 1 to {options.seeds}: each fault "
            "at its instants and strengths",
            soft_wrap=True,
        )
        from opensuction.evidence.safety_case import safety_case, safety_case_page
        from opensuction.evidence.safety_case.hazard_result import HazardResult
        from opensuction.kernel import compiled
        from opensuction.report import sheet

        if compiled.is_cold():
            progress.print("Compiling the control core: once for this version, about a minute")

        def tell(done: int, total: int, result: HazardResult) -> None:
            if not result.ok:
                name = result.case.hazard
                line = f"{name} broken: {result.case.title}: {result.problem}"
                progress.print(line, soft_wrap=True, markup=False)
            if done % EVERY_RUNS == 0 or done == total:
                progress.print(f"{done} of {total} runs")

        seeds = safety_case.seeds_of(options.seeds)
        found = interruptible(lambda: safety_case.run(hazards, seeds, tell))
        data = safety_case.plain(found, time.monotonic() - began_s)
        page = sheet.render(safety_case_page.sheet(found))
        (staging / "report.html").write_text(page, encoding="utf-8")
        text = json.dumps(data, indent=2) + "\n"
        (staging / "safety-case.json").write_text(text, encoding="utf-8")
    if options.as_json:
        print(json.dumps(data))  # noqa: T201 - the one object of --json
    else:
        _summarise(Console(highlight=False), data, folder)
    return 0 if found.ok else 1


def _ms(value: float | None, bound: float) -> str:
    return f"{'-' if value is None else format(value, '.0f')} / {bound:.0f}"


def _summarise(console: Console, data: dict[str, Any], folder: Path) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("hazard", ratio=1)
    table.add_column("alarm, priority", ratio=1)
    for column in ("alarm, ms / bound", "safe, ms / bound", "broken"):
        table.add_column(column, justify="right", no_wrap=True)
    for entry in data["hazards"]:
        alarm = (entry["alarm"] or "no expected alarm").replace("_", " ")
        if entry["refused"]:
            alarm = "refused before the start"
        elif entry["within_limits"]:
            alarm = "not needed: within every limit"
        elif entry["alarm"]:
            alarm = f"{alarm}, {entry['priority']}"
        table.add_row(
            f"{entry['id']} {entry['hazard']}",
            alarm,
            _ms(entry["detected_ms"], entry["detected_bound_ms"]),
            _ms(entry["safe_ms"], entry["safe_bound_ms"]),
            f"{entry['broken']} of {entry['runs']}",
            style=None if entry["ok"] else "bold red",
        )
    console.print(table)
    held = sum(entry["ok"] for entry in data["hazards"])
    console.print(
        f"{held} of {len(data['hazards'])} hazards within their bounds in {data['runs']} runs; "
        "times are those of each hazard's worst run. In-silico: the machine is a simulated one.",
        soft_wrap=True,
    )
    console.print(f"Report: {folder / 'report.html'}", soft_wrap=True)
