"""``cycle``: one automated cycle or a day of them, shown while it runs, summarised, written.

Help text of ``opensuction cycle``: examples, files, faults.
"""

import math
import textwrap
import time
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import completion
from opensuction.cli.delivery import CommandResult, OutputChoice, deliver, to_text
from opensuction.cli.entry import Command
from opensuction.kernel.errors import InputError
from opensuction.session.choice import CycleChoice, DayChoice

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.result.cycle_result import CycleResult
    from opensuction.result.day_result import DayResult
    from opensuction.session.cycle.cycle_run import Prepared
    from opensuction.simulation.injection.injection import InjectedRun
    from opensuction.simulation.trace import Columns


_FAULTS = textwrap.fill(
    ", ".join(completion.FAULTS),
    width=77,
    initial_indent="  ",
    subsequent_indent="  ",
    break_on_hyphens=False,
)

EXAMPLES = f"""\b
Examples:
  opensuction cycle                                an adult on a ventilator
  opensuction cycle --patient child-10kg           a child
  opensuction cycle --machine bench                the paper's bench
  opensuction cycle --machine bench --compensation none --seed 7
  opensuction cycle --approach contact             stop where the tip touches
  opensuction cycle --protocol my.toml --out run1  a protocol of your own
  opensuction cycle --machine my-machine.toml --patient my-patient.toml
  opensuction cycle --machine bench --compensation bench/identification.toml
  opensuction cycle --repeat 6 --every 240         a cycle every four hours
  opensuction cycle --fault valve-jammed@suctioning+2
  opensuction cycle --fault line-leak=0.5 --fault power-lost@12
  opensuction cycle --repeat 6 --every 60 \\
      --self-calibrate --gap-scale 1.2    the gap changed; each cycle learns
  opensuction cycle --json | jq .tip               figures for a script
  opensuction cycle --trace ticks.parquet          every tick as a table

\b
A protocol file holds the keys of the preset, for example:
  travel_mm = 85.0
  cap_mm = 90.0
  contact_from_mm = 30.0
  backoff_mm = 0.0
  insertion_mm_per_s = 9.0
  withdrawal_mm_per_s = 9.0
  dwell_s = 9.0
  nothing_comes_s = 0.0           # 0: the dwell lasts its whole time
  vacuum_mmhg = 100.0
  negative_pressure_budget_s = 24.0
  in_airway_budget_s = 35.0
  bench_only = true

\b
A machine file says what it starts from and what it changes:
  preset = "clinical"
  catheter = "12fr"
  conduit = "looped"
  [twin]                          # what the machine does
  pump_free_l_per_min = 15.0
  [controller]                    # what its controller goes by
  cam_rad_per_s = 0.8

\b
A patient file likewise; a value with a spread is drawn by the seed:
  preset = "adult-icu"
  weight_kg = 82.0
  carina_mm = {{ value = 60.0, spread = 4.0 }}

docs/reference/parameters.md lists every parameter with unit, range and source.

A fault comes S seconds after the start (@S), S seconds into a phase (@PHASE+S: checking,
preloading, inserting, backing_off, opening, suctioning, withdrawing, closing, aborting, halted), or
is there from the start. With --repeat, S counts from the start of the day. Its strength has a unit
of its own. docs/reference/faults.md says what each does:

\b
{_FAULTS}"""


TERMINAL_PACE = 10.0
"""Simulated seconds in one second on a terminal: a cycle is over in about 3 s."""
SOUND = "alarm.wav"
"""File that lets a person hear the most urgent alarm of a run."""
RECORDING = "recording.mcap"
"""File with every tick of the run, of a day the last cycle."""


class CycleOptions(NamedTuple):
    """Options of ``cycle``."""

    choice: CycleChoice = CycleChoice()
    day: DayChoice = DayChoice()
    pace: float | None = None
    unrecorded: bool = False
    trace: Path | None = None
    results: OutputChoice = OutputChoice()


class Pacer:
    """Sleeps so that simulated time runs at a given pace."""

    def __init__(self, pace: float) -> None:
        """Begin now. pace: simulated seconds a second; 0 is unpaced."""
        self._pace = pace
        self._start_s = time.monotonic()

    def wait_until(self, simulated_s: float) -> None:
        """Sleep until this much simulated time may have passed."""
        if self._pace > 0.0:
            ahead = simulated_s / self._pace - (time.monotonic() - self._start_s)
            if ahead > 0.0:
                time.sleep(ahead)


