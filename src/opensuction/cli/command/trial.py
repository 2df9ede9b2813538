"""``trial``: many cycles over patients, machines and faults, each judged by the truth.

Texts of ``opensuction trial``: examples for its help, summary, remaining time.
"""

import shlex
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from opensuction.cli import delivery, entry
from opensuction.cli.delivery import CommandResult, OutputChoice, deliver, to_text
from opensuction.cli.entry import Command
from opensuction.cli.interruption import Stopped
from opensuction.kernel.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence.trial.trial import Heading, PlayedPart, Standing
    from opensuction.result.trial_result import Trial, TrialResult, Violation


SHOWN = 10
"""Violations and false alarms that the terminal lists; all are in the file."""

EXAMPLES = """\b
Examples:
  opensuction trial --cycles 1000                 a fault each: some minutes
  opensuction trial --cycles 1000 --faults none   false alarms
  opensuction trial --cycles 100000 --faults double --out runs/double
  opensuction trial --resume --out runs/double    go on after Ctrl-C
  opensuction trial --cycles 200 --cohort neonate --seed 7
  opensuction trial --play 4711 --faults double   one of its cycles again
  opensuction trial --cycles 500 --json | jq '.violations[].play'

\b
The folder holds trial.md (the page), trial.json (all figures) and
trial-parts.jsonl (every cycle; what --resume goes on from)."""


