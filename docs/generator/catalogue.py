"""Every page and picture that is made from the code, wholly or between its marks."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from docs.generator import (
    alarm_table,
    benchmark_columns,
    benchmark_table,
    command_page,
    fault_table,
    hazard_table,
    loop_picture,
    model_table,
    parameter_page,
    phase_page,
    phase_picture,
    result_schema,
    right_table,
)
from docs.generator.document import spliced
from docs.generator.safety import risk_table, soup_table, source_share
from docs.generator.safety.tolerance import page as tolerance_page
from opensuction.cli.app import app

DOCS = Path(__file__).resolve().parents[1]
BENCHMARK = DOCS / "evidence" / "2026-11-27-benchmark.json"
"""What `opensuction benchmark --json` gave, in columns."""
EXAMPLES = ("machine", "patient")


def read(path: Path) -> str:
    """Text of a page or an example."""
    return path.read_text(encoding="utf-8")


def generated() -> dict[Path, Callable[[], str]]:
    """Function that gives the contents of each generated file."""
    tables: dict[str, Callable[[], str]] = {
        "reference/alarms.md": alarm_table.markdown,
        "evidence/benchmark.md": _benchmark,
        "explanations/accounts.md": right_table.markdown,
        "reference/faults.md": fault_table.markdown,
        "reference/hazard-analysis.md": hazard_table.markdown,
        "reference/hysteresis-models.md": model_table.markdown,
        "safety/limits-of-the-twin.md": source_share.markdown,
        "safety/risk.md": risk_table.markdown,
        "safety/soup.md": soup_table.markdown,
        "safety/tolerance.md": tolerance_page.markdown,
    }
    whole: dict[str, Callable[[], str]] = {
        "reference/commands.md": partial(command_page.page, app),
        "reference/parameters.md": _parameters,
        "reference/phases.md": phase_page.page,
        "reference/results.schema.json": result_schema.text,
        "pictures/hysteresis-loops.svg": loop_picture.svg,
        "pictures/phases.svg": phase_picture.svg,
    }
    pages = {DOCS / name: partial(_spliced, DOCS / name, table) for name, table in tables.items()}
    return pages | {DOCS / name: text for name, text in whole.items()}


def _spliced(path: Path, table: Callable[[], str]) -> str:
    """A page with its generated part made anew."""
    return spliced(read(path), table())


def _benchmark() -> str:
    """The benchmark's table, of what was measured last."""
    return benchmark_table.markdown(benchmark_columns.read(read(BENCHMARK)))


def _parameters() -> str:
    """The page of parameters, with the examples of machine and patient."""
    return parameter_page.page(*(read(DOCS / "examples" / f"{one}.toml") for one in EXAMPLES))
