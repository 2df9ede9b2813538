"""Recordings as recorders leave them, in a folder and on record, and cycles that they are of."""

from datetime import timedelta
from pathlib import Path

from opensuction.recording.cycle_file import frame
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.records.entry import BoundFile, CycleEnd, Outcome
from opensuction.records.records import Records
from tests.recording.cycle_file import example
from tests.records.example import MACHINE, NOON, start

RUN = "20261123T120000-0badcafe"
OUTCOMES = (Outcome.COMPLETED, Outcome.ABORTED, Outcome.INTERRUPTED)
TORN = 4000
"""Bytes of the part that its recorder left as it died."""


def name_of(cycle: int, part: int = 1) -> str:
    return f"{RUN}-{1000 * cycle:09d}{'' if part == 1 else f'-{part}'}.mcap"


def write(folder: Path, cycle: int, part: int = 1, rows: int = 230) -> Path:
    """The recording of a cycle, which says that it is."""
    path = folder / name_of(cycle, part)
    about = {**example.HEADING.about, "run": RUN, "recording": name_of(cycle), "file": path.name}
    heading = example.HEADING._replace(about=about)
    with RecordingWriter(path, heading, {"/tick": example.COLUMNS}) as file:
        first = 1000 * cycle + 500 * (part - 1)
        file.add_rows("/tick", example.times_ns(rows, first), example.rows(rows, first))
    return path


def bound(path: Path, cycle: int, part: int = 1, is_closed: bool = True) -> BoundFile:
    """A file as it is now."""
    (found,) = frame.measure(path)
    return BoundFile(path.name, name_of(cycle), part, str(path.parent), *found, is_closed)


def begin(records: Records, cycle: int) -> str:
    """A cycle that names its recording, and has ended."""
    at = NOON + timedelta(minutes=cycle)
    made = start(catheter=f"C-{cycle}")._replace(recording=name_of(cycle))
    known = records.begin_cycle(made, at=at)
    records.end_cycle(known, CycleEnd(OUTCOMES[cycle % 3]), at=at + timedelta(seconds=20))
    return known


def fill(records: Records, folder: Path) -> None:
    """Three cycles with their recordings; the last one's recorder died, and another went on."""
    for cycle in (1, 2, 3):
        begin(records, cycle)
        path = write(folder, cycle, rows=230 + cycle)
        if cycle == 3:
            path.write_bytes(path.read_bytes()[:TORN])
        records.bind_recording(MACHINE, bound(path, cycle, is_closed=cycle != 3))
    records.bind_recording(MACHINE, bound(write(folder, 3, part=2), 3, part=2))
