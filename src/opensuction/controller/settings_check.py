"""Whether settings are numbers that can be held: a limit of nan is broken by nothing."""

import math
from collections.abc import Iterator
from typing import Any

from opensuction.controller.record import Settings
from opensuction.kernel.errors import InputError

OPEN = (
    "limits.line.clogged_share",
    "limits.mouth_mm",
    "limits.window.from_mm",
    "limits.window.by_mm",
    "plan.contact.suction_mm",
    "plan.limits_s",
)
"""What may be infinite: a line that cannot be told to be clogged, the light barrier of a bench that
has none, a window as wide as the way, suction where the tip stopped, and phases that wait for a
person."""


def _numbers(record: tuple[Any, ...], path: str) -> Iterator[tuple[str, float]]:
    """Every number with where it stands; those of a plain tuple under its own name."""
    names = getattr(record, "_fields", None)
    for i, value in enumerate(record):
        inner = path if names is None else f"{path}.{names[i]}".lstrip(".")
        if isinstance(value, tuple):
            yield from _numbers(value, inner)
        elif isinstance(value, float):
            yield inner, value


def check(settings: Settings) -> None:
    """Refuse settings in which a number is none, or without bound where there must be one.

    Raises InputError, which names it.
    """
    for path, value in _numbers(settings, ""):
        if math.isnan(value) or (math.isinf(value) and path not in OPEN):
            raise InputError(f"settings.{path} is {value}: it must be a finite number")
