"""Recordings bound by their hashes, whatever happens to the recorder while it writes them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from opensuction.host.host import finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import Read
from opensuction.kernel.record import Array
from opensuction.recording.cycle_file import frame
from opensuction.recording.cycle_file.frame import Extent
from opensuction.recording.cycle_file.reader import RecordingReader
from opensuction.records.entry import BoundFile
from opensuction.records.records import Records
from opensuction.records.trail.chain import AuditReport
from opensuction.runtime import flushed, machine_folder
from opensuction.runtime.database_writer import DatabaseWriter
from opensuction.runtime.flushed import Flushed, Note
from opensuction.runtime.recorder import Recorder
from tests.controller.bedside import hurried
from tests.runtime.identity import ABOUT
from tests.runtime.stepped_room import SteppedRoom
from tests.runtime.test_recorder import PIECE, REST_S, STATE, broken_off, heading

DIES_AT = 600
"""Row in which a recorder dies: within the cycle."""


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> Array:
    """A cycle that is broken off, with the rest before and after it."""
    stepped = SteppedRoom(tmp_path_factory.mktemp("room"), *hurried(REST_S))
    stepped.run(0.2)
    broken_off(stepped)
    stepped.run(1.5)
    stepped.close()
    return np.array(stepped.rows)


class Kept:
    """A folder of recordings, a machine's folder, and a database."""

    def __init__(self, folder: Path) -> None:
        self.out, self.notes = folder / "out", folder / "recorder.flushed"
        self.database = str(folder / "records.db")
        self.out.mkdir()

    def record(self, rows: Array, after: int = 0, notes: Flushed | None = None) -> Recorder:
        """A recorder that takes these rows, and is not told to end."""
        notes = notes or Flushed(self.notes)
        recorder = Recorder(self.out, "run", heading, rows[0, STATE], after + 1, notes)
        for first in range(1, len(rows), PIECE):
            recorder.take(Read(rows[first : first + PIECE], after + first + 1, 0), [])
            assert not recorder.lost
        return recorder

    def record_and_die(self, rows: Array) -> Recorder:
        """A recorder that is killed after these rows."""
        recorder = self.record(rows)
        assert recorder._recording is not None, "it was recording"
        recorder._recording._writer._file.close()
        return recorder

    def bind(self) -> Flushed:
        """As a recorder does that begins anew: what the one before has left goes on record."""
        notes, clerk = Flushed(self.notes), DatabaseWriter(self.database)
        clerk.bind(notes.left(), notes, ABOUT.machine)
        assert finish(clerk.close(20.0), THIS_COMPUTER.clock), clerk.lost
        assert notes.left() == {}, "and is noted no longer"
        return notes

    def audit(self) -> AuditReport:
        with Records.open(self.database) as records:
            return records.audit()

    def files(self) -> list[Path]:
        return sorted(self.out.glob("*.mcap"), key=lambda path: len(path.name))


@pytest.fixture
def kept(tmp_path: Path) -> Kept:
    return Kept(tmp_path)


def test_a_recording_that_was_closed_is_bound_as_it_lies_there(rows: Array, kept: Kept) -> None:
    recorder = kept.record(rows)
    (path,) = kept.files()
    assert recorder.take_ended() == [path.name]
    assert recorder.take_ended() == []
    note = Flushed(kept.notes).left()[path.name]
    (found,) = frame.measure(path)
    expected = BoundFile(path.name, path.name, 1, str(kept.out), *found, True)
    assert flushed.bind(path.name, note) == expected
    reader = RecordingReader(path)
    reader.close()
    about = reader.heading.about
    assert (about["run"], about["recording"], about["file"]) == ("run", path.name, path.name)
    kept.bind()
    assert (kept.audit().broken, kept.audit().recordings) == (None, 1)


def test_what_a_recorder_left_as_it_died_is_bound_and_so_is_the_next_part(
    rows: Array, kept: Kept
) -> None:
    died = kept.record_and_die(rows[:DIES_AT])
    assert died.take_ended() == []
    kept.bind()
    kept.record(rows[died.kept - 1 :], died.kept - 1)
    kept.bind()
    first, second = kept.files()
    assert second.name == f"{first.stem}-2.mcap"
    report = kept.audit()
    assert (report.broken, report.recordings) == (None, 2)
    with Records.open(kept.database) as records:
        one, two = (records.history.find_recording(path.name) for path in (first, second))
    assert one is not None
    assert two is not None
    assert (one.file.is_closed, two.file.is_closed) == (False, True)
    assert (two.file.cycle_recording, two.file.part) == (first.name, 2)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-1000])


