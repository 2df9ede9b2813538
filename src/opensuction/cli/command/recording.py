"""``replay``, ``report`` and ``export``: a recording played again, shown, and handed on."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from opensuction.cli import entry
from opensuction.cli.delivery import CommandResult, OutputChoice, deliver, show
from opensuction.cli.entry import Command
from opensuction.kernel.errors import InputError
from opensuction.result.plain import to_json

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import Console

    from opensuction.cli.progress import ProgressTeller
    from opensuction.result.cycle_result import CycleResult
    from opensuction.session.recorded.export_run import ExportResult
    from opensuction.session.recorded.replay_run import RefusedReplay, ReplayResult

PAGE, DATA = "report.html", "report.json"
HEADING = "recording.json"
"""File that says of what recording the tables are."""


class ReplayOptions(NamedTuple):
    """Options of ``replay``."""

    replayed: tuple[Path, ...]
    as_json: bool = False


class ExportOptions(NamedTuple):
    """Options of ``export``."""

    recording: Path
    format: str = "csv"
    columns: tuple[str, ...] = ()
    results: OutputChoice = OutputChoice()


class ReportOptions(NamedTuple):
    """Options of ``report``."""

    recording: Path
    database: str | None = None
    results: OutputChoice = OutputChoice()


def _report(options: ReportOptions) -> int:
    def work(progress: "ProgressTeller", _: Path) -> CommandResult:
        from opensuction.cli.delivery import to_text
        from opensuction.session.recorded import report_run

        known = report_run.find(options.recording, options.database)
        found = report_run.run([options.recording], known.sentence)
        data = to_json(report_run.ReportedCycle(found.result, known))
        _tell_flaw(found.flaw, progress)
        if known.is_faulty:
            progress.tell(known.sentence)
        return CommandResult(
            data,
            {PAGE: found.html, DATA: to_text(data)},
            lambda console, final: _summarise_report(console, found.result, final),
            is_good=not found.is_damaged and not known.is_faulty,
        )

    return deliver(options.results, "report", work, "Reading")


def _summarise_report(console: "Console", found: "CycleResult", folder: Path) -> None:
    from opensuction.report import terminal

    terminal.print_summary(console, found, [folder / PAGE, folder / DATA])


def _replay(options: ReplayOptions) -> int:
    from opensuction.cli.progress import ProgressTeller

    progress = ProgressTeller()
    if len(options.replayed) > 1:
        return _replay_each(options, progress)
    found = _play_again(options.replayed[0], progress)
    show(options.as_json, to_json(found), lambda console: _summarise_replay(console, found))
    return _judge(found)


def _play_again(path: Path, progress: "ProgressTeller") -> "ReplayResult":
    from opensuction.session.recorded import replay_run

    found = progress.wait(lambda: replay_run.run(path), "Replaying")
    _tell_flaw(found.flaw, progress)
    return found


def _judge(found: "ReplayResult") -> int:
    return entry.DONE if found.is_good else entry.FAILED


def _replay_each(options: ReplayOptions, progress: "ProgressTeller") -> int:
    """Replay several; one that is refused keeps no other from being replayed."""
    from opensuction.session.recorded import replay_run

    recordings: list[ReplayResult | RefusedReplay] = []
    statuses: set[int] = set()
    for path in options.replayed:
        try:
            found = _play_again(path, progress)
            recordings.append(found)
            statuses.add(_judge(found))
            line = f"{path}: {' '.join(_list_sentences(found))}"
        except InputError as refused:
            recordings.append(replay_run.RefusedReplay(str(path), str(refused)))
            statuses.add(entry.BAD_INPUT)
            line = str(refused)
        if not options.as_json:
            show(False, {}, lambda console, line=line: _print_line(console, line))
    if options.as_json:
        show(True, to_json(replay_run.SeveralReplays(tuple(recordings))), lambda _: None)
    return max(statuses)


def _print_line(console: "Console", line: str) -> None:
    from opensuction.settings import wording

    console.print(wording.one_line(line), soft_wrap=True)


def _tell_flaw(flaw: str | None, progress: "ProgressTeller") -> None:
    if flaw is not None:
        progress.tell(flaw)


def _value(number: float | None) -> str:
    """A number of a recording in words; JSON has none for those that are not finite."""
    return "no finite number" if number is None else repr(number)


def _list_sentences(found: "ReplayResult") -> "Iterator[str]":
    """Result of a replay in sentences, the verdict first."""
    first = found.first_difference
    if first is None:
        yield f"Identical: every output and state of {found.ticks} ticks, bit for bit."
    else:
        kind = "Equivalent: within 1e-9" if found.equivalent else "Different"
        yield (
            f"{kind}; {found.differing_ticks} of {found.ticks} ticks have another bit. The first "
            f"is tick {first.tick} ({first.time_s:.3f} s), {first.field}: recorded "
            f"{_value(first.recorded)}, replayed {_value(first.replayed)}."
        )
    if found.gaps:
        places = "1 place" if found.gaps == 1 else f"{found.gaps} places"
        yield f"Ticks are missing in {places}; it went on after them."
    for note in found.notes:
        yield f"Note: {note}."


def _summarise_replay(console: "Console", found: "ReplayResult") -> None:
    for sentence in _list_sentences(found):
        _print_line(console, sentence)
    recorded = found.recorded
    about = ", ".join(
        f"{name} {recorded.about[name]}"
        for name in ("machine", "patient", "protocol", "seed")
        if name in recorded.about
    )
    by = f"by opensuction {recorded.software_version}: {about}"
    _print_line(console, f"Recorded {recorded.began_utc} {by}")


def _export(options: ExportOptions) -> int:
    from opensuction.session.recorded import export_run
    from opensuction.session.recorded.export_run import Choice

    choice = Choice(options.recording, options.format, options.columns)
    export_run.check(choice)

    def work(progress: "ProgressTeller", folder: Path) -> CommandResult:
        from opensuction.cli.delivery import to_text

        found = export_run.run(choice, folder, progress.show)
        data = to_json(found)
        _tell_flaw(found.flaw, progress)
        return CommandResult(
            data,
            {HEADING: to_text(data)},
            lambda console, final: _summarise_export(console, found, final),
            is_good=not found.damaged,
            stale=tuple(_other_tables(found)),
        )

    return deliver(options.results, "export", work, "Exporting", writes=True)


def _other_tables(found: "ExportResult") -> "Iterator[str]":
    """Tables of another export that the folder may hold."""
    from opensuction.recording.cycle_file.table_export import FORMATS

    written = [table.file for table in found.tables]
    for name in ("tick", "twin"):
        yield from (f"{name}.{form}" for form in FORMATS if f"{name}.{form}" not in written)


def _summarise_export(console: "Console", found: "ExportResult", folder: Path) -> None:
    for table in (*found.tables, found.events):
        width = "" if table.columns is None else f" of {table.columns} columns"
        console.print(f"{folder / table.file}: {table.rows} rows{width}", soft_wrap=True)
    console.print(f"{folder / HEADING}: what was recorded", soft_wrap=True)


REPLAY = Command(
    name="replay",
    options=ReplayOptions,
    run=_replay,
    sentence="Play recordings through the controller again and compare every bit.",
    details="Feeds the recorded inputs to the same core, from each state that was set, and "
    "compares all outputs and the whole state of every tick. What differs first is shown with "
    "tick, field and both values. Under other arithmetic (another processor or C library) numbers "
    "within 1e-9 are equivalent.",
    examples="""\b
