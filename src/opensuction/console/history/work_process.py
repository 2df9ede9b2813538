"""Work on recordings in a process of its own.

``python -m opensuction.console.history.work_process`` asks for the least time that a computer has
to give, so that neither the console nor the control loop notices. The first line of its input says
what is wanted; it ends where that input ends, so that it never outlives the console. A line of its
output is an answer.
"""

import json
import os
import resource
import sys
import threading
from pathlib import Path
from typing import Any

NICEST = 19
INPUT, READ_BYTES = 0, 65536
REPORT, REPLAY, FIGURES = "report", "replay", "figures"
LIMITS_S = {REPORT: 90, REPLAY: 300, FIGURES: 900}
"""How long each may take."""


def _read_first_line() -> bytes:
    """Without a buffer, whose lock the thread that waits for the end would hold."""
    parts: list[bytes] = []
    while not parts or b"\n" not in parts[-1]:
        more = os.read(INPUT, READ_BYTES)
        if not more:
            break
        parts.append(more)
    return b"".join(parts)  # nothing follows the first line


def _end_with_input() -> None:
    while os.read(INPUT, READ_BYTES):
        pass
    os._exit(1)


def report(paths: list[Path]) -> dict[str, Any]:
    """The report of a recording."""
    from opensuction.session.recorded import report_run

    return {"html": report_run.run(paths).html}


def replay(paths: list[Path]) -> dict[str, Any]:
    """Result of the replay of a recording; names of files are left out."""
    from opensuction.result.plain import to_json
    from opensuction.session.recorded import replay_run

    return to_json(replay_run.run_parts(paths))


def figures(paths: list[Path]) -> dict[str, Any]:
    """The figures of one recording that trends are made of; None for what is not known."""
    from opensuction.session.recorded import recorded_cycle, recorded_summary

    cycle = recorded_cycle.read(paths)
    result = recorded_summary.summary(cycle)
    known: dict[str, Any] = {
        "gap_mm": recorded_summary.gap_mm(cycle),
        "alarms": float(len(result.alarms)),
    }
    if not result.timing.negative_pressure_s:
        return known  # what never came to suction says nothing of suction
    pressure, rate = result.signs.airway_pressure_cmh2o, result.signs.heart_rate_per_min
    return known | {
        "deepest_mm": result.tip.deepest_mm,
        "contact_mm": recorded_summary.touched_mm(cycle),
        "removed_ml": result.secretion.removed_ml,
        "dwell_s": result.timing.dwell_s,
        "suction_s": result.timing.negative_pressure_s,
        "in_airway_s": result.timing.in_airway_s,
        "vacuum_mmhg": result.vacuum.peak_mmhg,
        "airway_lowest_cmh2o": None if pressure is None else pressure.lowest,
        "airway_highest_cmh2o": None if pressure is None else pressure.highest,
        "spo2_percent": result.spo2_nadir_percent,
        "heart_rate_per_min": None if rate is None else rate.lowest,
    }


WORKS = {REPORT: report, REPLAY: replay, FIGURES: figures}


def answer(what: str, paths: list[Path]) -> dict[str, Any]:
    """Result of one kind of work on a recording, or the reason of its refusal."""
    from opensuction.kernel.errors import InputError

    try:
        return WORKS[what](paths)
    except InputError as refused:
        return {"refused": str(refused)}


def main() -> None:
    """Do what the first line of the input wants."""
    os.nice(NICEST)
    asked = json.loads(_read_first_line())
    limit_s = LIMITS_S[asked["what"]]
    resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s))
    threading.Thread(target=_end_with_input, daemon=True).start()
    for recording in asked["recordings"]:
        found = answer(asked["what"], [Path(part) for part in recording])
        sys.stdout.write(f"{json.dumps(found)}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
