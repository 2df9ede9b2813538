"""The fields of a protocol for a form: unit, range, meaning and source, from the same settings."""

from functools import cache
from typing import Any, NamedTuple, get_type_hints

from pydantic import TypeAdapter

from opensuction.kernel.meaning import Meaning
from opensuction.kernel.unit import unit_of
from opensuction.procedure.planning import guideline
from opensuction.procedure.planning.clinical import TEMPLATE_SOURCES
from opensuction.procedure.planning.protocol import PAPER_SOURCES, Protocol
from opensuction.settings.limit import trim

FIXED = "bench_only"
"""Belongs to the machine: nobody sets it in a form."""
LIMITS = ("cap_mm", "contact_from_mm", "negative_pressure_budget_s", "in_airway_budget_s")
"""What the governor holds: changed by an engineer, with a reason."""
OF_TEMPLATE = {
    "travel_mm": "stop_short_mm",
    "cap_mm": "cap_margin_mm",
    "contact_from_mm": "window_mm",
    "backoff_mm": "backoff_mm",
    "insertion_mm_per_s": "insertion_mm_per_s",
    "withdrawal_mm_per_s": "withdrawal_mm_per_s",
    "nothing_comes_s": "nothing_comes_s",
    "vacuum_mmhg": "vacuum_mmhg",
}
"""Value of a clinical protocol that a field is made from."""
OF_GUIDELINE = {
    "vacuum_mmhg": "vacuum_mmhg",
    "dwell_s": "negative_pressure_s",
    "negative_pressure_budget_s": "negative_pressure_s",
    "in_airway_budget_s": "in_airway_s",
    "insertion_mm_per_s": "speed_mm_per_s",
}
"""Guideline that a field is held against."""


class FormField(NamedTuple):
    """One field."""

    name: str
    unit: str
    meaning: str
    least: float
    is_above: bool
    """The value must be above ``least``; otherwise it may be as small."""
    most: float
    is_limit: bool
    """Only an engineer changes it."""
    default_source: str
    """Where the value of a preset comes from."""
    guideline: str
    """Guideline that it is held against, by name; empty for none."""


@cache
def fields() -> tuple[FormField, ...]:
    """All that a person sets, in the order of the settings."""
    hints = get_type_hints(Protocol, include_extras=True)
    return tuple(_field(name, hints[name]) for name in Protocol._fields if name != FIXED)


def _field(name: str, hint: Any) -> FormField:
    schema = TypeAdapter[Any](hint).json_schema()
    is_above = "exclusiveMinimum" in schema
    return FormField(
        name=name,
        unit=unit_of(name),
        meaning=next(one.text for one in hint.__metadata__ if isinstance(one, Meaning)),
        least=trim(schema["exclusiveMinimum" if is_above else "minimum"]),
        is_above=is_above,
        most=trim(schema["maximum"]),
        is_limit=name in LIMITS,
        default_source=_source(name),
        guideline=OF_GUIDELINE.get(name, ""),
    )


def _source(name: str) -> str:
    """Of a clinical protocol's value; of what follows from it, the guideline; else the paper's."""
    if name in OF_TEMPLATE:
        return TEMPLATE_SOURCES[OF_TEMPLATE[name]]
    if name in OF_GUIDELINE:
        return guideline.SOURCES[OF_GUIDELINE[name]]
    return PAPER_SOURCES[name]