def change(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def add(path: Path) -> None:
    path.write_bytes(path.read_bytes() + b"more")


HANDS: dict[str, tuple[Callable[[Path], object], str]] = {
    "cut": (cut, "was cut: "),
    "changed": (change, "was changed: "),
    "added to": (add, "was added to: "),
    "removed": (Path.unlink, "is missing in "),
}


@pytest.mark.parametrize("is_bound", [False, True], ids=["before another begins", "after it"])
@pytest.mark.parametrize("hand", HANDS)
def test_one_that_a_recorder_left_and_somebody_changed_is_found(
    rows: Array, kept: Kept, hand: str, is_bound: bool
) -> None:
    tamper, words = HANDS[hand]
    kept.record_and_die(rows[:DIES_AT])
    (path,) = kept.files()
    if not is_bound:
        tamper(path)
    notes = kept.bind()
    if is_bound:
        tamper(path)
    kept.record(rows[DIES_AT:], DIES_AT, notes)
    kept.bind()
    assert kept.files()[-1].name == f"{path.stem}-2.mcap", "it took no name that was used"
    assert words in str(kept.audit().broken), kept.audit()


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0], ids=["before", "within", "after"])
def test_killed_in_a_write_the_file_is_bound_as_it_was_left(kept: Kept, share: float) -> None:
    path = kept.out / "run-000000001.mcap"
    whole = bytes(range(256)) * 10
    path.write_bytes(whole)
    before, after = frame.measure(path, 2000)
    path.write_bytes(whole[: round(2000 + share * 560)])
    Flushed(kept.notes).put(path.name, Note(path.name, 1, str(kept.out), before, after))
    kept.bind()
    assert (kept.audit().broken, kept.audit().recordings) == (None, 1)


def test_notes_outlive_the_machine_until_they_are_on_record(rows: Array, kept: Kept) -> None:
    """All of its processes were killed, and a new machine begins in its folder."""
    kept.record_and_die(rows[:DIES_AT])
    (kept.notes.parent / "control.ring").touch()
    kept.out.rename(kept.out.parent.parent / f"{kept.out.parent.name}-out")
    machine_folder.clear(kept.notes.parent)
    assert [path.name for path in kept.notes.parent.iterdir()] == [kept.notes.name]
    kept.bind()
    assert not kept.notes.exists(), "then nothing of them is left"


@pytest.mark.parametrize("missing_bytes", [1, 40])
def test_a_note_that_was_not_written_to_its_end_leaves_the_one_before(
    tmp_path: Path, missing_bytes: int
) -> None:
    """Who dies as it announces a write has not begun it."""
    path, notes = tmp_path / "recorder.flushed", Flushed(tmp_path / "recorder.flushed")
    for size in (10, 20):
        notes.put("a.mcap", Note("a.mcap", 1, "", after=Extent(size, "")))
    path.write_bytes(path.read_bytes()[: -1 - missing_bytes])
    assert [note.after.size_bytes for note in Flushed(path).left().values()] == [10]


def test_notes_take_no_more_room_however_often_a_file_is_written_to(tmp_path: Path) -> None:
    path = tmp_path / "recorder.flushed"
    notes = Flushed(path)
    for size in range(1000):
        notes.put("a.mcap", Note("a.mcap", 1, "", after=Extent(size, "0" * 64)))
        assert path.stat().st_size <= flushed.LONGEST_BYTES
    notes.put("b.mcap", Note("b.mcap", 1, ""))
    assert {name: one.after.size_bytes for name, one in Flushed(path).left().items()} == {
        "a.mcap": 999,
        "b.mcap": 0,
    }


@pytest.mark.parametrize("content", ["", "{", "[]", '{"a.mcap": [1]}', '{"a.mcap": 7}'])
def test_notes_that_cannot_be_read_are_none(tmp_path: Path, content: str) -> None:
    path = tmp_path / "recorder.flushed"
    path.write_text(content)
    assert Flushed(path).left() == {}


def test_notes_that_cannot_be_written_end_no_recording(
    rows: Array, kept: Kept, capsys: pytest.CaptureFixture[str]
) -> None:
    kept.notes = kept.out / "nowhere" / "recorder.flushed"
    recorder = kept.record(rows)
    assert recorder.take_ended() == [kept.files()[0].name]
    assert capsys.readouterr().err.count("cannot be written") == 1
