"""Writes anew what the documentation takes from the code; tests compare the two."""

from pathlib import Path

from opensuction.hysteresis import loop_picture, model_table
from opensuction.procedure import diagram
from opensuction.twin import parameter_table, patient_table

DOCS = Path(__file__).resolve().parent
TABLES = {
    "twin.md": parameter_table.machines(),
    "patient.md": patient_table.markdown(),
    "hysteresis.md": model_table.markdown(),
}

for name, table in TABLES.items():
    page = DOCS / name
    text = parameter_table.spliced(page.read_text(encoding="utf-8"), table)
    page.write_text(text, encoding="utf-8")
(DOCS / "phases.md").write_text(diagram.page(), encoding="utf-8")
(DOCS / "pictures" / "hysteresis-loops.svg").write_text(loop_picture.svg(), encoding="utf-8")
