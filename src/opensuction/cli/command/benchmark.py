"""``benchmark``: every compensator on every plant, with fixed seeds."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import CommandResult, OutputChoice, delivering, to_text
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence.benchmark.benchmark import PairFigures


class BenchmarkOptions(NamedTuple):
    """Options of ``benchmark``."""

    seeds: int = 5
    results: OutputChoice = OutputChoice()


def _compute(options: BenchmarkOptions, progress: "ProgressTeller", _: Path) -> CommandResult:
    from opensuction.evidence.benchmark import benchmark, benchmark_page
    from opensuction.report import sheet

    progress.tell(f"Compensators on twins and models, {options.seeds} seeds each")
    found = benchmark.run(options.seeds, progress.tell)
    figures = benchmark.to_figures(found, progress.elapsed_s)
    data = to_json(figures)
    html = sheet.render(benchmark_page.sheet(found))
    files = {"report.html": html, "benchmark.json": to_text(data)}
    return CommandResult(
        data, files, lambda console, folder: _summarise(console, figures.results, folder)
    )


def _summarise(console: "Console", results: "tuple[PairFigures, ...]", folder: Path) -> None:
    from rich.table import Table

    from opensuction.evidence.benchmark import benchmark_page

    names, rows = benchmark_page.by_plant(results)
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("RMSE, mm", no_wrap=True)
    for name in names:
        table.add_column(name.replace("-", "-\n", 1), justify="right")
    for plant, entries in rows.items():
        errors = (entry.rmse_mm for entry in entries.values())
        table.add_row(plant, *("-" if error is None else f"{error:.3g}" for error in errors))
    console.print(table)
    console.print("Mean of the seeds. In-silico: every plant is a simulated one.")
    console.print(f"Report: {folder / 'report.html'}", soft_wrap=True)


COMMAND = Command(
    name="benchmark",
    options=BenchmarkOptions,
    run=delivering("benchmark", "Comparing", _compute),
    sentence="Every compensator on every plant with fixed seeds: error, peak and head speed of "
    "each pair.",
    details="Plants are the twins (bench, bedside, conduits laid otherwise), the hysteresis "
    "models, and plants that are not ours: the paper's Bouc-Wen model, conduits fitted to real "
    "recordings, friction that depends on speed. Each is identified by the same excitation before "
    "it is compensated, and compensated once more with gap, gain, offset or creep changed since, "
    "and with late commands. Seeds are 101 on.",
    examples="""\b
Examples:
  opensuction benchmark            report.html and benchmark.json under runs/
  opensuction benchmark --seeds 1  a quick look
  opensuction benchmark --json | jq '.results[] | select(.plant == "bench")'""",
    ends="0 done",
)