def run(options: CycleOptions) -> int:
    """Carry the command out; returns the exit status. Raises InputError for bad input."""
    from opensuction.cli.progress import PlainConsole

    console = PlainConsole(stderr=options.results.as_json)
    pace = _pace(options, console)

    def work(progress: "ProgressTeller", _: Path) -> CommandResult:
        prepared = progress.wait(lambda: _prepare(options, progress), "Preparing")
        if options.day.every_min is None:
            return _run_cycle(options, prepared, console, Pacer(pace), progress)
        return _run_day(options, prepared, console, progress)

    with _reserve_trace(options):
        return deliver(options.results, options.choice.rig.seed, work)


def _reserve_trace(options: CycleOptions) -> AbstractContextManager[None]:
    """The file of the time series is this run's, where one was named; raises InputError."""
    if options.trace is None:
        return nullcontext()
    from opensuction.session.cycle import trace_file

    return trace_file.reserve(options.trace, options.results.force)


def _pace(options: CycleOptions, console: "Console") -> float:
    """Simulated seconds a second; 0 is unpaced. Raises InputError for an impossible pace."""
    if options.pace is None:
        return TERMINAL_PACE if console.is_terminal and not options.results.as_json else 0.0
    if not math.isfinite(options.pace) or options.pace < 0.0:
        raise InputError(f"--pace {options.pace}: should be 0 (as fast as it goes) or more")
    return options.pace


def _prepare(options: CycleOptions, progress: "ProgressTeller") -> "Prepared":
    """The cycle ready to run and compiled; refused before anything slow where it cannot be."""
    from opensuction.session.cycle import cycle_run, resolution
    from opensuction.session.day import day_fault

    resolved = resolution.resolve(options.choice)
    day_fault.check(options.day, resolved)
    prepared = cycle_run.prepare(resolved, progress.tell)
    if options.day.every_min is None:  # in a day a person comes before each cycle
        prepared = cycle_run.oxygenate(prepared)
    cycle_run.warm_up(prepared)
    return prepared


def _play(prepared: "Prepared", console: "Console", pacer: Pacer) -> "InjectedRun":
    """The cycle, shown as it goes."""
    from opensuction.report import terminal
    from opensuction.report.terminal import Moment
    from opensuction.session.cycle import cycle_run, fault_run

    target_mm = cycle_run.stopping_mm(prepared)
    with terminal.LiveCycle(console, target_mm, prepared.protocol.cap_mm) as live:

        def watch(moment: Moment) -> None:
            live.update(moment)
            pacer.wait_until(moment.time_s)

        return fault_run.play(prepared, watch)


def _record(
    options: CycleOptions, prepared: "Prepared", ran: "InjectedRun", progress: "ProgressTeller"
) -> dict[str, str | bytes]:
    """The recording of a run, as a file; nothing where none is wanted."""
    if options.unrecorded:
        return {}
    from opensuction.session.recorded import cycle_recording

    began_ns = time.time_ns()
    return {
        RECORDING: progress.wait(
            lambda: cycle_recording.record(prepared, ran, began_ns), "Recording"
        )
    }


def _write_trace(options: CycleOptions, columns: "Columns", progress: "ProgressTeller") -> None:
    """The time series of a run, where a file was named for it."""
    if options.trace is None:
        return
    from opensuction.session.cycle import trace_file

    with trace_file.place(options.trace) as aside:
        progress.wait(lambda: trace_file.fill(aside, columns), "Writing the trace")


def _run_cycle(
    options: CycleOptions,
    prepared: "Prepared",
    console: "Console",
    pacer: Pacer,
    progress: "ProgressTeller",
) -> CommandResult:
    """One cycle."""
    from opensuction.report.cycle import page
    from opensuction.session.cycle import cycle_run, cycle_summary, fault_run, summary_section

    found = _play(prepared, console, pacer)
    factor = cycle_run.realtime_factor(prepared)
    faults = fault_run.on_record(found)
    result = cycle_summary.summary(prepared, found.columns, faults)
    result = cycle_summary.timed(result, progress.elapsed_s, factor)
    html = page.render(result, found.columns, summary_section.sections(prepared))
    files = {"report.html": html, **_record(options, prepared, found, progress)}
    _write_trace(options, found.columns, progress)
    return _write_up(result, None, files, progress, options.trace)


