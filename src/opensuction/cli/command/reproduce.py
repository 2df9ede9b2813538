"""``reproduce``: the paper's tables and figures on the twin, side by side."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli.delivery import CommandResult, OutputChoice, delivering, to_text
from opensuction.cli.entry import Command
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence.paper.claim import PaperClaim


class ReproduceOptions(NamedTuple):
    """Options of ``reproduce``."""

    results: OutputChoice = OutputChoice()


def _compute(_options: ReproduceOptions, progress: "ProgressTeller", _: Path) -> CommandResult:
    from opensuction.evidence.paper import reproduction
    from opensuction.report import sheet

    progress.tell("The paper reproduced on the digital twin: some twenty seconds")
    found = reproduction.run(progress.tell)
    data = to_json(reproduction.to_result(found, progress.elapsed_s))
    return CommandResult(
        data,
        {"report.html": sheet.render(found.sheet), "reproduce.json": to_text(data)},
        lambda console, folder: _summarise(console, found.claims, folder),
        is_good=not any(entry.is_unexplained for entry in found.claims),
    )


def _summarise(console: "Console", claims: "list[PaperClaim]", folder: Path) -> None:
    from rich.table import Table

    from opensuction.evidence.paper import claim

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("claim", ratio=1)
    for column in ("paper", "here", "+-"):
        table.add_column(column, justify="right", no_wrap=True)
    for column in ("unit", "kind", "verdict"):
        table.add_column(column, no_wrap=True)
    for entry in claims:
        here = f"{entry.measured:.4g}" if math.isfinite(entry.measured) else "-"
        printed = "" if entry.source == claim.PRINTED else "*"
        table.add_row(
            f"{entry.name} ({entry.where})",
            f"{entry.paper:.4g}{printed}",
            here,
            f"{entry.tolerance:.2g}",
            entry.unit,
            entry.kind,
            entry.verdict,
        )
    console.print(table)
    console.print("* computed from numbers that the paper prints")
    open_ = sum(entry.is_unexplained for entry in claims)
    said = f", {open_} of them without an explanation" if open_ else " and are explained"
    console.print(f"{len(claims)} claims: {claim.counted(claim.tally(claims))}{said}.")
    console.print("In-silico: the bench is a simulated one.")
    console.print(f"Report: {folder / 'report.html'}", soft_wrap=True)


COMMAND = Command(
    name="reproduce",
    options=ReproduceOptions,
    run=delivering("reproduce", "Reproducing", _compute),
    sentence="The paper's figures 5 to 11 and tables I and II on the twin, each number beside its "
    "own.",
    details="Every claim says whether the paper prints its number, whether the twin was calibrated "
    "to it or predicts it, and how far the two may be apart by the scatter of both. Agreement that "
    "was calibrated, or that a measurement of nothing would reach as well, is no evidence.",
    examples="""\b
Examples:
  opensuction reproduce                      reports and figures under runs/
  opensuction reproduce --out paper          in a folder of your own
  opensuction reproduce --json | jq .table1  Table I, the paper's and ours""",
    ends="0 every claim agrees or its difference is explained, 1 one differs without",
)
