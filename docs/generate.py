"""Writes anew what the documentation takes from the code; tests compare the two."""

from pathlib import Path

from opensuction.procedure import diagram
from opensuction.settings import parameter_page

DOCS = Path(__file__).resolve().parent


def example(name: str) -> str:
    """Text of one of the example files."""
    return (DOCS / "examples" / name).read_text(encoding="utf-8")


parameters = parameter_page.page(example("machine.toml"), example("patient.toml"))
(DOCS / "parameters.md").write_text(parameters, encoding="utf-8")
(DOCS / "phases.md").write_text(diagram.page(), encoding="utf-8")
