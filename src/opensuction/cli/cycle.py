"""The ``cycle`` command: one automated cycle, shown while it runs, summarised and written down."""

import json
import math
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rich.console import Console

from opensuction.cli import output_folder
from opensuction.kernel.errors import InputError

if TYPE_CHECKING:
    from opensuction.session.cycle.cycle_choice import Choice
    from opensuction.session.cycle.cycle_run import Prepared
    from opensuction.simulation.injection.injection import InjectedRun

TERMINAL_PACE = 10.0
"""Simulated seconds in one second on a terminal: a cycle is over in about 3 s."""
SOUND = "alarm.wav"
"""File that lets a person hear the most urgent alarm of a run."""
POLL_S = 0.1
"""How often a wait looks for Ctrl-C."""

Result = TypeVar("Result")


class Options(NamedTuple):
    """Options of the command as a person gave them."""

    machine: str | None
    protocol: str
    patient: str | None
    catheter: str | None
    conduit: str | None
    approach: str
    compensation: str
    taught_mm: float | None
    faults: tuple[str, ...]
    repeat: int
    every_min: float | None
    self_calibrates: bool
    gap_scale: float
    seed: int
    pace: float | None
    out: Path | None
    force: bool
    as_json: bool


def interruptible(work: Callable[[], Result]) -> Result:
    """Run slow work in the background so that Ctrl-C is heard at once; raises what it raised."""
    results: list[Result] = []
    failures: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work())
        except BaseException as failure:
            failures.append(failure)

    worker = threading.Thread(target=run, daemon=True)
    worker.start()
    while worker.is_alive():
        worker.join(POLL_S)
    if failures:
        raise failures[0]
    return results[0]


def pace_of(options: Options, console: Console) -> float:
    """Simulated seconds a second; 0 is unpaced. Raises InputError for an impossible pace."""
    if options.pace is None:
        return TERMINAL_PACE if console.is_terminal and not options.as_json else 0.0
    if not math.isfinite(options.pace) or options.pace < 0.0:
        raise InputError(f"--pace {options.pace}: should be 0 (as fast as it goes) or more")
    return options.pace


class Pacer:
    """Sleeps so that simulated time runs at a given pace."""

    def __init__(self, pace: float) -> None:
        self._pace = pace
        self._start_s = time.monotonic()

    def wait_until(self, simulated_s: float) -> None:
        """Sleep until this much simulated time may have passed."""
        if self._pace > 0.0:
            ahead = simulated_s / self._pace - (time.monotonic() - self._start_s)
            if ahead > 0.0:
                time.sleep(ahead)


def run(options: Options) -> int:
    """Carry the command out; returns the exit status. Raises InputError for bad input."""
    began_s = time.monotonic()
    console = Console(stderr=options.as_json, highlight=False)
    pace = pace_of(options, console)
    folder = output_folder.chosen(options.out, options.seed)
    with output_folder.whole(folder, options.force) as staging:
        data = _run_and_write(options, console, pace, staging, began_s)
    if options.as_json:
        print(json.dumps(data))  # noqa: T201 - the one object of --json
    else:
        _summarise(console, data, folder)
    refused = data.get("day", {}).get("refusal") is not None
    return 0 if data["outcome"] == "completed" and not refused else 1


def _choice(options: Options) -> "Choice":
    from opensuction.session.cycle import fault_choice
    from opensuction.session.cycle.cycle_choice import Choice

    return Choice(
        machine=options.machine,
        protocol=options.protocol,
        approach=options.approach,
        compensation=options.compensation,
        seed=options.seed,
        patient=options.patient,
        catheter=options.catheter,
        conduit=options.conduit,
        taught_mm=options.taught_mm,
        faults=fault_choice.chosen(options.faults, options.approach, options.repeat),
        gap_scale=options.gap_scale,
    )


def _played(prepared: "Prepared", console: Console, pacer: Pacer) -> "InjectedRun":
    """The cycle, shown as it goes."""
    from opensuction.kernel.phase import Phase
    from opensuction.report import terminal
    from opensuction.session.cycle import cycle_run, fault_run

    target_mm = cycle_run.stopping_mm(prepared)
    with terminal.LiveCycle(console, target_mm, prepared.protocol.cap_mm) as live:

        def watch(progress: cycle_run.Progress) -> None:
            live.update(
                Phase(progress.phase).name.lower(),
                progress.time_s,
                progress.tip_mm,
                progress.valve_open_ratio,
                progress.vacuum_mmhg,
            )
            pacer.wait_until(progress.time_s)

        return fault_run.play(prepared, watch)


