"""Texts of ``opensuction trial``: examples for its help, summary, remaining time."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.result.trial_result import TrialResult, Violation

SHOWN = 10
"""Violations and false alarms that the terminal lists; all are in the file."""

EXAMPLES = """\b
Examples:
  opensuction trial --cycles 1000                 a fault each: some minutes
  opensuction trial --cycles 1000 --faults none   false alarms
  opensuction trial --cycles 100000 --faults double --out runs/double
  opensuction trial --resume --out runs/double    go on after Ctrl-C
  opensuction trial --cycles 200 --cohort neonate --seed 7
  opensuction trial --play 4711 --faults double   one of its cycles again
  opensuction trial --cycles 500 --json | jq '.violations[].play'

\b
The folder holds trial.md (the page), trial.json (all figures) and
trial-parts.jsonl (every cycle; what --resume goes on from)."""


def say_time(seconds: float) -> str:
    """A time in words: how long something takes still."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 5400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"


def violation(one: "Violation") -> str:
    """A bound that was broken, and what plays its cycle again."""
    faults = " + ".join(one.faults) or "no fault"
    worst = "no number" if one.worst is None else f"{one.worst:.3g}"
    return (
        f"  {one.number}: {faults}, {one.patient} by {one.approach}: {one.bound} "
        f"{worst}, limit {one.limit:.3g}\n    {one.play}"
    )


def summarise(console: "Console", result: "TrialResult", folder: Path) -> None:
    """Print what a trial came to. folder: holds its files."""
    from rich.table import Table

    from opensuction.evidence.trial import trial_page

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("held against", ratio=1)
    for column in ("cycles", "broken", "share at most (95 %)"):
        table.add_column(column, justify="right", no_wrap=True)
    for words, one in trial_page.list_held(result.bounds):
        if one.cycles:
            style = "bold red" if one.broken else None
            share = f"{one.upper_percent:.2g} %"
            table.add_row(words, f"{one.cycles:,}", f"{one.broken:,}", share, style=style)
    console.print(table)
    for sentence in _sentences(result):
        for line in sentence.splitlines():
            console.print(line, soft_wrap=True)
    console.print(f"Page: {folder / 'trial.md'}, figures: {folder / 'trial.json'}", soft_wrap=True)


def _sentences(result: "TrialResult") -> Iterator[str]:
    """Sentences below the table in the terminal."""
    left = result.left_inside.total
    if left.count:
        yield (
            f"Left inside at the end: {left.count:,} of {result.cycles:,} cycles; "
            f"{left.unavoidable:,} of them nothing could have prevented, {left.told:,} were "
            "told high in time."
        )
    else:
        yield "Left inside at the end: none."
    shown = [violation(one) for one in result.violations[:SHOWN]]
    if shown:
        yield f"Violations ({len(result.violations)}), each with what plays it again:"
        yield from shown
    loud = [one for one in result.said if one.false]
    if loud:
        yield f"Said of sound cycles and not so ({len(loud)}):"
    for one in loud[:SHOWN]:
        words = ", ".join(one.false)
        cycle = f"{one.number}: {one.patient} by {one.approach}"
        yield f"  {cycle}: {words}\n    {one.play}"
    if len(result.violations) > SHOWN or len(loud) > SHOWN:
        yield "All of them are in the page and in the figures."
    if result.cycles_per_s:
        rate = f"{result.cycles_per_s:.1f} cycles a second"
        yield f"{rate}. In-silico: the machine is a simulated one."
