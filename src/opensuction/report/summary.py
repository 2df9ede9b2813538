"""Reading the summary of a cycle: the JSON object of the ``cycle`` command, with gaps.

A value that was not simulated or not measured is ``null``; a reader may also meet a summary of
another version that lacks a key. Both read as None here.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

Summary = Mapping[str, Any]
"""Keys: see ``cycle`` in the command reference."""


def value(summary: Summary, *path: str) -> Any:
    """What lies at a path of keys, or None where a part of it is missing.

    >>> value({"tip": {"target_mm": 90.0}}, "tip", "target_mm")
    90.0
    >>> value({"tip": None}, "tip", "target_mm") is None
    True
    """
    found: Any = summary
    for key in path:
        if not isinstance(found, Mapping):
            return None
        found = found.get(key)
    return found


def number(summary: Summary, *path: str) -> float | None:
    """Finite number at a path of keys, or None."""
    found = value(summary, *path)
    if isinstance(found, bool) or not isinstance(found, int | float):
        return None
    return float(found) if math.isfinite(found) else None


def text(summary: Summary, *path: str) -> str | None:
    """Text at a path of keys, or None where there is none."""
    found = value(summary, *path)
    return None if found is None else str(found)


def write_seed(summary: Summary) -> str | None:
    """Seed by which machine and patient were drawn, and how far where that was not as usual.

    None where nothing was drawn.
    """
    seed, spread = text(summary, "seed"), number(summary, "spread")
    if seed is None or spread is None or spread == 1.0:
        return seed
    return f"{seed}, spread x {spread:g}"


def rows(summary: Summary, key: str) -> list[Mapping[str, Any]]:
    """List of objects at a key (phases, trips, alarms); empty where it is missing."""
    found = value(summary, key)
    if isinstance(found, str) or not isinstance(found, Sequence):
        return []
    return [entry for entry in found if isinstance(entry, Mapping)]


def warnings(summary: Summary) -> list[str]:
    """Sentences of warning; empty where there are none."""
    found = value(summary, "warnings")
    if isinstance(found, str) or not isinstance(found, Sequence):
        return []
    return [str(entry) for entry in found]


def is_recorded(summary: Summary) -> bool:
    """Whether it goes by what a machine measured and estimated, not by the truth of a twin."""
    return text(summary, "basis") == "recorded"


def is_completed(summary: Summary) -> bool:
    """Whether the cycle ran to its planned end."""
    return text(summary, "outcome") == "completed"


def is_inside(summary: Summary) -> bool:
    """Whether the catheter was left in the airway, by the truth, whatever the outcome."""
    return value(summary, "tip", "inside_at_end") is True


def harms(summary: Summary) -> list[str]:
    """Names of the bounds for the patient that were broken, by the oracle; empty where none was."""
    found = value(summary, "harm")
    if isinstance(found, str) or not isinstance(found, Sequence):
        return []
    return [str(entry) for entry in found]


def is_good(summary: Summary) -> bool:
    """Whether the cycle ran to its planned end, the catheter is out, and no bound was broken."""
    return is_completed(summary) and not is_inside(summary) and not harms(summary)


def flatten(entries: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Leaves of nested mappings as (dotted name, value), in order.

    >>> flatten({"model": {"slope": 0.97}, "rmse_mm": 0.84})
    [('model.slope', 0.97), ('rmse_mm', 0.84)]
    """
    leaves: list[tuple[str, Any]] = []
    for key, entry in entries.items():
        name = f"{prefix}{key}"
        if isinstance(entry, Mapping):
            leaves.extend(flatten(entry, f"{name}."))
        else:
            leaves.append((name, entry))
    return leaves
