"""All that a controller is set to, as one thing: kept, compared, hashed, and read back bit for bit.

A recording holds it as text, replay reads it from there, and whoever embeds the controller may
keep it beside the machine that it was made for.
"""

import hashlib
import json
import math
from typing import Any, NamedTuple

import numpy as np

from opensuction.control.compensation import (
    ON_CURVES,
    ON_TABLE,
    Branches,
    CompensationKind,
)
from opensuction.controller import record
from opensuction.controller.record import Settings
from opensuction.hysteresis.bank import play_lines
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import name_of

WHERE = "controller settings"
"""Opens every message."""
LEAST_ENTRIES = 2
"""Of a branch: two make a line."""
MOST_NUMBERS = 10_000
"""Of a table: three times those of the largest that is identified, 40 plays of 40 cells, whose tick
stays within its period [design]."""


class Configuration(NamedTuple):
    """Settings, and the curves that some compensators go by."""

    settings: Settings
    heads_mm: Branches | None = None
    """Branches of the compensation's curves, or its model's table; None where it has neither."""


def check(configuration: Configuration) -> None:
    """Refuse numbers that are none, and curves that the compensator has no use for, or lacks.

    Raises InputError.
    """
    settings, heads_mm = configuration
    record.check(settings)
    kind = settings.compensation.kind
    if kind not in list(CompensationKind):
        raise InputError(f"{WHERE}: compensation.kind is {kind}: no compensator has that number")
    name = name_of(CompensationKind(kind))
    if (kind in ON_TABLE) != (heads_mm is not None):
        needs = "curves, and there are none" if kind in ON_CURVES else "a table, and there is none"
        lacks = f"needs {needs}" if heads_mm is None else "goes by no curves"
        raise InputError(f"{WHERE}: compensation '{name}' {lacks}: see heads_mm")
    if heads_mm is not None:
        numbers = np.asarray(heads_mm)
        if not np.isfinite(numbers).all():
            raise InputError(f"{WHERE}: heads_mm has a number that is not finite")
        if kind in ON_CURVES:
            _check_branches(numbers)
        else:
            _check_table(numbers)


def _check_branches(heads_mm: Branches) -> None:
    if heads_mm.ndim != 2 or heads_mm.shape[0] != 2 or heads_mm.shape[1] < LEAST_ENTRIES:
        raise InputError(
            f"{WHERE}: heads_mm is {_shape(heads_mm)} numbers: should be two branches of "
            f"{LEAST_ENTRIES} entries or more"
        )


def _shape(numbers: Branches) -> str:
    return " x ".join(map(str, numbers.shape))


def _check_table(table: Branches) -> None:
    if table.ndim != 2 or table.shape[0] < 2 or table.shape[1] < 4 or table.shape[1] % 2:
        raise InputError(
            f"{WHERE}: heads_mm is {_shape(table)} numbers: should be a row for the model and one "
            "for each play, of 2 numbers and 2 for each cell"
        )
    if table.size > MOST_NUMBERS:
        raise InputError(
            f"{WHERE}: heads_mm is {_shape(table)} numbers: should be at most {MOST_NUMBERS}"
        )
    reason = play_lines.why_not_driven(play_lines.to_lines(table))
    if reason is not None:
        raise InputError(f"{WHERE}: no head can be driven by the model of heads_mm: {reason}")


def to_json(configuration: Configuration) -> str:
    """One line of JSON, the same for the same configuration, whoever writes it.

    Keys are sorted, and nothing is between them: what `hash_of` is of.
    """
    settings, heads_mm = configuration
    whole = {
        "heads_mm": None if heads_mm is None else np.asarray(heads_mm, np.float64).tolist(),
        "settings": plain_row.write(Settings, settings),
    }
    return json.dumps(whole, sort_keys=True, separators=(",", ":"), allow_nan=False)


def hash_of(configuration: Configuration) -> str:
    """SHA-256 of its JSON, 64 hexadecimal digits: any field that differs in a bit changes it."""
    return hashlib.sha256(to_json(configuration).encode()).hexdigest()


def from_json(text: str) -> Configuration:
    """The configuration that was written, bit for bit; checked.

    Raises InputError for text that is not JSON, fields that are missing or not known, and what
    `check` refuses.
    """
    try:
        whole = json.loads(text, object_pairs_hook=_object, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as problem:
        raise InputError(f"{WHERE}: no JSON: {problem}") from problem
    if not isinstance(whole, dict) or whole.keys() != {"heads_mm", "settings"}:
        raise InputError(f"{WHERE}: should be an object of 'heads_mm' and 'settings'")
    settings = plain_row.read(Settings, whole["settings"], WHERE)
    found = Configuration(settings, _branches(whole["heads_mm"]))
    check(found)
    return found


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON that names nothing twice."""
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("a field is there twice")
    return found


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _branches(found: Any) -> Branches | None:
    if found is None:
        return None
    numbers = isinstance(found, list) and all(
        isinstance(branch, list) and all(type(one) in (int, float) for one in branch)
        for branch in found
    )
    if not numbers or len({len(branch) for branch in found}) != 1:
        raise InputError(f"{WHERE}: heads_mm should be null or lists of as many numbers")
    return np.array([[_finite(one) for one in branch] for branch in found])


def _finite(number: float) -> float:
    try:
        return float(number)
    except OverflowError:  # a whole number of hundreds of digits
        return math.inf
