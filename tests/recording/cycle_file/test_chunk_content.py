"""Chunks with anything in them: rows and events, or one error that says what is wrong."""

import zlib
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from mcap.records import Chunk
from mcap.stream_reader import StreamReader

from opensuction.recording.cycle_file import frame
from opensuction.recording.cycle_file import reader as cycle_reader
from opensuction.recording.cycle_file.reader import ChunkReader, DamageError, Rows
from tests.recording.cycle_file import example


def chunk(content: bytes, packed: bytes | None = None, size: int | None = None) -> bytes:
    """A chunk as a reader gets it, its checksum right."""
    record = Chunk(
        compression="zstd",
        data=zstandard.compress(content) if packed is None else packed,
        message_end_time=0,
        message_start_time=0,
        uncompressed_crc=zlib.crc32(content),
        uncompressed_size=len(content) if size is None else size,
    )
    return frame.record_bytes(record)[frame.RECORD_HEAD.size :]


@pytest.fixture(scope="module")
def contents(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, bytes]:
    """What is in the first two chunks of a recording: descriptions, and rows with an event."""
    path: Path = tmp_path_factory.mktemp("chunks") / "a.mcap"
    example.write(path, 30)
    with path.open("rb") as file:
        records = list(StreamReader(file, emit_chunks=True).records)
    first, second = (one for one in records if isinstance(one, Chunk))
    return zstandard.decompress(first.data), zstandard.decompress(second.data)


def test_rows_come_out_as_they_went_in(contents: tuple[bytes, bytes]) -> None:
    reader = ChunkReader()
    assert reader.read(chunk(contents[0])) == []
    found = reader.read(chunk(contents[1]))
    tables = [one.table for one in found if isinstance(one, Rows) and one.topic == "/tick"]
    assert np.array_equal(np.concatenate(tables), example.rows(30))


@given(st.data())
def test_any_content_gives_rows_or_damage(
    contents: tuple[bytes, bytes], data: st.DataObject
) -> None:
    reader = ChunkReader()
    changed = [bytearray(one) for one in contents]
    which = data.draw(st.sampled_from([0, 1]))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(changed[which]) - 1))
        changed[which][at] = data.draw(st.integers(0, 255))
    end = data.draw(st.integers(0, len(changed[which])))
    if data.draw(st.booleans()):
        del changed[which][end:]
    try:
        for one in changed:
            for found in reader.read(chunk(bytes(one))):
                assert not isinstance(found, Rows) or len(found.times_ns) == len(found.table)
    except DamageError as damage:
        assert str(damage)


def test_a_chunk_larger_than_the_limit_is_not_unpacked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cycle_reader, "LARGEST_BYTES", 1_000_000)
    with pytest.raises(DamageError, match="another size than it says"):
        cycle_reader.unpack(chunk(bytes(1_000_001)))
    bomb = bytes.fromhex("28b52ffde06c06060663636363")  # states 460 PB: python-zstandard#332
    stated = zstandard.get_frame_parameters(bomb).content_size
    with pytest.raises(DamageError, match="another size than it says"):
        cycle_reader.unpack(chunk(b"", packed=bomb, size=stated))


def test_another_packing_is_refused_by_name() -> None:
    record = Chunk("lz4", b"", 0, 0, 0, 0)
    with pytest.raises(DamageError, match="packed as 'lz4'"):
        cycle_reader.unpack(frame.record_bytes(record)[frame.RECORD_HEAD.size :])
