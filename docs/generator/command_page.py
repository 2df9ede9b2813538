"""The page of all commands, from what they say of themselves with ``--help``."""

from typer import Typer
from typer.main import get_command
from typer.testing import CliRunner

WIDTH = 96
"""Characters in a line."""
PAGE = """# Commands

Help texts of all commands, as `--help` prints them. All of them take `--json`, described in \
[results](results.md), and write a report that opens in any browser. Everything they show is \
in-silico, but for the figures of a recording of your own.

"""


def page(app: Typer) -> str:
    """A section for each command of an application."""
    names = ["", *getattr(get_command(app), "commands", {})]
    sections = []
    for name in names:
        words = [name] if name else []
        shown = CliRunner().invoke(
            app, [*words, "--help"], prog_name="opensuction", terminal_width=WIDTH
        )
        text = "\n".join(line.rstrip() for line in shown.output.splitlines()).strip()
        sections.append(f"## {name or 'opensuction'}\n\n```text\n{text}\n```\n")
    return PAGE + "\n".join(sections)
