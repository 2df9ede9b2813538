"""Simulated runs and their recordings, for the tests of everything that reads one."""

from collections.abc import Iterable
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
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.injection import InjectedRun

BEGAN_NS = 1_795_000_000_000_000_000
AFTERMATH_S = 5.0
"""What these recordings keep of the minute and a half for which a patient is followed: its rows,
nine of ten of a cycle's, are alike."""


class Played(NamedTuple):
    """A run and its recording."""

    prepared: Prepared
    ran: InjectedRun
    path: Path


def shorten(ran: InjectedRun, aftermath_s: float) -> InjectedRun:
    """A run that ends so long after the last phase and the last controller in it have begun."""
    changes = np.flatnonzero(np.diff(ran.columns["phase"]))
    last = max(int(changes[-1]) + 1, *(span.first for span in ran.spans))
    end = min(last + round(aftermath_s / DT_S), ran.columns["phase"].size)
    spans = (one._replace(ticks=min(one.end, end) - one.first) for one in ran.spans)
    return ran._replace(
        columns={name: values[:end] for name, values in ran.columns.items()},
        sent={name: values[:end] for name, values in ran.sent.items()},
        spans=tuple(spans),
    )


def write(
    path: Path, prepared: Prepared, ran: InjectedRun, aftermath_s: float = AFTERMATH_S
) -> Played:
    """The recording of a run, and of what of it is there. aftermath_s: see `shorten`."""
    kept = shorten(ran, aftermath_s)
    path.write_bytes(cycle_recording.record(prepared, kept, BEGAN_NS))
    return Played(prepared, kept, path)


def play(path: Path, choice: CycleChoice, aftermath_s: float = AFTERMATH_S) -> Played:
    """A cycle, and its recording. aftermath_s: see `shorten`."""
    prepared = cycle_run.oxygenate(cycle_run.prepare(resolution.resolve(choice)))
    return write(path, prepared, fault_run.play(prepared, lambda _: None), aftermath_s)


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
    return gather(reader, reader.contents())


def gather(reader: RecordingReader, read: Iterable[Rows | TimedEvent]) -> Contents:
    """What was read of a recording, in memory; it must be whole."""
    parts: dict[str, list[Table]] = {topic: [] for topic in reader.tables}
    told = []
    for one in read:
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