def say_time(seconds: float) -> str:
    """A time in words: how long something takes still."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 5400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"


def violation(one: "Violation") -> str:
    """A bound that was broken, and what plays its cycle again."""
    faults = " + ".join(one.faults) or "no fault"
    worst = "no number" if one.worst is None else f"{one.worst:.3g}"
    return (
        f"  {one.number}: {faults}, {one.patient} by {one.approach}: {one.bound} "
        f"{worst}, limit {one.limit:.3g}\n    {one.play}"
    )


def summarise(console: "Console", result: "TrialResult", folder: Path) -> None:
    """Print what a trial came to. folder: holds its files."""
    from rich.table import Table

    from opensuction.evidence.trial import trial_page

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("held against", ratio=1)
    for column in ("cycles", "broken", "share at most (95 %)"):
        table.add_column(column, justify="right", no_wrap=True)
    for words, one in trial_page.list_held(result.bounds):
        if one.cycles:
            style = "bold red" if one.broken else None
            share = f"{one.upper_percent:.2g} %"
            table.add_row(words, f"{one.cycles:,}", f"{one.broken:,}", share, style=style)
    console.print(table)
    for sentence in _sentences(result):
        for line in sentence.splitlines():
            console.print(line, soft_wrap=True)
    console.print(f"Page: {folder / 'trial.md'}, figures: {folder / 'trial.json'}", soft_wrap=True)


def _sentences(result: "TrialResult") -> Iterator[str]:
    """Sentences below the table in the terminal."""
    left = result.left_inside.total
    if left.count:
        yield (
            f"Left inside at the end: {left.count:,} of {result.cycles:,} cycles; "
            f"{left.unavoidable:,} of them nothing could have prevented, {left.told:,} were "
            "told high in time."
        )
    else:
        yield "Left inside at the end: none."
    if result.too_slow:
        yield (
            f"{result.too_slow:,} cycles broke a bound of time that no withdrawal with the drive's "
            "whole voltage could have kept."
        )
    shown = [violation(one) for one in result.violations[:SHOWN]]
    if shown:
        yield f"Violations ({len(result.violations)}), each with what plays it again:"
        yield from shown
    loud = [one for one in result.said if one.false]
    if loud:
        yield f"Said of sound cycles and not so ({len(loud)}):"
    for one in loud[:SHOWN]:
        words = ", ".join(one.false)
        cycle = f"{one.number}: {one.patient} by {one.approach}"
        yield f"  {cycle}: {words}\n    {one.play}"
    if len(result.violations) > SHOWN or len(loud) > SHOWN:
        yield "All of them are in the page and in the figures."
    if result.cycles_per_s:
        rate = f"{result.cycles_per_s:.1f} cycles a second"
        yield f"{rate}. In-silico: the machine is a simulated one."


FILES = ("trial.json", "trial.md")


class TrialOptions(NamedTuple):
    """Options of ``trial``; None: the default, or the option of the trial that goes on."""

    cycles: int | None = None
    fault_count: str | None = None
    cohort: str | None = None
    compensation: str | None = None
    preoxygenation: str | None = None
    seed: int | None = None
    workers: int | None = None
    resume: bool = False
    play: int | None = None
    results: OutputChoice = OutputChoice()


def run(options: TrialOptions) -> int:
    """Carry the command out; returns the exit status. Raises InputError for bad input."""
    if options.play is not None:
        return _play(options, options.play)
    return _run(options)


def _choose(options: TrialOptions, usual: "Trial") -> "Trial":
    """The trial that was asked for. Raises InputError for an unknown name.

    usual: holds what nobody has said anything of.
    """
    from opensuction.evidence.trial.trial import check_names

    asked: dict[str, Any] = {
        "faults": options.fault_count,
        "cohort": options.cohort,
        "seed": options.seed,
        "compensation": options.compensation,
        "preoxygenation": options.preoxygenation,
    }
    trial = usual._replace(**{name: value for name, value in asked.items() if value is not None})
    check_names(trial)
    return trial


def _play(options: TrialOptions, number: int) -> int:
    """Play one cycle again."""
    from opensuction.result.trial_result import Trial

    if options.resume or options.cycles is not None:
        raise InputError("--play plays one cycle: leave --resume and --cycles out")
    trial = _choose(options, Trial())
    return deliver(
        options.results,
        f"trial-{number}",
        lambda progress, _: _compute_one(trial, number, progress),
        f"Playing cycle {number}",
    )


def _compute_one(trial: "Trial", number: int, progress: "ProgressTeller") -> CommandResult:
    from opensuction.evidence.trial import judged_cycle, trial_summary
    from opensuction.evidence.trial.trial import play_again
    from opensuction.report import terminal
    from opensuction.report.cycle import page
    from opensuction.result.plain import to_json
    from opensuction.result.trial_result import PlayedCycle
    from opensuction.session.cycle import cycle_run, cycle_summary, fault_run, summary_section

    found = play_again(trial, number)
    factor = cycle_run.realtime_factor(found.prepared)
    faults = fault_run.on_record(found.run)
    result = cycle_summary.summary(found.prepared, found.run.columns, faults)
    result = cycle_summary.timed(result, progress.elapsed_s, factor)
    html = page.render(result, found.run.columns, summary_section.sections(found.prepared))
    result = cycle_summary.timed(result, progress.elapsed_s, factor)
    summary = trial_summary.summarise_case(trial, judged_cycle.judge(number, found))
    data = to_json(PlayedCycle(result, summary))
    files = {"report.html": html, "cycle.json": to_text(data)}

    def summarise(console: "Console", folder: Path) -> None:
        terminal.print_summary(console, result, [folder / name for name in files])
        for one in summary.violations:
            for line in violation(one).splitlines():
                console.print(line, soft_wrap=True)

    return CommandResult(data, files, summarise, is_good=result.is_good)


def _run(options: TrialOptions) -> int:
    """Run a trial, or go on with one."""
    heading = _choose_heading(options)
    with delivery.reserve(options.results.out, "trial") as folder:
        kept = _open(options, folder, heading)
        result = _carry_out(options, folder, heading, kept)
    try:
        delivery.show(
            options.results.as_json,
            result.data,
            lambda console: result.summarise(console, folder),
        )
    except (OSError, Stopped) as ending:
        ending.add_note(f"the results are in {folder}")
        raise
    return entry.DONE if result.is_good else entry.FAILED


def _carry_out(
    options: TrialOptions, folder: Path, heading: "Heading", kept: "dict[int, PlayedPart]"
) -> CommandResult:
    """Play what is not there yet and write what the trial came to."""
    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence import worker_pool

    progress = ProgressTeller()
    workers = options.workers or worker_pool.count_cores()
    teller = _Teller(progress, heading.cycles, sum(len(one.cases) for one in kept.values()))
    try:
        progress.tell(_say_what_runs(heading, len(kept), workers))
        parts = progress.wait(
            lambda: _play_all(folder, heading, kept, workers, teller), "Preparing"
        )
        result = _conclude(heading, parts, teller, workers)
        with delivery.stage(folder, force=True) as staging:
            delivery.write(staging, result.files)
    except (InputError, OSError, Stopped, worker_pool.WorkerLostError) as ending:
        ending.add_note(_say_what_is_kept(folder, heading, teller.cycles))
        raise
    return result


def _choose_heading(options: TrialOptions) -> "Heading":
    """The trial that is asked for, or that goes on; raises InputError for what does not fit."""
    from opensuction.evidence.trial.trial import check, make_heading, read
    from opensuction.result.trial_result import Trial

    out = options.results.out
    if options.resume:
        if out is None:
            raise InputError("--resume: say which trial goes on: --out and its folder")
        known = read(out).heading
        return make_heading(_choose(options, known.trial), options.cycles or known.cycles)
    if options.cycles is None:
        raise InputError("--cycles is missing: say how many, such as --cycles 1000")
    trial = _choose(options, Trial())
    check(trial)
    return make_heading(trial, options.cycles)


def _open(options: TrialOptions, folder: Path, heading: "Heading") -> "dict[int, PlayedPart]":
    """A log in the trial's folder; returns what is there already.

    Raises InputError where the folder holds another trial, or something else.
    """
    from opensuction.evidence.trial.trial import NAME, begin, go_on

    if options.resume:
        return go_on(folder, heading)
    if (folder / NAME).exists() and not options.results.force:
        raise InputError(
            f"--out {folder}: the folder holds a trial; add --resume to go on with it, or --force "
            "to begin anew"
        )
    delivery.check(folder, options.results.force)
    for stale in FILES:
        (folder / stale).unlink(missing_ok=True)
    begin(folder, heading)
    return {}


def _play_all(
    folder: Path,
    heading: "Heading",
    kept: "dict[int, PlayedPart]",
    workers: int,
    teller: "_Teller",
) -> "list[PlayedPart]":
    """The parts of a trial: all of them, or as many as could be played.

    Raises WorkerLostError where none could.
    """
    from opensuction.evidence.trial import trial
    from opensuction.evidence.worker_pool import WorkerLostError

    try:
        listener = trial.Listener(teller.tell, teller.warn)
        return trial.run(folder, heading, kept, workers, listener)
    except WorkerLostError as lost:
        found = trial.read(folder).parts
        if not found:
            raise
        teller.warn(f"opensuction: {lost}; {_say_what_is_kept(folder, heading, teller.cycles)}")
        return [found[machine] for machine in sorted(found)]


class _Teller:
    """Tells how a trial goes on, and remembers how far it is."""

    def __init__(self, progress: "ProgressTeller", cycles: int, kept: int) -> None:
        """cycles: of the whole trial. kept: those that are there already."""
        self.cycles = self.kept = kept
        self.elapsed_s = 0.0
        self.warn = progress.tell
        self._progress, self._whole = progress, cycles
        self._began_s: float | None = None

    def tell(self, standing: "Standing") -> None:
        """Show how many cycles are there, how fast it goes and how long it takes still."""
        self.cycles, now_s = standing.cycles, self._progress.elapsed_s
        if self._began_s is None:
            self._began_s, self.kept = now_s, standing.cycles
        words = f"{standing.cycles:,} of {self._whole:,} cycles"
        played = standing.cycles - self.kept
        self.elapsed_s = now_s - self._began_s
        if played:
            rate = played / self.elapsed_s
            left_s = (self._whole - standing.cycles) / rate
            words += f", {rate:.0f} a second, {say_time(left_s)} left"
        if standing.broken:
            words += f"; {standing.broken:,} broken"
        self._progress.show(words)


def _say_what_runs(heading: "Heading", kept: int, workers: int) -> str:
    from opensuction.evidence.trial import draw, trial_page

    machines = draw.count_machines(heading.trial, heading.cycles)
    goes_on = f", {kept:,} of them there already" if kept else ""
    return (
        f"{heading.cycles:,} cycles {trial_page.EACH[heading.trial.faults]} on {machines:,} drawn "
        f"machines{goes_on}; {workers} {'process' if workers == 1 else 'processes'}"
    )


def _say_what_is_kept(folder: Path, heading: "Heading", cycles: int) -> str:
    """Say what a trial that ended early leaves, and how to go on; remove one without a cycle."""
    from opensuction.evidence.trial.trial import NAME

    if not cycles:
        (folder / NAME).unlink(missing_ok=True)
        return "nothing was written"
    return (
        f"{cycles:,} of {heading.cycles:,} cycles are kept; go on with: opensuction trial --resume "
        f"--out {shlex.quote(str(folder))}"
    )


def _conclude(
    heading: "Heading", parts: "list[PlayedPart]", teller: _Teller, workers: int
) -> CommandResult:
    """Files and summary of a trial."""
    from opensuction.evidence.trial import trial_page, trial_summary
    from opensuction.evidence.trial.trial_summary import Effort
    from opensuction.result.plain import to_json

    now = datetime.now(tz=UTC)
    effort = Effort(workers, teller.elapsed_s, teller.cycles - teller.kept, f"{now:%Y-%m-%d}")
    found = trial_summary.summarise(heading, parts, effort)
    data = to_json(found)
    files = {"trial.json": to_text(data), "trial.md": trial_page.markdown(found)}
    return CommandResult(
        data,
        files,
        lambda console, folder: summarise(console, found, folder),
        is_good=trial_summary.is_good(found),
    )


COMMAND = Command(
    name="trial",
    options=TrialOptions,
    run=run,
    sentence="Many cycles over drawn patients, machines and faults, each judged by the truth.",
    details="Every cycle follows from its number alone: machine, patient, faults, their strengths "
    "and instants (while the tip is inside, or a second before). What happened is judged from the "
    "twin's truth, what the controller sends by its invariants; counts come with 95 % upper "
    "bounds, endpoints by patient. With --faults none it counts trips and alarms that say what is "
    "not so. Ctrl-C keeps what is done, and --resume goes on. Two faults at once are counted; "
    "nothing is claimed of them, and they do not change the exit status.",
    examples=EXAMPLES,
    ends="0 all that is claimed held, 1 something was broken or it is not complete",
)