Examples:
  opensuction cycle --out run1
  opensuction replay run1/recording.mcap
  opensuction replay run1/recording.mcap --json | jq .identical
  opensuction replay run1/recording.mcap --json | jq .first_difference
  opensuction replay kept/*.mcap
  opensuction replay kept/*.mcap --json | jq '.recordings[].identical'

A recording that was not finished, or is damaged, is replayed up to there; a line says where. Of
several each has a line, or its entry in the JSON object, and one that cannot be read keeps no other
from being replayed.""",
    ends="0 all identical, or equivalent under other arithmetic; 1 one is different, or damaged",
)
REPORT = Command(
    name="report",
    options=ReportOptions,
    run=_report,
    sentence="The report of a recording: the page that a cycle gets, from its file alone.",
    details="Reads what the machine's sensors measured and what its controller decided and "
    "estimated, and writes report.html (open it in a browser) and report.json. There is no sensor "
    "at the tip: where it was is the controller's estimate. What only the twin knows is said to be "
    "not known. The file is held against its hash in the records, where there are some: one that "
    "is the recording of another cycle is refused, one that was cut or changed is said to be so.",
    examples="""\b
Examples:
  opensuction report runs/RUN/CYCLE.mcap
  opensuction report run1/recording.mcap --out page
  opensuction report runs/RUN/CYCLE.mcap --database ward.db
  opensuction report run1/recording.mcap --json | jq .timing

A recording that was not finished, or is damaged, is reported up to there; a line and the page say
where.""",
    ends="0 written, 1 the file is damaged, or is not as on record: what is there was reported",
)
EXPORT = Command(
    name="export",
    options=ExportOptions,
    run=_export,
    sentence="Write a recording as tables: CSV or Parquet.",
    details="Writes a table for each topic (tick: every input, output and state at 1 kHz; twin: "
    "what really happened, at 100 Hz), event.csv with phases, trips, alarms and requests, and "
    "recording.json. Each table begins with time_s, counted from the recording's beginning.",
    examples="""\b
Examples:
  opensuction export run1/recording.mcap --out tables
  opensuction export run1/recording.mcap --format parquet
  opensuction export run1/recording.mcap --columns 'inputs.readings.*' \\
      --columns outputs.phase --columns truth.tip_mm
  opensuction export run1/recording.mcap --json | jq .tables

All columns of a cycle are some 250 MB as CSV: name those that you want, or take Parquet.""",
    ends="0 written, 1 the file is damaged: what lies before the damage was written",
)
