"""Writes anew what the documentation takes from the code; tests compare the two."""

from pathlib import Path

from opensuction.twin import parameter_table
from opensuction.twin.parameter import BENCH

DOCS = Path(__file__).resolve().parent

twin = DOCS / "twin.md"
table = parameter_table.markdown(BENCH)
twin.write_text(parameter_table.spliced(twin.read_text(encoding="utf-8"), table), encoding="utf-8")
