"""The parameters of the patients as a table for the documentation: `docs/patient.md` holds it."""

from opensuction.twin.parameter import Parameter
from opensuction.twin.patient_parameter import PRESETS, ROWS


def _cell(parameter: Parameter) -> str:
    spread = f" ± {parameter.spread:.4g}" if parameter.spread else ""
    return f"{parameter.value:.5g}{spread}"


def markdown() -> str:
    """All parameters as a Markdown table: one line each, one column for each preset."""
    lines = [
        f"| parameter | {' | '.join(PRESETS)} | unit | meaning | source |",
        "|---" * (len(PRESETS) + 4) + "|",
    ]
    for name, row in ROWS.items():
        cells = " | ".join(_cell(parameter) for parameter in row)
        lines.append(f"| `{name}` | {cells} | {row[0].unit} | {row[0].meaning} | {row[0].source} |")
    return "\n".join(lines) + "\n"
