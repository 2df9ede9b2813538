"""An identification in the terminal: the result in a line, parameters or ranking, files."""

from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text

from opensuction.report.depth_bar import glyphs
from opensuction.report.identification import identification_words as words
from opensuction.report.terminal import print_end, print_indented
from opensuction.result.identification_result import (
    ComparisonResult,
    ModelResult,
    WorkbenchResult,
)


def _table(*headings: str, numbers: Iterable[str], apart: int = 2) -> Table:
    """An empty table. numbers: headings of the columns that hold some. apart: spaces between."""
    table = Table(box=None, padding=(0, apart, 0, 0), pad_edge=False, header_style="dim")
    for heading in headings:
        table.add_column(heading, justify="right" if heading in numbers else "left", no_wrap=True)
    return table


def _parameters(model: ModelResult) -> Table:
    table = _table("Parameter", "Value", "Unit", "95 % interval", numbers=("Value",))
    for row in words.parameters(model):
        table.add_row(*(Text(cell) for cell in row))
    return table


def _ranking(result: ComparisonResult) -> Table:
    """Models, best first, with the errors that some of them have."""
    measures = words.measures(result)
    # Two spaces would make it 81 characters wide, and a terminal has 80.
    table = _table("Model", *measures, "Inverse", "", numbers=measures, apart=1)
    for model in result.models:
        errors = words.errors(model)
        table.add_row(
            Text(model.model),
            *(Text(words.percent(errors[measure])) for measure in measures),
            Text(words.inverse(model)),
            Text("recommended" if model.recommended else ""),
            style="bold" if model.recommended else "",
        )
    return table


def print_summary(console: Console, result: WorkbenchResult, files: Iterable[object] = ()) -> None:
    """Print what was found, with warnings, and the files that were written."""
    found = words.best(result)
    console.print()
    console.print(Text(f"{glyphs(console).done} {words.outcome(result)}", style="bold green"))
    print_indented(console, words.sentences(result))
    print_indented(console, [f"Warning: {warning}" for warning in found.warnings], "yellow")
    console.print()
    if isinstance(result, ComparisonResult):
        console.print(_ranking(result))
    elif len(found.parameters) <= words.FEW_PARAMETERS:
        console.print(_parameters(found))
    print_end(console, files, words.DISCLAIMER)
