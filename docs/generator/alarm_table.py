"""Alarms as tables: priorities, conditions, sound and light."""

import math

from opensuction.safety.alarm_condition import KINDS, PRIORITIES, Condition, Harm, Kind, Onset
from opensuction.safety.alarm_text import TEXTS
from opensuction.safety.signal_value import VALUES, Value

CONDITIONS_HEADER = (
    "| no. | condition | priority | latches | delay | rises after | in planned work "
    "| what a person reads, and the remedy |\n|---|---|---|---|---|---|---|---|\n"
)
VALUES_HEADER = "| value | chosen | range | unit | range from |\n|---|---|---|---|---|\n"


def _seconds(value_s: float) -> str:
    return f"{value_s:g} s" if value_s > 0.0 else ""


def _condition(condition: Condition, kind: Kind) -> str:
    text = TEXTS[condition]
    return (
        f"| {int(condition)} | `{condition.name}` | {kind.priority.name.lower()} "
        f"| {'yes' if kind.latching else ''} | {_seconds(kind.delay_s)} "
        f"| {_seconds(kind.escalates_s)} | {'none' if kind.planned else ''} "
        f"| {text.sentence}. *{text.remedy}* |\n"
    )


def conditions() -> str:
    """Every condition, in the order of its number."""
    rows = (_condition(condition, KINDS[condition]) for condition in Condition)
    return CONDITIONS_HEADER + "".join(rows)


def matrix() -> str:
    """Priority by harm and onset."""
    onsets = sorted(Onset, reverse=True)
    header = "| | " + " | ".join(onset.name.lower() for onset in onsets) + " |\n"
    rows = (
        f"| {harm.name.lower()} | "
        + " | ".join(PRIORITIES[harm, onset].name.lower() for onset in onsets)
        + " |\n"
        for harm in sorted(Harm, reverse=True)
    )
    return header + "|---" * (len(onsets) + 1) + "|\n" + "".join(rows)


def _range(value: Value) -> str:
    if math.isinf(value.most):
        return f"{value.least:g} or more"
    if value.least == value.most:
        return f"{value.least:g}"
    return f"{value.least:g} to {value.most:g}"


def values() -> str:
    """Every value of sound and light, with its range and where that is from."""
    rows = (
        f"| {name} | {value.value:g} | {_range(value)} | {value.unit} | {value.source} |\n"
        for name, value in VALUES.items()
    )
    return VALUES_HEADER + "".join(rows)


def markdown() -> str:
    """All tables under their headings."""
    return (
        f"## Priority by harm and onset\n\n{matrix()}\n"
        f"## Conditions\n\n{conditions()}\n"
        f"## Sound and light\n\n{values()}"
    )