def _run_and_write(
    options: Options, console: Console, pace: float, staging: Path, began_s: float
) -> dict[str, Any]:
    # Heavy imports.
    from opensuction.kernel import compiled
    from opensuction.report.cycle import page
    from opensuction.session.cycle import (
        cycle_choice,
        cycle_run,
        cycle_summary,
        fault_run,
        machine_summary,
    )
    from opensuction.session.day import day_calibration, day_run

    choice = _choice(options)
    # Progress goes to stderr: a refusal may still come, and then nothing is on stdout.
    progress = Console(stderr=True, highlight=False)

    def tell(line: str) -> None:
        progress.print(line, soft_wrap=True)

    found, kind = cycle_choice.check(choice)
    on_bench = cycle_choice.kinds(choice)[0].preset == "bench"
    day_run.check(options.repeat, options.every_min, on_bench)
    if options.self_calibrates:
        by_contact = cycle_choice.APPROACHES[options.approach]
        day_calibration.check(found, kind, by_contact, options.repeat)
    if compiled.is_cold():
        tell("Compiling the control core: once for this version, about a minute")

    with console.status("Preparing"):  # turns on a terminal, silent elsewhere
        prepared = interruptible(lambda: cycle_run.prepare(choice, tell))
        interruptible(lambda: cycle_run.warm_up(prepared))
    if options.every_min is not None:
        return _day(prepared, options, options.every_min, console, staging, began_s)
    played = _played(prepared, console, Pacer(pace))
    columns = played.columns
    factor = cycle_run.realtime_factor(prepared)
    data = cycle_summary.summary(prepared, columns, time.monotonic() - began_s, factor)
    data["faults"] = fault_run.plain(played)
    html = page.render(data, columns, machine_summary.sections(prepared))
    (staging / "report.html").write_text(html, encoding="utf-8")
    return _written(data, staging, began_s)


def _written(data: dict[str, Any], staging: Path, began_s: float) -> dict[str, Any]:
    _write_sound(data, staging)
    data["wall_s"] = time.monotonic() - began_s
    (staging / "cycle.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    return data


def _write_sound(data: dict[str, Any], staging: Path) -> None:
    """What was heard of the most urgent alarm, beside the report; nothing where there was none."""
    from opensuction.report.cycle import alarm_sound
    from opensuction.safety.priority import Priority

    if data["alarms"]:
        loudest = max(Priority[alarm["priority"].upper()] for alarm in data["alarms"])
        (staging / SOUND).write_bytes(alarm_sound.encoded(loudest))


def _day(
    prepared: "Prepared",
    options: Options,
    every_min: float,
    console: Console,
    staging: Path,
    began_s: float,
) -> dict[str, Any]:
    """Many cycles; the report is the last one's, and the day has a page of its own."""
    from opensuction.report import sheet
    from opensuction.report.cycle import page
    from opensuction.session.cycle import cycle_run, cycle_summary, machine_summary
    from opensuction.session.day import day_gap, day_run, day_summary

    def tell(cycle: day_run.DayCycle) -> None:
        found = cycle.outcome
        console.print(
            f"cycle {cycle.number} of {options.repeat} at {cycle.start_s / 3600.0:.2f} h: "
            f"{'completed' if found.completed else 'broken off'}, {found.removed_ml:.1f} of "
            f"{cycle.secretion_before_ml:.1f} mL removed, lowest SpO2 "
            f"{found.spo2_nadir_percent:.1f} %{', new catheter' if cycle.catheter_changed else ''}"
            f"{day_gap.words(cycle.gap)}",
            soft_wrap=True,
        )

    day = interruptible(
        lambda: day_run.play(
            prepared, options.repeat, 60.0 * every_min, tell, options.self_calibrates
        )
    )
    factor = cycle_run.realtime_factor(prepared)
    data = cycle_summary.summary(day.last, day.columns, time.monotonic() - began_s, factor)
    data["alarms"] += day_gap.alarms(day, data["timing"]["cycle_s"])
    html = page.render(data, day.columns, machine_summary.sections(day.last))
    (staging / "report.html").write_text(html, encoding="utf-8")
    sheet_html = sheet.render(day_summary.page(day, options.repeat, every_min))
    (staging / "day.html").write_text(sheet_html, encoding="utf-8")
    data["faults"] = []
    data["day"] = day_summary.plain(day, options.repeat, every_min)
    for note in data["day"]["notes"]:
        console.print(f"Note: {note}", soft_wrap=True)
    return _written(data, staging, began_s)


def _summarise(console: Console, data: dict[str, Any], folder: Path) -> None:
    from opensuction.report import terminal

    files = [folder / "report.html", folder / "cycle.json"]
    if data["alarms"]:
        files.append(folder / SOUND)
    if "day" in data:
        console.print("The last of these cycles:")
        files.insert(0, folder / "day.html")
    terminal.print_summary(console, data, tuple(files))
