"""The page's tables: each threshold, what stands near, and what was measured of whole cycles."""

import json
import math
from pathlib import Path
from typing import Any

from docs.generator.document import table
from docs.generator.safety.tolerance import drive, duration, head, line, noise, pre_use, valve
from docs.generator.safety.tolerance.duration import Duration
from docs.generator.safety.tolerance.left_out import LEFT_OUT
from docs.generator.safety.tolerance.sensor_error import IDEAL
from docs.generator.safety.tolerance.threshold import (
    Chance,
    Constant,
    Distance,
    Threshold,
    stand_largest,
    stand_worst,
    value_of,
)
from opensuction.safety.head import drive_force
from opensuction.safety.watch import head_watch, vacuum_signature
from opensuction.twin.fault.fault import Fault
from opensuction.twin.parameter import SENSORS

Measured = dict[str, Any]
MEASURED = Path(__file__).resolve().parents[3] / "evidence" / "2026-11-23-tolerance.json"
NEAR_PER_H = 1e-3
"""False trips an hour from which a threshold is named as near."""
LEAST_PER_H = 1e-9
UNSEEN = 3.0
"""Upper bound, 95 %, of what was not seen once."""
FOLLOWS = ("AUTOMATION_STOPPED", "CHECK_FAILED")
"""Alarms that only say that a cycle or a pre-use test has ended."""
HUM_HZ = 50.0


def measured() -> Measured:
    """What the campaign wrote."""
    found: Measured = json.loads(MEASURED.read_text(encoding="utf-8"))
    return found


def _number(value: float) -> str:
    return f"{value:.3g}"


def _named(constants: tuple[Constant, ...]) -> str:
    values = ", ".join(f"`{name}` {_number(value_of((file, name)))}" for file, name in constants)
    return f"{values} ({', '.join(dict.fromkeys(f'`{file}`' for file, _ in constants))})"


def _faults(faults: tuple[Fault, ...]) -> str:
    return ", ".join(f"`{fault.title}`" for fault in faults)


def _distance(threshold: Threshold, found: Distance) -> str:
    if threshold.chance == Chance.LATE:
        return f"{threshold.ticks} in a row"
    left = f"{_number(found.left)} {threshold.unit} left"
    if found.left <= 0.0:
        return f"**reached** ({left})"
    return f"{left}, {_number(found.sigmas)} sigma" if math.isfinite(found.sigmas) else left


def _per_h(found: Distance) -> str:
    if found.left <= 0.0:
        return "**reached**"
    if found.per_h == 0.0:
        return "0"
    if found.per_h < LEAST_PER_H:
        return f"< {LEAST_PER_H:g}"
    shown = f"{found.per_h:.1e}"
    return f"**{shown}**" if found.per_h > NEAR_PER_H else shown


def _bears(threshold: Threshold, found: Distance) -> str:
    if threshold.chance == Chance.LATE:
        return threshold.because
    return f"{_borne(found)}: {threshold.because}"


def _borne(found: Distance) -> str:
    return f"sigma {_number(found.borne.sigma)}, static {_number(found.borne.static)}"


def _count(times: int) -> str:
    return f"0 (< {UNSEEN:g})" if times == 0 else f"**{times}**"


def _simulated(threshold: Threshold, hours: Measured) -> str:
    if not threshold.simulated:
        return "in cycles only"
    row = hours[threshold.simulated]
    if "tests" in row:
        return f"{row['worst']} of {row['tests']:,} tests; {row['largest']}"
    return f"{_count(row['worst'])}; {_count(row['largest'])}"


def _threshold_row(threshold: Threshold, hours: Measured) -> tuple[str, ...]:
    worst, (name, largest) = stand_worst(threshold), stand_largest(threshold)
    return (
        _named(threshold.constants),
        f"{threshold.compared}; {_number(threshold.margin)} {threshold.unit}",
        _bears(threshold, worst),
        _distance(threshold, worst),
        _per_h(worst),
        f"`{name}`: {_distance(threshold, largest)}; {_per_h(largest)}",
        _simulated(threshold, hours),
        _faults(threshold.faults),
        f"{threshold.takes_s:.3g} s",
    )


COLUMNS = (
    "threshold (file)",
    "what is compared, how far it is from an ideal machine",
    "what it bears, worst machine drawn",
    "distance",
    "false trips/h, at most",
    "the file's value that brings nearest, alone at its largest: distance; false trips/h",
    "simulated trips in 1 h: worst drawn; largest noise",
    "catches",
    "in",
)


def _rows(rows: list[Threshold], hours: Measured) -> list[str]:
    return [*table(COLUMNS, (_threshold_row(row, hours) for row in rows)), ""]


def _duration_row(row: Duration) -> tuple[str, ...]:
    return (
        row.label or _named(row.constants),
        row.outlives,
        *(f"{_number(time_s)} s" for time_s in (row.waits_s, row.worst_s, row.largest_s)),
        _faults(row.faults),
        f"{_number(row.takes_s)} s",
        row.remark or "-",
    )


def _durations() -> list[str]:
    columns = ("threshold (file)", "must outlive", "waits", "longest drawn", "longest in a file")
    return [*table((*columns, "catches", "in", ""), map(_duration_row, duration.durations())), ""]


