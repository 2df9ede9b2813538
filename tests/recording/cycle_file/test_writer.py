import errno
import hashlib
import signal
import subprocess
import sys
from io import FileIO
from pathlib import Path

import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import NonSeekingReader, SeekingReader

from opensuction.recording.cycle_file import frame, writer
from opensuction.recording.cycle_file.frame import Extent
from opensuction.recording.cycle_file.reader import RecordingReader, Rows
from opensuction.recording.cycle_file.writer import RecordingWriter
from tests.recording.cycle_file import example


def test_the_format_s_own_library_reads_it_with_every_checksum(tmp_path: Path) -> None:
    path = example.write(tmp_path / "a.mcap")
    with path.open("rb") as file:
        messages = list(NonSeekingReader(file, validate_crcs=True).iter_messages())
    topics = [channel.topic for _, channel, _ in messages]
    assert [topics.count(name) for name in ("/tick", "/start", "/event")] == [230, 1, 1]
    assert [message.log_time for _, _, message in messages] == sorted(
        message.log_time for _, _, message in messages
    )


def test_who_seeks_by_its_index_finds_a_span_and_its_statistics(tmp_path: Path) -> None:
    path = example.write(tmp_path / "a.mcap")
    with path.open("rb") as file:
        reader = SeekingReader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 232
        assert summary.statistics.message_end_time == example.BEGAN_NS + 229_000_000
        begin = example.BEGAN_NS + 60_000_000
        end = begin + 10_000_000
        found = list(reader.iter_messages("/tick", starting_at=begin, ending_before=end))
        assert [message.sequence for _, _, message in found] == list(range(60, 70))
        assert [one.name for one in reader.iter_metadata()] == ["opensuction", "settings"]


def test_who_knows_only_the_file_reads_the_fields_by_name(tmp_path: Path) -> None:
    path = example.write(tmp_path / "a.mcap")
    with path.open("rb") as file:
        for schema, channel, message in NonSeekingReader(file).iter_messages():
            assert schema is not None
            assert schema.encoding == channel.message_encoding == "protobuf"
            pool = DescriptorPool()
            pool.Add(FileDescriptorSet.FromString(schema.data).file[0])
            kind = GetMessageClass(pool.FindMessageTypeByName(schema.name))
            read = kind.FromString(message.data)
            if channel.topic == "/tick" and message.sequence == 7:
                assert read.inputs.readings.head_mm == np.sin(7.0) * 1e-3
                assert read.inputs.readings.head_valid is True
            if channel.topic == "/event":
                assert (read.kind, read.name, read.who) == ("request", "start", "nurse 4")


@pytest.mark.parametrize("added", [1, 49, 50, 51, 130])
def test_at_most_a_chunk_of_rows_waits_and_flush_leaves_none(tmp_path: Path, added: int) -> None:
    path, tables = tmp_path / "a.mcap", {"/tick": example.COLUMNS}
    with RecordingWriter(path, example.HEADING, tables) as file:
        file.add_rows("/tick", example.times_ns(added), example.rows(added))
        assert _rows_in(path) == added // 50 * 50
        file.flush()
        assert _rows_in(path) == added


@pytest.mark.parametrize(
    ("added", "chunks"),
    [(49, []), (130, [130]), (1000, [1000]), (1001, [1000]), (2100, [1000, 1000, 100])],
)
def test_what_comes_at_once_is_written_at_once(
    tmp_path: Path, added: int, chunks: list[int]
) -> None:
    """For a disk that has kept the writer waiting; what is left waits for more as ever."""
    path, tables = tmp_path / "a.mcap", {"/tick": example.COLUMNS}
    with RecordingWriter(path, example.HEADING, tables, most_rows=1000) as file:
        file.add_rows("/tick", example.times_ns(added), example.rows(added))
        found = RecordingReader(path).contents()
        assert [len(one.table) for one in found if isinstance(one, Rows)] == chunks


def test_nothing_waits_longer_than_a_tenth_of_a_second(tmp_path: Path) -> None:
    path, tables, step_s = tmp_path / "a.mcap", {"/tick": example.COLUMNS}, 0.02
    with RecordingWriter(path, example.HEADING, tables) as file:
        added_at_s: list[float] = []
        for step in range(40):
            now_s = 5.0 + step * step_s
            if step % 3 == 0:  # a row now and then: a chunk never fills
                first = len(added_at_s)
                file.add_rows("/tick", example.times_ns(1, first), example.rows(1, first))
                added_at_s.append(now_s)
            file.keep_up(now_s)
            due = sum(at_s <= now_s - 0.1 for at_s in added_at_s)
            assert _rows_in(path) >= due


def test_what_comes_soon_shares_a_chunk(tmp_path: Path) -> None:
    path, tables = tmp_path / "a.mcap", {"/tick": example.COLUMNS}
    with RecordingWriter(path, example.HEADING, tables) as file:
        for row in range(4):
            file.add_rows("/tick", example.times_ns(1, row), example.rows(1, row))
            file.keep_up(7.0 + 0.01 * row)
            assert _rows_in(path) == 0


