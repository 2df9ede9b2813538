"""Faults as a table for the documentation: `docs/faults.md` holds its text."""

from opensuction.twin.fault.fault import Fault, Means, Part
from opensuction.twin.fault.fault_table import KINDS, FaultKind, Strength

COLUMNS = ("no.", "name", "what it is", "strength", "default", "what can tell it")
HEADER = f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|\n"
MEANS = {
    Means.MACHINE: "",
    Means.READING: " *",
    Means.LINK: " *",
    Means.SETTING: "",
}
"""Mark of those whose loop is compiled on first use."""


def _strength(known: Strength | None) -> tuple[str, str]:
    if known is None:
        return "", ""
    unit = "" if known.unit == "1" else f" {known.unit}"
    return (
        f"{known.meaning}, {known.least:g} to {known.most:g}{unit}",
        f"{known.default:g}{unit}",
    )


def _row(fault: Fault, kind: FaultKind) -> str:
    strength, default = _strength(kind.strength)
    told = kind.told if kind.told else "nothing, as long as it is alone"
    return (
        f"| {int(fault)} | `{fault.title}`{MEANS[kind.means]} | {kind.meaning} | {strength} "
        f"| {default} | {told} |\n"
    )


def markdown() -> str:
    """A table for each part that is attacked."""
    parts = []
    for part in Part:
        rows = [_row(fault, kind) for fault, kind in KINDS.items() if kind.part == part]
        if rows:
            title = part.name.capitalize().replace("_", " ")
            parts.append(f"### {title}\n\n{HEADER}{''.join(rows)}")
    return "\n".join(parts)