def _run_day(
    options: CycleOptions, prepared: "Prepared", console: "Console", progress: "ProgressTeller"
) -> CommandResult:
    """Many cycles: the day has a page, and so has each cycle; the report is the last one's."""
    from opensuction.report import sheet
    from opensuction.report.cycle import page
    from opensuction.report.day import day_page
    from opensuction.session.cycle import cycle_run, cycle_summary, summary_section
    from opensuction.session.day import day_run, day_summary

    asked, reports = options.day, list[day_summary.CycleReport]()

    def tell(cycle: day_run.DayCycle, began: "Prepared", columns: "Columns") -> None:
        found = cycle.outcome
        reports.append(day_summary.make(cycle.number, began, columns))
        console.print(
            f"cycle {cycle.number} of {asked.repeat} at {cycle.start_s / 3600.0:.2f} h: "
            f"{reports[-1].first.text}; {found.removed_ml:.1f} of "
            f"{cycle.secretion_before_ml:.1f} mL removed, lowest SpO2 "
            f"{found.exposure.spo2_least_percent:.1f} %"
            f"{', new catheter' if cycle.catheter_changed else ''}"
            f"{', patient looked at before' if cycle.assessed else ''}"
            f"{day_summary.gap_words(cycle.learned)}",
            soft_wrap=True,
        )

    day = progress.wait(lambda: day_run.play(prepared, asked, tell))
    factor = cycle_run.realtime_factor(prepared)
    result = cycle_summary.summary(day.last, day.columns, day.faults)
    result = cycle_summary.timed(result, progress.elapsed_s, factor)
    refused = day_summary.gap_alarms(day, result.timing.cycle_s)
    result = result._replace(alarms=result.alarms + refused)
    whole = day_summary.summary(day, reports)
    for note in whole.notes:
        console.print(f"Note: {note}", soft_wrap=True)
    files = {
        "day.html": sheet.render(day_page.page(result, whole, day.samples)),
        "report.html": page.render(result, day.columns, summary_section.sections(day.last)),
        **day_summary.list_pages(reports),
        **_record(options, day.last, day.ran, progress),
    }
    _write_trace(options, day.columns, progress)
    return _write_up(result, whole, files, progress, options.trace)


def _write_up(
    result: "CycleResult",
    day: "DayResult | None",
    made: Mapping[str, str | bytes],
    progress: "ProgressTeller",
    trace: Path | None,
) -> CommandResult:
    from opensuction.result.day_result import CycleAndDay
    from opensuction.result.plain import to_json
    from opensuction.session.cycle import cycle_summary

    result = cycle_summary.filed(
        result,
        wall_s=progress.elapsed_s,
        trace=None if trace is None else str(trace),
        recording=RECORDING if RECORDING in made else None,
    )
    data = to_json(CycleAndDay(result, day))
    files: dict[str, str | bytes] = {**made, "cycle.json": to_text(data), **_sound(result)}

    def summarise(console: "Console", folder: Path) -> None:
        from opensuction.report import terminal

        if day is not None:
            console.print("The last of these cycles:")
        terminal.print_summary(console, result, _named(folder, list(files), trace))

    return CommandResult(
        data,
        files,
        summarise,
        is_good=result.is_good and (day is None or day.is_good),
        stale=() if RECORDING in files else (RECORDING,),
    )


def _named(folder: Path, names: list[str], trace: Path | None) -> list[str]:
    """Files that were written, those of a day's cycles in one line."""
    many = [name for name in names if name.startswith("cycle-")]
    listed = [str(folder / name) for name in names if name not in many]
    if trace is not None:
        listed.append(f"{trace}, every tick as a table")
    if many:
        listed.append(f"{folder / many[0]} to {many[-1]}, a report for each cycle")
    return listed


def _sound(result: "CycleResult") -> dict[str, bytes]:
    """Sound of the most urgent alarm, as a file; nothing where there was none."""
    from opensuction.report.cycle.page import encode_alarm
    from opensuction.safety.handling import Priority

    if not result.alarms:
        return {}
    loudest = max(Priority[alarm.priority.upper()] for alarm in result.alarms)
    return {SOUND: encode_alarm(loudest)}


COMMAND = Command(
    name="cycle",
    options=CycleOptions,
    run=run,
    sentence="One automated suction cycle on the digital twin: live phases, summary, report.",
    details="Identifies the drawn machine where the compensation needs it, runs the cycle under "
    "the real controller, and writes report.html (open it in a browser), cycle.json and "
    "recording.mcap (every tick; see opensuction replay and export).",
    examples=EXAMPLES,
    ends="0 completed, 1 aborted or the patient at risk",
)
