"""Alarms as tables: priorities, conditions, sound and light."""

import math

from opensuction.safety.alarm.alarm_signal import (
    EDGE_SHARE,
    HARMONIC_DB,
    HARMONICS,
    HIGH,
    HIGH_LIGHT,
    LOW,
    LOW_LIGHT,
    MEDIUM,
    MEDIUM_LIGHT,
    REMINDER,
    Light,
    Tone,
    Value,
)
from opensuction.safety.condition import Condition
from opensuction.safety.handling import PRIORITIES, Onset, Severity

CONDITIONS_HEADER = (
    "| no. | condition | priority | latches | delay | rises after | in planned work "
    "| what a person reads, and the remedy |\n|---|---|---|---|---|---|---|---|\n"
)
VALUES_HEADER = "| value | chosen | range | unit | range from |\n|---|---|---|---|---|\n"


def _of_tone(name: str, tone: Tone) -> dict[str, Value]:
    return {
        f"{name}: fundamental": tone.fundamental_hz,
        f"{name}: pulse": tone.pulse_s,
        f"{name}: pause between pulses": tone.pause_s,
        **({f"{name}: pause between halves": tone.half_pause_s} if tone.halves > 1 else {}),
        f"{name}: interval of bursts": tone.interval_s,
    }


def _of_light(name: str, light: Light) -> dict[str, Value]:
    return {f"{name}: flashing": light.flash_hz, f"{name}: lit": light.duty_ratio}


VALUES: dict[str, Value] = {
    **_of_tone("high sound", HIGH),
    **_of_tone("medium sound", MEDIUM),
    **_of_tone("low sound", LOW),
    **_of_tone("reminder", REMINDER),
    "every sound: rise and fall": EDGE_SHARE,
    "every sound: harmonics": HARMONICS,
    "every sound: level": HARMONIC_DB,
    **_of_light("high light, red", HIGH_LIGHT),
    **_of_light("medium light, yellow", MEDIUM_LIGHT),
    **_of_light("low light, cyan", LOW_LIGHT),
}
"""Every value of sound and light by name."""


def _seconds(value_s: float) -> str:
    return f"{value_s:g} s" if value_s > 0.0 else ""


def _condition(condition: Condition) -> str:
    sentence, remedy, handling = condition.row
    return (
        f"| {int(condition)} | `{condition.name}` | {handling.priority.name.lower()} "
        f"| {'yes' if handling.latching else ''} | {_seconds(handling.delay_s)} "
        f"| {_seconds(handling.escalates_s)} | {'none' if handling.planned else ''} "
        f"| {sentence}. *{remedy}* |\n"
    )


def conditions() -> str:
    """Every condition, in the order of its number."""
    return CONDITIONS_HEADER + "".join(_condition(condition) for condition in sorted(Condition))


def matrix() -> str:
    """Priority by severity and onset."""
    onsets = sorted(Onset, reverse=True)
    header = "| | " + " | ".join(onset.name.lower() for onset in onsets) + " |\n"
    rows = (
        f"| {severity.name.lower()} | "
        + " | ".join(PRIORITIES[severity, onset].name.lower() for onset in onsets)
        + " |\n"
        for severity in sorted(Severity, reverse=True)
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
