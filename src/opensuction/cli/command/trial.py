"""``trial``: many cycles over patients, machines and faults, each judged by the truth."""

import shlex
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from opensuction.cli import delivery, exit_status, output_folder
from opensuction.cli.command import trial_words
from opensuction.cli.delivery import CommandResult, OutputChoice, deliver, to_text
from opensuction.cli.entry import Command
from opensuction.cli.interruption import Stopped
from opensuction.kernel.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.evidence.trial.part import PlayedPart
    from opensuction.evidence.trial.trial import Standing
    from opensuction.evidence.trial.trial_log import Heading
    from opensuction.result.trial_result import Trial

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
    from opensuction.evidence.trial import cohort, draw
    from opensuction.session.cycle.preoxygenation import ANSWERS
    from opensuction.settings.choice import choose

    asked: dict[str, Any] = {
        "faults": options.fault_count,
        "cohort": options.cohort,
        "seed": options.seed,
        "compensation": options.compensation,
        "preoxygenation": options.preoxygenation,
    }
    trial = usual._replace(**{name: value for name, value in asked.items() if value is not None})
    choose(trial.faults, draw.FAULT_COUNTS, "--faults")
    choose(trial.preoxygenation, ANSWERS, "--preoxygenation")
    cohort.list_kinds(trial.cohort)
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
    from opensuction.evidence.trial import judged_cycle, part, trial_summary
    from opensuction.report import terminal
    from opensuction.report.cycle import page
    from opensuction.result.plain import to_json
    from opensuction.result.trial_result import PlayedCycle
    from opensuction.session.cycle import cycle_run, cycle_summary, fault_run, machine_summary

    found = part.play_again(trial, number)
    factor = cycle_run.realtime_factor(found.prepared)
    faults = fault_run.on_record(found.run)
    result = cycle_summary.summary(found.prepared, found.run.columns, faults)
    result = cycle_summary.timed(result, progress.elapsed_s, factor)
    html = page.render(result, found.run.columns, machine_summary.sections(found.prepared))
    result = cycle_summary.timed(result, progress.elapsed_s, factor)
    summary = trial_summary.summarise_case(trial, judged_cycle.judge(number, found))
    data = to_json(PlayedCycle(result, summary))
    files = {"report.html": html, "cycle.json": to_text(data)}

    def summarise(console: "Console", folder: Path) -> None:
        terminal.print_summary(console, result, [folder / name for name in files])
        for one in summary.violations:
            for line in trial_words.violation(one).splitlines():
                console.print(line, soft_wrap=True)

    return CommandResult(data, files, summarise, is_good=result.is_good)


def _run(options: TrialOptions) -> int:
    """Run a trial, or go on with one."""
    heading = _choose_heading(options)
    with output_folder.reserve(options.results.out, "trial") as folder:
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
    return exit_status.DONE if result.is_good else exit_status.FAILED


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
        with output_folder.stage(folder, force=True) as staging:
            output_folder.write(staging, result.files)
    except (InputError, OSError, Stopped, worker_pool.WorkerLostError) as ending:
        ending.add_note(_say_what_is_kept(folder, heading, teller.cycles))
        raise
    return result


def _choose_heading(options: TrialOptions) -> "Heading":
    """The trial that is asked for, or that goes on; raises InputError for what does not fit."""
    from opensuction.evidence.trial import part, trial_log
    from opensuction.result.trial_result import Trial

    out = options.results.out
    if options.resume:
        if out is None:
            raise InputError("--resume: say which trial goes on: --out and its folder")
        known = trial_log.read(out).heading
        return trial_log.make_heading(_choose(options, known.trial), options.cycles or known.cycles)
    if options.cycles is None:
        raise InputError("--cycles is missing: say how many, such as --cycles 1000")
    trial = _choose(options, Trial())
    part.check(trial)
    return trial_log.make_heading(trial, options.cycles)


def _open(options: TrialOptions, folder: Path, heading: "Heading") -> "dict[int, PlayedPart]":
    """A log in the trial's folder; returns what is there already.

    Raises InputError where the folder holds another trial, or something else.
    """
    from opensuction.evidence.trial import trial_log

    if options.resume:
        return trial_log.go_on(folder, heading)
    if (folder / trial_log.NAME).exists() and not options.results.force:
        raise InputError(
            f"--out {folder}: the folder holds a trial; add --resume to go on with it, or --force "
            "to begin anew"
        )
    output_folder.check(folder, options.results.force)
    for stale in FILES:
        (folder / stale).unlink(missing_ok=True)
    trial_log.begin(folder, heading)
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
    from opensuction.evidence.trial import trial, trial_log
    from opensuction.evidence.worker_pool import WorkerLostError

    try:
        listener = trial.Listener(teller.tell, teller.warn)
        return trial.run(folder, heading, kept, workers, listener)
    except WorkerLostError as lost:
        found = trial_log.read(folder).parts
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
            words += f", {rate:.0f} a second, {trial_words.say_time(left_s)} left"
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
    from opensuction.evidence.trial import trial_log

    if not cycles:
        (folder / trial_log.NAME).unlink(missing_ok=True)
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
        lambda console, folder: trial_words.summarise(console, found, folder),
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
    examples=trial_words.EXAMPLES,
    ends="0 all that is claimed held, 1 something was broken or it is not complete",
)
