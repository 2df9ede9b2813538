from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.writer import Writer

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import frame
from opensuction.recording.cycle_file.reader import RecordingReader, Rows, TimedEvent
from opensuction.recording.cycle_file.row_schema import Table
from opensuction.recording.cycle_file.writer import MAGIC
from tests.recording.cycle_file import example


def read(path: Path) -> tuple[RecordingReader, Table, list[TimedEvent]]:
    """A recording with its rows and its events."""
    reader = RecordingReader(path)
    contents = list(reader.contents())
    tables = [one.table for one in contents if isinstance(one, Rows) and one.topic == "/tick"]
    table = np.concatenate(tables) if tables else np.empty((0, len(example.COLUMNS)))
    return reader, table, [one for one in contents if isinstance(one, TimedEvent)]


def test_everything_comes_back(tmp_path: Path) -> None:
    reader, table, told = read(example.write(tmp_path / "a.mcap"))
    assert table.tobytes() == example.rows(230).tobytes()
    assert told == [TimedEvent(example.BEGAN_NS + 3_000_000, example.EVENT)]
    assert reader.heading == example.HEADING
    assert reader.tables == {"/tick": example.COLUMNS, "/start": example.STARTS}
    assert reader.flaw is None
    assert not reader.is_damaged


def test_times_and_starts_come_back(tmp_path: Path) -> None:
    found = [
        one
        for one in RecordingReader(example.write(tmp_path / "a.mcap")).contents()
        if isinstance(one, Rows)
    ]
    assert found[0].topic == "/start"
    assert found[0].table.tolist() == [[0.0, 5.5]]
    times = np.concatenate([one.times_ns for one in found if one.topic == "/tick"])
    assert np.array_equal(times, example.times_ns(230))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A recording's bytes."""
    return example.write(tmp_path_factory.mktemp("whole") / "a.mcap").read_bytes()


@pytest.mark.parametrize("step", [23, pytest.param(1, marks=pytest.mark.soak)])
def test_cut_off_anywhere_it_gives_every_row_that_was_flushed(
    tmp_path: Path, whole: bytes, step: int
) -> None:
    expected, path = example.rows(230), tmp_path / "cut.mcap"
    most = 0
    for size in range(0, len(whole), step):
        path.write_bytes(whole[:size])
        try:
            reader, table, _ = read(path)
        except InputError as error:
            assert "\n" not in str(error)
            assert most == 0, "a longer piece is not worse than a shorter one"
            continue
        assert (len(table) + 1) % 50 == 0 or len(table) in (0, 230)  # one more is of /start
        assert len(table) >= most
        assert table.tobytes() == expected[: len(table)].tobytes()
        assert reader.flaw is not None
        assert f"ends at byte {size}" in reader.flaw
        assert not reader.is_damaged
        most = len(table)
    assert most == 230


@settings(max_examples=300, deadline=None)
@given(share=st.floats(0.0, 1.0, exclude_max=True), mask=st.integers(1, 255))
def test_a_byte_changed_anywhere_is_told_in_one_line_and_changes_no_row(
    whole: bytes, tmp_path_factory: pytest.TempPathFactory, share: float, mask: int
) -> None:
    at = int(share * len(whole))
    changed = bytearray(whole)
    changed[at] ^= mask
    path = tmp_path_factory.mktemp("changed") / "a.mcap"
    path.write_bytes(changed)
    try:
        reader, table, _ = read(path)
    except InputError as error:
        assert "\n" not in str(error)
        assert str(path) in str(error)
        return
    assert reader.flaw is not None, f"byte {at} was changed and nobody noticed"
    assert "could be read" in reader.flaw
    assert "\n" not in reader.flaw
    written = {row.tobytes() for row in example.rows(230)}
    assert {row.tobytes() for row in table} <= written
    assert (np.diff(table[:, 0]) > 0.0).all()


@pytest.mark.parametrize("chunk", range(5))
def test_a_chunk_that_is_damaged_costs_its_own_rows_and_no_other(
    whole: bytes, tmp_path: Path, chunk: int
) -> None:
    changed = bytearray(whole)
    changed[middle_of_chunks(whole)[1 + chunk]] ^= 1  # the first one describes the rows
    path = tmp_path / "a.mcap"
    path.write_bytes(changed)
    reader, table, _ = read(path)
    lost = range(max(50 * chunk - 1, 0), min(50 * chunk + 49, 230))  # a start is a row, too
    assert table[:, 0].tolist() == [tick for tick in range(230) if tick not in lost]
    assert reader.flaw is not None
    assert f"{230 - len(lost)} rows of " in reader.flaw
    assert reader.is_damaged


def middle_of_chunks(content: bytes) -> list[int]:
    """A byte of the packed rows in each chunk."""
    found, at = [], len(MAGIC)
    while at < len(content) - len(MAGIC):
        opcode, length = frame.RECORD_HEAD.unpack_from(content, at)
        if opcode == Opcode.CHUNK:
            found.append(at + frame.RECORD_HEAD.size + length - 10)
        at += frame.RECORD_HEAD.size + length
    return found


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"time_s,head_mm\n0,1\n", "is no MCAP file"),
        (b"\x89MCAP1\r\n" + bytes(30), "is an MCAP file of version b'1'"),
        (b"\x89MCAP0\r\n", "was not finished: it ends at byte 8"),
        (b"\x89MC", "is no MCAP file"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as refused:
        RecordingReader(path)
    assert "\n" not in str(refused.value)


def test_an_mcap_file_of_somebody_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        foreign = Writer(file)
        foreign.start(profile="ros2", library="rosbag2")
        schema = foreign.register_schema("a", "jsonschema", b"{}")
        channel = foreign.register_channel("/a", "json", schema)
        foreign.add_message(channel, 1, b"{}", 1)
        foreign.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(InputError, match="MCAP file by 'rosbag2', no recording of opensuction"):
        RecordingReader(path)


def test_a_newer_version_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as newer:
        newer.setattr(frame, "FORMAT", frame.FORMAT + 1)
        path = example.write(tmp_path / "a.mcap")
    with pytest.raises(
        InputError, match=r"of format 2, written by opensuction '1\.2\.3'; .* up to 1"
    ):
        RecordingReader(path)


def test_a_folder_and_a_missing_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        RecordingReader(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        RecordingReader(tmp_path / "none.mcap")