def thresholds() -> list[Threshold]:
    """All of them, in the order of the page."""
    of_line = line.thresholds() + pre_use.thresholds()
    return of_line + head.thresholds() + drive.thresholds() + valve.thresholds()


def near() -> list[Threshold]:
    """Thresholds that the worst machine drawn reaches, or nearly so, nearest first."""
    rows = [row for row in thresholds() if stand_worst(row).per_h > NEAR_PER_H]
    return sorted(rows, key=lambda row: stand_worst(row).sigmas)


def _near() -> list[str]:
    def show(row: Threshold) -> tuple[str, ...]:
        found = stand_worst(row)
        name = f"`{row.constants[0][1]}`"
        return (name, row.compared, _distance(row, found), _per_h(found))

    columns = ("threshold", "what is compared", "worst machine drawn", "false trips/h, at most")
    return [*table(columns, map(show, near())), ""]


def _what(found: Measured) -> str:
    """What went wrong, without what only follows from it."""
    said = {name.split()[-1]: count for name, count in reversed(found["what"].items())}
    named = [f"`{name}` {count}" for name, count in said.items() if name not in FOLLOWS]
    return ", ".join(reversed(named)) or "-"


def _wrong(found: Measured) -> str:
    shown = f"{found['wrong']} of {found['cycles']}"
    return f"**{shown}** ({_what(found)})" if found["wrong"] else shown


def _error_row(row: Measured) -> tuple[str, ...]:
    last, unit = row["rungs"][-1], SENSORS[row["error"]].unit.replace("1", "").strip()
    first = f"none up to x{last['multiple']:g}"
    if last["wrong"]:
        first = f"x{last['multiple']:g}: {_wrong(last)}"
    return (
        f"`{row['error']}`",
        f"{_number(row['rungs'][0]['error'])} {unit}".strip(),
        _wrong(row["rungs"][0]),
        f"{_number(row['largest_value'] - IDEAL.get(row['error'], 0.0))} {unit}".strip(),
        _wrong(row["largest"]),
        first,
    )


def _cycles(found: Measured) -> list[str]:
    words = {
        "sold": "as drawn",
        "lively": "the same, patients who cough, breathe, are moved",
        "worst": "every sensor error at once at 2.5 standard deviations",
        "largest": "every sensor error at once at the largest value of a file",
    }
    together = [(text, _wrong(found["together"][name])) for name, text in words.items()]
    corners = [
        (", ".join(f"`{part}` {_number(value)}" for part, value in row["values"].items()), row)
        for row in found["corners"].values()
    ]
    errors = ("error", "worst drawn", "went wrong", "largest", "went wrong", "first at")
    return [
        *table(("machines, each another", "went wrong"), together),
        "",
        *table(errors, map(_error_row, found["errors"])),
        "",
        *table(
            ("parts at 2.5 standard deviations at once", "went wrong"),
            ((text, _wrong(row)) for text, row in corners),
        ),
        "",
    ]


def _left_out() -> list[str]:
    rows = [
        (", ".join(f"`{name}`" for names in constants.values() for name in names), why)
        for why, constants in LEFT_OUT.items()
    ]
    return [*table(("constants", "why not"), rows), ""]


def _hum() -> list[str]:
    """What a hum of the sold noise's RMS becomes, against white noise."""
    filters = {
        "vacuum, `FILTER_S`": ("vacuum_noise_mmhg", vacuum_signature.FILTER_S),
        "force, `SPEED_WINDOW_S`": ("current_noise_a", head_watch.SPEED_WINDOW_S),
        "resistance, `SETTLING_S` alone": ("current_noise_a", drive_force.SETTLING_S),
    }
    rows = []
    for name, (error, time_s) in filters.items():
        rms, unit = SENSORS[error].value, SENSORS[error].unit
        hum = noise.hum(rms, HUM_HZ, time_s)
        white = rms * noise.low_pass(time_s).ratio
        highest = math.sqrt(2.0) * hum
        values = (rms, white, hum, highest)
        rows.append((name, *(f"{_number(value)} {unit}" for value in values)))
    columns = ("filter", "RMS as sold", "white: RMS behind it", "50 Hz: RMS behind it", "its peak")
    return [*table(columns, rows), ""]


def markdown() -> str:
    """Tables, each under its heading."""
    found = measured()
    hours, force = found["hours"] | found["refusals"], found["force"]
    return "\n".join(
        [
            "",
            "## Which stand near",
            "",
            *_near(),
            f"Of {force['machines']:,} bedside drives, drawn anew, {force['beyond']} read more at "
            f"their own current limit than counts as a fault, without noise; the highest read "
            f"{force['most_n']:.2f} N.",
            "",
            "## Suction line",
            "",
            *_rows(line.thresholds(), hours),
            "## Pre-use test of the line",
            "",
            *_rows(pre_use.thresholds(), hours),
            "## Head and drive",
            "",
            *_rows(head.thresholds() + drive.thresholds(), hours),
            "## Valve",
            "",
            *_rows(valve.thresholds(), hours),
            "## Times that outlive patients and switches",
            "",
            *_durations(),
            "## Constants without a row",
            "",
            *_left_out(),
            "## Hum",
            "",
            *_hum(),
            "## Whole cycles without a fault",
            "",
            *_cycles(found),
            "",
        ]
    )
