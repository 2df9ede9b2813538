"""Recordings behind the back of their records: whatever is done to them, an audit says it."""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.records import audit, recording_check
from opensuction.records.records import Records
from tests.recording.cycle_file import example
from tests.records import recorded
from tests.records.example import MACHINE, check_after, fill, start, unguarded
from tests.records.recorded import name_of

ONE, TWO, TORN, GONE_ON = name_of(1), name_of(2), name_of(3), name_of(3, 2)
LONG_AGO_S = 100.0


class Kept(NamedTuple):
    """Recordings, where they lie, and a database that knows them; each test has a copy of both."""

    folder: Path
    copy: Path
    database: Path


@pytest.fixture(scope="module")
def kept(sqlite_template: Path, tmp_path_factory: pytest.TempPathFactory) -> Kept:
    within = tmp_path_factory.mktemp("kept")
    folder, copy = within / "recordings", within / "copy"
    folder.mkdir()
    database = shutil.copy(sqlite_template, within / "records.db")
    with Records.open(str(database)) as records:
        recorded.fill(records, folder)
    folder.rename(copy)
    return Kept(folder, copy, Path(database))


@pytest.fixture
def folder(kept: Kept, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Of recordings that nobody writes to any more."""
    monkeypatch.setattr(recording_check, "RECENT_S", -1.0)
    shutil.copytree(kept.copy, kept.folder)
    yield kept.folder
    shutil.rmtree(kept.folder, ignore_errors=True)  # some are moved, or gone


@pytest.fixture
def records(tmp_path: Path, kept: Kept, folder: Path) -> Iterator[Records]:  # noqa: ARG001
    url = str(shutil.copy(kept.database, tmp_path / "records.db"))
    with Records.open(url) as opened:
        yield opened


def swap(folder: Path) -> None:
    (folder / ONE).rename(folder / "aside")
    (folder / TWO).rename(folder / ONE)
    (folder / "aside").rename(folder / TWO)


def copy_over(folder: Path) -> None:
    shutil.copyfile(folder / TWO, folder / ONE)


def change_byte(folder: Path, at: int) -> None:
    """And the time of the last change is what it was."""
    path = folder / ONE
    facts, data = path.stat(), bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(data)
    os.utime(path, ns=(facts.st_atime_ns, facts.st_mtime_ns))


def cut(folder: Path, name: str, by: int) -> None:
    path = folder / name
    path.write_bytes(path.read_bytes()[:-by])


def add_to(folder: Path, name: str) -> None:
    path = folder / name
    path.write_bytes(path.read_bytes() + b"more")


def put_older(folder: Path) -> None:
    """A copy of the same recording from when it was being written."""
    recorded_until_then = (folder / ONE).read_bytes()[:5000]
    (folder / ONE).write_bytes(recorded_until_then)


def write_anew(folder: Path) -> None:
    """Another recording that says that it is this one, sound by all checksums of its own."""
    (folder / ONE).unlink()
    recorded.write(folder, 1, rows=100)


def put_another_run_s(folder: Path) -> None:
    about = {**example.HEADING.about, "file": "20260101T000000-00c0ffee-000000001.mcap"}
    (folder / ONE).unlink()
    heading = example.HEADING._replace(about=about)
    with RecordingWriter(folder / ONE, heading, {"/tick": example.COLUMNS}) as file:
        file.add_rows("/tick", example.times_ns(9), example.rows(9))


def link(folder: Path) -> None:
    (folder / ONE).rename(folder / "elsewhere")
    (folder / ONE).symlink_to(folder / "elsewhere")


def put_folder(folder: Path) -> None:
    (folder / ONE).unlink()
    (folder / ONE).mkdir()


def swap_parts(folder: Path) -> None:
    (folder / TORN).rename(folder / "aside")
    (folder / GONE_ON).rename(folder / TORN)
    (folder / "aside").rename(folder / GONE_ON)


FILES: dict[str, tuple[Callable[[Path], object], str]] = {
    "swapped with another cycle's": (
        swap,
        f"the recording {ONE} of cycle 1 of machine M-1 was swapped: the file there is the "
        f"recording {TWO} of cycle 2 of machine M-1",
    ),
    "another cycle's copied over it": (copy_over, "was swapped: the file there is the recordi"),
    "another run's put there": (
        put_another_run_s,
        "the file there says that it is the recording 20260101T000000-00c0ffee-000000001.mcap",
    ),
    "written anew": (write_anew, "cycle 1 of machine M-1 was cut: "),
    "an older copy of it": (put_older, "was cut: 5000 bytes are there, "),
    "a byte of its rows": (lambda folder: change_byte(folder, 6000), "was changed: its bytes"),
    "a byte of its heading": (lambda folder: change_byte(folder, 100), "was changed: its bytes"),
    "a byte of its end": (lambda folder: change_byte(folder, -1), "was changed: its bytes"),
    "cut by a byte": (lambda folder: cut(folder, ONE, 1), "was cut: "),
    "emptied": (lambda folder: (folder / ONE).write_bytes(b""), "was cut: 0 bytes are there"),
    "added to": (
        lambda folder: add_to(folder, ONE),
        "was added to: ",
    ),
    "removed": (lambda folder: (folder / ONE).unlink(), "cycle 1 of machine M-1 is missing in "),
    "a folder in its place": (
        put_folder,
        "is a link or no plain file",
    ),
    "a link in its place": (link, "is a link or no plain file"),
    "all of them removed": (shutil.rmtree, "of 4 recordings on record is not here"),
    "one that a recorder left as it died, cut": (
        lambda folder: cut(folder, TORN, 100),
        f"the recording {TORN} of cycle 3 of machine M-1 was cut: 3900 bytes are there, 4000",
    ),
    "one that a recorder left as it died, gone on with": (
        lambda folder: add_to(folder, TORN),
        f"{TORN} of cycle 3 of machine M-1 was added to: 4004 bytes are there",
    ),
    "a part of it removed": (
        lambda folder: (folder / GONE_ON).unlink(),
        f"the recording {GONE_ON} of cycle 3 of machine M-1 is missing in ",
    ),
    "its parts in each other's place": (swap_parts, f"the file there is the recording {GONE_ON}"),
    "a part put beside it": (
        lambda folder: recorded.write(folder, 1, part=2),
        f"{name_of(1, 2)} lies beside the recording {ONE} of cycle 1 of machine M-1, and no "
        "recorder has put it on record",
    ),
}
ROWS: dict[str, tuple[str, str]] = {
    "the hash on record": (
        f"UPDATE recording SET sha256 = '{'a' * 64}' WHERE name = '{ONE}'",
        f"recording '{ONE}' of entry",
    ),
    "the length on record": (
        f"UPDATE recording SET size_bytes = 7 WHERE name = '{ONE}'",
        "was changed: its size_bytes is not what it was",
    ),
    "which cycle it is of": (
        f"UPDATE recording SET cycle_recording = '{TWO}' WHERE name = '{ONE}'",
        "was changed: its cycle_recording is not what it was",
    ),
    "which recording a cycle has": (
        f"UPDATE cycle SET recording = '{TWO}' WHERE recording = '{ONE}'",
        "was changed: its recording is not what it was",
    ),
    "where it lies": (
        "UPDATE recording SET folder = '/nowhere'",
        "was changed: its folder is not what it was",
    ),
    "that it was closed": (
        f"UPDATE recording SET is_closed = FALSE WHERE name = '{ONE}'",
        "was changed: its is_closed is not what it was",
    ),
    "its row taken out": (f"DELETE FROM recording WHERE name = '{ONE}'", f"'{ONE}' of entry"),
    "a row put in": (
        "INSERT INTO recording SELECT 'x.mcap', machine_serial, cycle_recording, part, folder, "
        f"size_bytes, sha256, is_closed, bound_at FROM recording WHERE name = '{ONE}'",
        "'recording' has 5 rows, the trail tells of 4",
    ),
}


def test_recordings_as_their_recorders_left_them_are_whole(records: Records) -> None:
    report = records.audit()
    assert (report.broken, report.faults) == (None, ())
    assert (report.recordings, report.unbound) == (4, 0)


@pytest.mark.parametrize("how", FILES)
def test_whatever_is_done_to_a_recording_is_said(records: Records, folder: Path, how: str) -> None:
    tamper, words = FILES[how]
    tamper(folder)
    report = records.audit()
    assert any(words in one for one in report.faults), report.faults
    assert report.broken == report.faults[0]
    assert all(len(one.splitlines()) == 1 for one in report.faults)


@pytest.mark.parametrize("how", ROWS)
def test_whatever_is_done_to_the_row_of_a_recording_is_said(records: Records, how: str) -> None:
    statement, words = ROWS[how]
    assert records.audit().broken is None
    with unguarded(records) as connection:
        connection.exec_driver_sql(statement)
    assert words in str(records.audit().broken)


@pytest.mark.sweep
def test_the_same_is_said_of_a_server_s_rows(postgresql_url: str, folder: Path) -> None:
    with Records.open(postgresql_url) as records:
        shutil.rmtree(folder)
        folder.mkdir()
        recorded.fill(records, folder)
        for how, (statement, words) in ROWS.items():
            assert words in str(check_after(records, statement)), how
        assert records.audit().broken is None


def test_both_of_two_that_were_swapped_are_named(records: Records, folder: Path) -> None:
    swap(folder)
    assert [one.partition(" was swapped")[0] for one in records.audit().faults] == [
        f"the recording {ONE} of cycle 1 of machine M-1",
        f"the recording {TWO} of cycle 2 of machine M-1",
    ]


def test_files_and_row_changed_together_are_found_by_the_trail(
    records: Records, folder: Path
) -> None:
    """Whoever changes a file puts its new hash on record, too."""
    change_byte(folder, 6000)
    digest = recorded.bound(folder / ONE, 1).sha256
    with unguarded(records) as connection:
        connection.exec_driver_sql(f"UPDATE recording SET sha256 = '{digest}' WHERE name = '{ONE}'")
    assert "its sha256 is not what it was" in str(records.audit().broken)


def test_recordings_of_earlier_releases_are_unbound_and_no_error(url: str) -> None:
    with Records.open(url) as records:
        fill(records)
        assert (records.audit().broken, records.audit().unbound) == (None, 3)
        assert records.audit().unbound_since == ()


def test_one_without_a_hash_after_one_that_has_one_is_named(records: Records) -> None:
    """The computer went down, or somebody removed what its recorder had noted."""
    recorded.begin(records, 4)
    records.begin_cycle(start(catheter="C-5")._replace(recording=name_of(5)))
    report = records.audit()
    assert (report.broken, report.unbound) == (None, 1), "the one that goes on is not counted"
    assert report.unbound_since == (f"{name_of(4)} of cycle 4 of machine M-1",)


def test_what_a_recorder_writes_now_is_no_strange_part(
    records: Records, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording_check, "RECENT_S", LONG_AGO_S)
    recorded.write(folder, 3, part=3)
    assert records.audit().broken is None


def test_recordings_that_were_moved_are_looked_for_where_they_are_said_to_be(
    records: Records, folder: Path, tmp_path: Path
) -> None:
    moved = tmp_path / "moved"
    folder.rename(moved)
    assert records.audit().broken is not None
    database = records.database
    assert audit.audit(database, audit.AuditScope(recordings=moved)).broken is None
    cut(moved, ONE, 1)
    assert audit.audit(database, audit.AuditScope(recordings=moved)).broken is not None
    assert audit.audit(database, audit.AuditScope(reads_recordings=False)).broken is None


def test_a_recording_is_put_on_record_once(records: Records, folder: Path) -> None:
    before = records.head()
    file = recorded.bound(folder / ONE, 1)
    records.bind_recording(MACHINE, file)
    assert records.head() == before
    with pytest.raises(InputError, match=rf"recording '{ONE}' is on record with size_bytes"):
        records.bind_recording(MACHINE, file._replace(size_bytes=7))


@pytest.mark.parametrize(
    "change",
    [{"name": "../a.mcap"}, {"sha256": "abc"}, {"size_bytes": -1}, {"part": 0}, {"folder": ""}],
)
def test_what_is_no_file_of_a_recording_is_refused(
    records: Records, folder: Path, change: dict[str, Any]
) -> None:
    with pytest.raises(InputError):
        records.bind_recording(MACHINE, recorded.bound(folder / ONE, 1)._replace(**change))