def _rows_in(path: Path) -> int:
    reader = RecordingReader(path)
    return sum(len(one.table) for one in reader.contents() if isinstance(one, Rows))


def test_what_was_flushed_survives_a_kill(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    script = (
        "import sys\n"
        "from pathlib import Path\n"
        "from opensuction.recording.cycle_file.writer import RecordingWriter\n"
        "from tests.recording.cycle_file import example as e\n"
        "file = RecordingWriter(Path(sys.argv[1]), e.HEADING, {'/tick': e.COLUMNS})\n"
        "file.add_rows('/tick', e.times_ns(120), e.rows(120))\n"
        "file.flush()\n"
        "file.add_rows('/tick', e.times_ns(30, 120), e.rows(30, 120))\n"
        "print('waiting', flush=True)\n"
        "sys.stdin.read()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"waiting\n"
        process.send_signal(signal.SIGKILL)
    reader = RecordingReader(path)
    tables = [one.table for one in reader.contents() if isinstance(one, Rows)]
    assert np.array_equal(np.concatenate(tables), example.rows(120))
    assert reader.flaw is not None
    assert "was not finished" in reader.flaw
    assert "120 rows, 0.119 s, could be read" in reader.flaw


class _SmallDisk(FileIO):
    """A disk with room for so many bytes, which takes the first part of a write."""

    room = 0

    def write(self, data: object) -> int:
        raw = bytes(data)  # type: ignore[call-overload]
        left = self.room - self.tell()
        if left <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(raw[:left])


def test_a_full_disk_loses_a_chunk_and_nothing_that_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "FileIO", _SmallDisk)
    path = tmp_path / "a.mcap"
    _SmallDisk.room = 10**9
    file = RecordingWriter(path, example.HEADING, {"/tick": example.COLUMNS})
    file.add_rows("/tick", example.times_ns(50), example.rows(50))
    size = path.stat().st_size
    _SmallDisk.room = size + 40
    with pytest.raises(OSError, match=r"No space left on device.*a\.mcap"):
        file.add_rows("/tick", example.times_ns(50, 50), example.rows(50, 50))
    assert path.stat().st_size == size
    _SmallDisk.room = 10**9
    file.add_rows("/tick", example.times_ns(50, 100), example.rows(50, 100))
    file.close()
    reader = RecordingReader(path)
    tables = [one.table for one in reader.contents() if isinstance(one, Rows)]
    expected = np.concatenate((example.rows(50), example.rows(50, 100)))
    assert np.array_equal(np.concatenate(tables), expected)
    assert reader.flaw is None
    with path.open("rb") as stream:
        summary = SeekingReader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 100


def test_a_disk_that_is_full_from_the_start_is_said_and_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "FileIO", _SmallDisk)
    _SmallDisk.room = 20
    path = tmp_path / "a.mcap"
    with pytest.raises(OSError, match=r"No space left on device.*a\.mcap"):
        RecordingWriter(path, example.HEADING, {"/tick": example.COLUMNS})
    assert not path.exists(), "or each try would leave one"


def test_each_write_is_told_before_it_is_made_and_taken_back_where_it_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever kills the writer, the file is what was told, or ends within the last write."""
    path, told = tmp_path / "a.mcap", list[tuple[Extent, Extent]]()

    def tell(before: Extent, after: Extent) -> None:
        assert frame.measure(path) == [before], "it is as it was"
        told.append((before, after))

    monkeypatch.setattr(writer, "FileIO", _SmallDisk)
    _SmallDisk.room = 20_000
    with RecordingWriter(
        path, example.HEADING, {"/tick": example.COLUMNS}, 50, flushing=tell
    ) as file:
        file.add_rows("/tick", example.times_ns(100), example.rows(100))
        assert frame.measure(path) == [file.extent]
        _SmallDisk.room = 10
        with pytest.raises(OSError, match="No space"):
            file.add_rows("/tick", example.times_ns(50), example.rows(50))
        assert told[-1] == (file.extent, file.extent)
        assert frame.measure(path) == [file.extent]
        _SmallDisk.room = 20_000
    assert frame.measure(path) == [file.extent] == [told[-1][1]]
    assert told[-1][1].sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


def test_a_file_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    path = example.write(tmp_path / "a.mcap")
    with pytest.raises(FileExistsError):
        RecordingWriter(path, example.HEADING, {"/tick": example.COLUMNS})


def test_a_table_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    with (
        RecordingWriter(tmp_path / "a", example.HEADING, {"/tick": example.COLUMNS}) as file,
        pytest.raises(ValueError, match=r"/tick: a table of \(3, 5\) for 3 rows"),
    ):
        file.add_rows("/tick", example.times_ns(3), example.rows(3)[:, :5])
