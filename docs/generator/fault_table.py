"""The faults of the twin as a table for each part that is attacked."""

from opensuction.twin.fault.fault import FaultSite
from opensuction.twin.fault.fault_row import FaultRow, Strength
from opensuction.twin.fault.fault_table import ROWS

COLUMNS = ("no.", "name", "what it is", "strength", "default", "what can tell it")
HEADER = f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|\n"


def _strength(known: Strength | None) -> tuple[str, str]:
    if known is None:
        return "", ""
    unit = "" if known.unit == "1" else f" {known.unit}"
    return (
        f"{known.meaning}, {known.least:g} to {known.most:g}{unit}",
        f"{known.default:g}{unit}",
    )


def _row(row: FaultRow) -> str:
    """A row of the table; * marks those whose loop is compiled on first use."""
    mark = " *" if row.is_linked else ""
    strength, default = _strength(row.strength)
    detected_by = row.detected_by or "nothing, as long as it is alone"
    return (
        f"| {int(row.fault)} | `{row.fault.title}`{mark} | {row.meaning} | {strength} "
        f"| {default} | {detected_by} |\n"
    )


def markdown() -> str:
    """A table for each part that is attacked."""
    parts = []
    for part in FaultSite:
        rows = [_row(row) for row in ROWS.values() if row.fault.site == part]
        if rows:
            title = part.name.capitalize().replace("_", " ")
            parts.append(f"### {title}\n\n{HEADER}{''.join(rows)}")
    return "\n".join(parts)
