"""The ``benchmark`` command: every compensator on every plant, with fixed seeds."""

import json
import time
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console
from rich.table import Table

from opensuction.cli import output_folder
from opensuction.cli.cycle import interruptible


class Options(NamedTuple):
    """Options of the command as a person gave them."""

    seeds: int
    out: Path | None
    force: bool
    as_json: bool


def run(options: Options) -> int:
    """Carry the command out; returns the exit status. Raises InputError for bad input."""
    began_s = time.monotonic()
    progress = Console(stderr=True, highlight=False)
    folder = output_folder.chosen(options.out, "benchmark")
    with output_folder.whole(folder, options.force) as staging:
        progress.print(f"Compensators on twins and models, {options.seeds} seeds each")
        # Heavy imports, after the first line is out.
        from opensuction.evidence.benchmark import benchmark, benchmark_page
        from opensuction.kernel import compiled
        from opensuction.report import sheet

        if compiled.is_cold():
            progress.print("Compiling the control core: once for this version, about a minute")
        found = interruptible(
            lambda: benchmark.run(options.seeds, lambda line: progress.print(line, soft_wrap=True))
        )
        data = benchmark.plain(found, time.monotonic() - began_s)
        page = sheet.render(benchmark_page.sheet(found))
        (staging / "report.html").write_text(page, encoding="utf-8")
        (staging / "benchmark.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    if options.as_json:
        print(json.dumps(data))  # noqa: T201 - the one object of --json
    else:
        _summarise(Console(highlight=False), data, folder)
    return 0


def _summarise(console: Console, data: dict[str, Any], folder: Path) -> None:
    rows: dict[str, list[str]] = {}
    names = list(dict.fromkeys(entry["compensation"] for entry in data["results"]))
    for entry in data["results"]:
        shown = "-" if entry["rmse_mm"] is None else f"{entry['rmse_mm']:.3g}"
        rows.setdefault(entry["plant"], []).append(shown)
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("RMSE, mm", no_wrap=True)
    for name in names:
        table.add_column(name.replace("-", "-\n", 1), justify="right")
    for plant, cells in rows.items():
        table.add_row(plant, *cells)
    console.print(table)
    console.print("Mean of the seeds. In-silico: every plant is a simulated one.")
    console.print(f"Report: {folder / 'report.html'}", soft_wrap=True)
