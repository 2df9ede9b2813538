"""Writes anew what the documentation takes from the code; tests compare the two."""

from pathlib import Path

from opensuction.procedure import diagram
from opensuction.safety import alarm_table
from opensuction.twin import parameter_table, patient_table

DOCS = Path(__file__).resolve().parent
TABLES = {
    "alarms.md": alarm_table.markdown(),
    "twin.md": parameter_table.machines(),
    "patient.md": patient_table.markdown(),
}

for name, table in TABLES.items():
    page = DOCS / name
    text = parameter_table.spliced(page.read_text(encoding="utf-8"), table)
    page.write_text(text, encoding="utf-8")
(DOCS / "phases.md").write_text(diagram.page(), encoding="utf-8")
