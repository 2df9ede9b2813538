"""Writes anew what the documentation takes from the code; tests compare the two."""

import json
from pathlib import Path

from opensuction.evidence import fault_page, hazard_page
from opensuction.evidence.benchmark import benchmark_page
from opensuction.hysteresis import loop_picture, model_table
from opensuction.procedure import diagram
from opensuction.report.document import spliced
from opensuction.safety.alarm import alarm_table
from opensuction.settings import parameter_page

DOCS = Path(__file__).resolve().parent
BENCHMARK = DOCS / "evidence" / "2026-11-21-benchmark.json"
"""What `opensuction benchmark --json` gave."""
TABLES = {
    "alarms.md": alarm_table.markdown(),
    "benchmark.md": benchmark_page.markdown(json.loads(BENCHMARK.read_text(encoding="utf-8"))),
    "faults.md": fault_page.markdown(),
    "hazard-analysis.md": hazard_page.markdown(),
    "hysteresis.md": model_table.markdown(),
}
"""Pages with a table between two marks."""


def example(name: str) -> str:
    """Text of one of the example files."""
    return (DOCS / "examples" / name).read_text(encoding="utf-8")


for name, table in TABLES.items():
    page = DOCS / name
    page.write_text(spliced(page.read_text(encoding="utf-8"), table), encoding="utf-8")
parameters = parameter_page.page(example("machine.toml"), example("patient.toml"))
(DOCS / "parameters.md").write_text(parameters, encoding="utf-8")
(DOCS / "phases.md").write_text(diagram.page(), encoding="utf-8")
(DOCS / "pictures" / "hysteresis-loops.svg").write_text(loop_picture.svg(), encoding="utf-8")
