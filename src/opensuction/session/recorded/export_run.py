"""A recording handed on to other programs: a table for each topic, and one of events."""

import csv
from collections.abc import Callable
from contextlib import ExitStack
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import table_export
from opensuction.recording.cycle_file.reader import RecordingReader, Rows, TimedEvent
from opensuction.recording.cycle_file.row_schema import STARTS, RecordedEvent, SchemaColumn, Table
from opensuction.recording.cycle_file.table_export import FORMATS, Sheet
from opensuction.result.plain import IF_KNOWN
from opensuction.session.recorded import replay_run
from opensuction.session.recorded.replay_run import Origin
from opensuction.settings import wording

BLOCK_ROWS = 5000
"""Rows that are written at once: a Parquet file of many small groups is large and slow."""
EVENTS = "event.csv"
EVERY = "the first lines of the tables that are written without --columns"
Times = np.ndarray[tuple[int], np.dtype[np.float64]]


class _Topic:
    """Rows of a topic on their way into a table."""

    def __init__(self, sheet: Sheet, index: list[int]) -> None:
        self._sheet, self.index = sheet, index
        self._times: list[Times] = []
        self._tables: list[Table] = []
        self.rows = self._waiting = 0

    def add(self, times_s: Times, table: Table) -> None:
        self._times.append(times_s)
        self._tables.append(table[:, self.index])
        self.rows, self._waiting = self.rows + len(table), self._waiting + len(table)
        if self._waiting >= BLOCK_ROWS:
            self.flush()

    def flush(self) -> None:
        if self._waiting:
            self._sheet.add(np.concatenate(self._times), np.concatenate(self._tables))
            self._times, self._tables, self._waiting = [], [], 0

    def close(self) -> None:
        """Close the table, written to its end or not."""
        self._sheet.close()


class Choice(NamedTuple):
    """Choice of a recording, and of its columns for export."""

    file: Path
    form: str
    """Of `FORMATS`."""
    columns: tuple[str, ...]
    """Names, or patterns with ``*``; none: all of them."""


class ExportedFile(NamedTuple):
    """Table that was written."""

    file: str
    """Name in the folder."""
    rows: int
    columns: Annotated[int | None, IF_KNOWN] = None
    """Of a table of numbers, the time with them; None: of the events, whose columns are fixed."""


class ExportResult(NamedTuple):
    """Result of an export: the tables, and the recording that they are of."""

    file: str
    """The recording."""
    format: str
    """Of `FORMATS`."""
    tables: tuple[ExportedFile, ...]
    """One for each topic."""
    events: ExportedFile
    whole: bool
    damaged: bool
    flaw: str | None
    """Why the recording is not whole; None: it is."""
    recorded: Origin


def _wanted(
    patterns: tuple[str, ...], tables: dict[str, tuple[SchemaColumn, ...]]
) -> dict[str, list[int]]:
    """Places of the columns of each topic that match a pattern.

    Raises InputError for a pattern that none matches.
    """
    names = {topic: [one.name for one in columns] for topic, columns in tables.items()}
    every = [name for known in names.values() for name in known]
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in every):
            raise InputError(wording.unknown(f"column {pattern!r}", pattern, every, EVERY))
    return {
        topic: [
            i
            for i, name in enumerate(known)
            if not patterns or any(fnmatchcase(name, pattern) for pattern in patterns)
        ]
        for topic, known in names.items()
    }


def check(choice: Choice) -> None:
    """Refuse a format that there is none of, or that is not installed; raises InputError."""
    if choice.form not in FORMATS:
        raise InputError(f"--format {choice.form}: should be {' or '.join(FORMATS)}")
    if choice.form == "parquet":
        table_export.require_parquet()


def run(choice: Choice, folder: Path, tell: Callable[[str], None]) -> ExportResult:
    """Write the tables of a recording into a folder.

    tell: hears how far it is. Raises InputError for what is no recording, or has no such columns;
    OSError where a table cannot be written.
    """
    check(choice)
    reader = RecordingReader(choice.file)
    try:
        return _export(reader, choice, folder, tell)
    finally:
        reader.close()


def _export(
    reader: RecordingReader, choice: Choice, folder: Path, tell: Callable[[str], None]
) -> ExportResult:
    tables = {topic: one for topic, one in reader.tables.items() if topic != STARTS}
    topics: dict[str, _Topic] = {}
    told: list[TimedEvent] = []
    with ExitStack() as closing:  # each of them, also where the end of one cannot be written
        for topic, index in _wanted(choice.columns, tables).items():
            if index:
                path = folder / f"{topic.strip('/')}.{choice.form}"
                kept = [tables[topic][i] for i in index]
                topics[topic] = _Topic(table_export.open_sheet(path, kept, choice.form), index)
                closing.callback(topics[topic].close)
        first = next(iter(topics))
        for one in reader.contents():
            if isinstance(one, TimedEvent):
                told.append(one)
            elif one.topic in topics:
                topics[one.topic].add(_seconds(one, reader), one.table)
                tell(f"Exporting: {topics[first].rows} rows")
        for out in topics.values():
            out.flush()
    _write_events(folder / EVENTS, told, reader)
    return ExportResult(
        file=str(choice.file),
        format=choice.form,
        tables=tuple(
            ExportedFile(f"{topic.strip('/')}.{choice.form}", out.rows, len(out.index) + 1)
            for topic, out in topics.items()
        ),
        events=ExportedFile(EVENTS, len(told)),
        whole=reader.flaw is None,
        damaged=reader.is_damaged,
        flaw=reader.flaw,
        recorded=replay_run.origin_of(reader.heading),
    )


def _seconds(rows: Rows, reader: RecordingReader) -> Times:
    since_ns = rows.times_ns.astype(np.int64) - reader.heading.began_ns
    seconds: Times = since_ns / 1e9
    return seconds


def _write_events(path: Path, told: list[TimedEvent], reader: RecordingReader) -> None:
    with table_export.named(path), path.open("x", encoding="utf-8", newline="") as file:
        lines = csv.writer(file)
        lines.writerow(["time_s", *RecordedEvent._fields])
        for one in sorted(told, key=lambda one: one.time_ns):
            lines.writerow([(one.time_ns - reader.heading.began_ns) / 1e9, *one.event])
