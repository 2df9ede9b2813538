"""The ``reproduce`` command: the paper's tables and figures on the twin, side by side."""

import json
import time
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from opensuction.cli import output_folder
from opensuction.cli.cycle import interruptible


class Options(NamedTuple):
    """Options of the command as a person gave them."""

    out: Path | None
    force: bool
    as_json: bool


def run(options: Options) -> int:
    """Carry the command out; returns the exit status. Raises InputError for bad input."""
    began_s = time.monotonic()
    console = Console(stderr=options.as_json, highlight=False)
    folder = output_folder.chosen(options.out, "reproduce")
    with output_folder.whole(folder, options.force) as staging:
        console.print("The paper reproduced on the digital twin: some ten seconds")
        # Heavy imports, after the first line is out.
        from opensuction.evidence.paper import reproduction
        from opensuction.kernel import compiled
        from opensuction.report import sheet

        if compiled.is_cold():
            console.print("Compiling the control core: once for this version, about a minute")
        found = interruptible(lambda: reproduction.run(console.print))
        data = reproduction.plain(found, time.monotonic() - began_s)
        (staging / "report.html").write_text(sheet.render(found.sheet), encoding="utf-8")
        (staging / "reproduce.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    if options.as_json:
        print(json.dumps(data))  # noqa: T201 - the one object of --json
    else:
        _summarise(console, data, folder)
    return 1 if any(entry["verdict"] == "differs" for entry in data["claims"]) else 0


def _summarise(console: Console, data: dict[str, object], folder: Path) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("claim", ratio=1)
    for column in ("paper", "here", "+-"):
        table.add_column(column, justify="right", no_wrap=True)
    for column in ("unit", "verdict"):
        table.add_column(column, no_wrap=True)
    claims = data["claims"]
    assert isinstance(claims, list)
    for entry in claims:
        here = "-" if entry["measured"] is None else f"{entry['measured']:.4g}"
        table.add_row(
            f"{entry['name']} ({entry['where']})",
            f"{entry['paper']:.4g}",
            here,
            f"{entry['tolerance']:g}",
            entry["unit"],
            entry["verdict"],
        )
    console.print(table)
    held = sum(entry["ok"] for entry in claims)
    console.print(f"{held} of {len(claims)} claims hold. In-silico: the bench is a simulated one.")
    console.print(f"Report: {folder / 'report.html'}", soft_wrap=True)
