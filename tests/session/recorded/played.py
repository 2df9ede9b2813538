"""Simulated runs and their recordings, for the tests of everything that reads one."""

from contextlib import closing
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.recording.cycle_file.reader import RecordingReader, Rows, TimedEvent
from opensuction.recording.cycle_file.row_schema import TABLES, TICKS, Table
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.session.choice import CycleChoice
from opensuction.session.cycle import cycle_run, fault_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.recorded import cycle_recording
from opensuction.simulation.injection.injection import InjectedRun

BEGAN_NS = 1_795_000_000_000_000_000


class Played(NamedTuple):
    """A run and its recording."""

    prepared: Prepared
    ran: InjectedRun
    path: Path


def write(path: Path, prepared: Prepared, ran: InjectedRun) -> Played:
    """The recording of a run."""
    path.write_bytes(cycle_recording.record(prepared, ran, BEGAN_NS))
    return Played(prepared, ran, path)


def play(path: Path, choice: CycleChoice) -> Played:
    """A cycle, and its recording."""
    prepared = cycle_run.oxygenate(cycle_run.prepare(resolution.resolve(choice)))
    return write(path, prepared, fault_run.play(prepared, lambda _: None))


class Contents(NamedTuple):
    """All that is in a recording."""

    names: dict[str, list[str]]
    """Of the columns of each topic."""
    tables: dict[str, Table]
    told: list[TimedEvent]

    def column(self, topic: str, name: str) -> Table:
        """The numbers of a column."""
        return self.tables[topic][:, self.names[topic].index(name)]


def read(path: Path) -> Contents:
    """A recording in memory; it must be whole."""
    reader = RecordingReader(path)
    parts: dict[str, list[Table]] = {topic: [] for topic in reader.tables}
    told = []
    for one in reader.contents():
        if isinstance(one, Rows):
            parts[one.topic].append(one.table)
        else:
            told.append(one)
    assert reader.flaw is None
    names = {topic: [one.name for one in columns] for topic, columns in reader.tables.items()}
    tables = {topic: np.concatenate(rows) for topic, rows in parts.items() if rows}
    return Contents(names, tables, told)


def without_rows(recording: Path) -> bytes:
    """What a recorder leaves that stops before it has written a row of it."""
    with closing(RecordingReader(recording)) as reader, BytesIO() as file:
        RecordingWriter(file, reader.heading, TABLES)
        return file.getvalue()


def without_truth(recording: Path, to: Path, skip: slice = slice(0)) -> Path:
    """The same as a machine in real time leaves it. skip: rows of the ticks that are lost."""
    reader = RecordingReader(recording)
    contents = list(reader.contents())
    with RecordingWriter(to, reader.heading, TABLES) as file:
        for one in contents:
            if isinstance(one, TimedEvent):
                file.add_event(one.time_ns, one.event)
        for topic in TABLES:
            rows = [one for one in contents if isinstance(one, Rows) and one.topic == topic]
            times = np.concatenate([one.times_ns for one in rows])
            table = np.concatenate([one.table for one in rows])
            lost = range(*skip.indices(len(table))) if topic == TICKS else ()
            file.add_rows(topic, np.delete(times, lost), np.delete(table, lost, axis=0))
    return to
