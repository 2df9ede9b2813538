"""An identification in the terminal: the result in a line, parameters or ranking, files."""

from collections.abc import Iterable

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from opensuction.report.depth_bar import glyphs
from opensuction.report.identification import identification_words as words
from opensuction.report.summary import Summary, number, text, value, warnings
from opensuction.report.terminal import INDENT


def _table(*headings: tuple[str, bool]) -> Table:
    """An empty table; headings with whether their column holds numbers."""
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, header_style="dim")
    for heading, numbers in headings:
        table.add_column(heading, justify="right" if numbers else "left", no_wrap=True)
    return table


def _parameters(model: Summary) -> Table:
    table = _table(("Parameter", False), ("Value", True), ("Unit", False), ("95 % interval", False))
    for row in words.parameters(model):
        table.add_row(*(Text(cell) for cell in row))
    return table


def _ranking(summary: Summary) -> Table:
    """Models, best first, with the errors that some of them have."""
    measures = words.measures(summary)
    table = _table(
        ("Model", False),
        *((heading, True) for heading in measures),
        ("Inverse", False),
        ("", False),
    )
    for model in words.models(summary):
        best = value(model, "recommended") is True
        posed = value(model, "well_posed")
        table.add_row(
            Text(text(model, "model") or "-"),
            *(Text(words.percent(number(model, key))) for key in measures.values()),
            Text({True: "continuous", False: "with gaps"}.get(posed, "-")),
            Text("recommended" if best else ""),
            style="bold" if best else "",
        )
    return table


def print_summary(console: Console, summary: Summary, files: Iterable[object] = ()) -> None:
    """Print what was found, with warnings, and the files that were written."""
    found = words.best(summary)
    console.print()
    console.print(Text(f"{glyphs(console).done} {words.outcome(summary)}", style="bold green"))
    for sentence in words.sentences(summary):
        console.print(Padding(Text(sentence), INDENT))
    for warning in warnings(found):
        console.print(Padding(Text(f"Warning: {warning}", style="yellow"), INDENT))
    console.print()
    if words.is_comparison(summary):
        console.print(_ranking(summary))
    elif len(words.parameters(found)) <= words.FEW_PARAMETERS:
        console.print(_parameters(found))
    console.print()
    for file in files:
        console.print(Text(f"Written: {file}"), soft_wrap=True)
    console.print(Text(words.DISCLAIMER, style="dim"))
