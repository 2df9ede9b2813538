"""Writes a recording as it happens: what was flushed stays readable, whatever happens next.

A chunk goes to the system in one piece and is whole by itself. A disk that is full leaves the file
as it was after the last whole chunk; what could not be written is the caller's to tell.
"""

import hashlib
import zlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from io import BytesIO, FileIO
from pathlib import Path
from types import TracebackType

import numpy as np
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from numpy.typing import NDArray

from opensuction.host.host import File
from opensuction.recording.cycle_file import frame, row_schema
from opensuction.recording.cycle_file.frame import (
    EMPTY,
    PROFILE,
    Batch,
    Extent,
    Heading,
    to_metadata,
)
from opensuction.recording.cycle_file.row_schema import PACKAGE, RecordedEvent, SchemaColumn, Table

MAGIC = b"\x89MCAP0\r\n"
ENCODING = "protobuf"
EVENTS = "/event"
"""Topic of the events; those of rows are named by whoever writes them."""
FLUSHED_ROWS = 50
"""Rows of a chunk while a machine runs: 50 ms of them."""
WAITED_S = 0.05
"""How long anything may wait for its chunk to fill, as whoever asks finds it: asked every 50 ms,
nothing waits longer than 100 ms."""
PACKED_ROWS = 250
"""Rows that are packed at once: table and messages fit into a processor's second cache."""


Flushing = Callable[[Extent, Extent], None]
"""Told before each write how far the file goes, and how far it will; after it that it does."""
FirstRows = tuple[str, NDArray[np.uint64], Table]
"""Topic, times and table, as `RecordingWriter.add_rows` takes them."""


def _create(path: Path) -> File:
    return FileIO(path, "xb")


def message_name(topic: str) -> str:
    """Name of a topic's messages: ``/tick`` has ``Tick``."""
    return topic.strip("/").replace("/", "_").capitalize()


def _schemas_of(tables: Mapping[str, Sequence[SchemaColumn]]) -> list[Schema]:
    """Schemas of the topics, and of the events after them."""
    described = {
        topic: row_schema.describe(message_name(topic), columns)
        for topic, columns in tables.items()
    }
    return [
        Schema(id=i, name=f"{PACKAGE}.{message_name(topic)}", encoding=ENCODING, data=data)
        for i, (topic, data) in enumerate(
            {**described, EVENTS: row_schema.description()}.items(), 1
        )
    ]


class RecordingWriter:
    """An open recording."""

    def __init__(
        self,
        target: Path | BytesIO,
        heading: Heading,
        tables: Mapping[str, Sequence[SchemaColumn]],
        chunk_rows: int = FLUSHED_ROWS,
        most_rows: int | None = None,
        create: Callable[[Path], File] = _create,
        flushing: Flushing | None = None,
        first: FirstRows | None = None,
    ) -> None:
        """Create the file and write its heading.

        target: a path, or a file in memory, which stays open. tables: columns of the rows of each
        topic. chunk_rows: a chunk is written as soon as it has so many; fewer lose less when power
        fails, more make a smaller file. most_rows: of rows that come at once it takes so many, for
        a disk that is behind; None: no more than others. create: makes the file, and raises
        FileExistsError where there is one; by default with the rights that the umask leaves.
        flushing: told of each write, before and after it; a write that failed is taken back the
        same way. first: rows that the file is nothing without; it is made with them or not at all.
        Raises OSError where the file cannot be written, and leaves none then.
        """
        self._file: File | BytesIO = target if isinstance(target, BytesIO) else create(target)
        self._is_kept = isinstance(target, BytesIO)
        self._name = str(target)
        self.began_ns = heading.began_ns
        self._chunk_rows, self._most_rows = chunk_rows, most_rows or chunk_rows
        self._compressor = frame.compressor()
        self._offset = self._crc = 0
        self._flushing, self._sha256 = flushing, hashlib.sha256()
        self.extent = EMPTY
        """What the file holds so far; kept up only where `flushing` is given."""
        self._pending: list[Batch] = []
        self._pending_rows = 0
        self.written_rows = 0
        """Handed to the system so far; a row that was lost does not count."""
        self._waits_since_s: float | None = None
        self._chunks: list[ChunkIndex] = []
        self._numbers: dict[int, int] = {}
        self._written: dict[int, int] = {}
        """Messages of each channel."""
        self._layouts = {topic: row_schema.layout_of(columns) for topic, columns in tables.items()}
        self._topics = [*tables, EVENTS]
        self._schemas = _schemas_of(tables)
        self._channels = [
            Channel(id=i, topic=topic, message_encoding=ENCODING, metadata={}, schema_id=i)
            for i, topic in enumerate(self._topics, start=1)
        ]
        self._metadata: list[MetadataIndex] = []
        try:
            self._begin(heading)
            if first is not None:
                self.add_rows(*first)
                self.flush()
        except OSError:
            self._let_go()
            if isinstance(target, Path):
                with suppress(OSError):  # each try would leave an empty file
                    target.unlink()
            raise

    def _begin(self, heading: Heading) -> None:
        library = f"opensuction {heading.software_version}"
        self._write(MAGIC + frame.record_bytes(Header(profile=PROFILE, library=library)))
        for name, content in to_metadata(heading).items():
            data = frame.record_bytes(Metadata(name=name, metadata=content))
            self._metadata.append(MetadataIndex(self._offset, len(data), name))
            self._write(data)
        # In a chunk, which has a checksum.
        self._write_chunk(frame.record_bytes(*self._schemas, *self._channels), [])

    def _write(self, data: bytes) -> None:
        """Append to the file, or leave it as it was; raises OSError."""
        rest = memoryview(data)
        before, hashed = self.extent, self._hash(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self._file.seek(self._offset)
            self._file.truncate()
            self._tell(before, before)
            raise OSError(error.errno, error.strerror, self._name) from None
        self._sha256 = hashed
        self._offset += len(data)
        self._tell(self.extent, self.extent)
        self._crc = zlib.crc32(data, self._crc)

    def _hash(self, data: bytes) -> "hashlib._Hash":
        """The hash of the file with these bytes, which are announced."""
        if self._flushing is None:
            return self._sha256
        hashed = self._sha256.copy()
        hashed.update(data)
        self._tell(self.extent, Extent(self._offset + len(data), hashed.hexdigest()))
        return hashed

    def _tell(self, before: Extent, after: Extent) -> None:
        if self._flushing is not None:
            self._flushing(before, after)
            self.extent = after

    def _write_chunk(self, before: bytes, batches: list[Batch]) -> None:
        data, index = frame.chunk(before, batches, self._offset, self._compressor)
        self._write(data)
        self._chunks.append(index)
        for batch in batches:
            self._written[batch.channel] = self._written.get(batch.channel, 0) + len(batch.places)

    @property
    def room_rows(self) -> int:
        """Rows that the chunk which is being filled takes still."""
        return self._most_rows - self._pending_rows

    @property
    def written_chunks(self) -> int:
        """Handed to the system so far, the heading's among them."""
        return len(self._chunks)

    def add_rows(self, topic: str, times_ns: NDArray[np.uint64], table: Table) -> None:
        """Rows of a topic.

        times_ns: UTC of each, in nanoseconds since 1970. table: shape (rows, columns). Where a
        chunk is full they are written at once, else with the next ones or by `flush`. Raises
        OSError where they cannot be; the rows of that chunk are lost then.
        """
        layout = self._layouts[topic]
        if table.shape != (len(times_ns), len(layout.columns)):
            raise ValueError(f"{topic}: a table of {table.shape} for {len(times_ns)} rows")
        channel = 1 + self._topics.index(topic)
        done = 0
        while done < len(table):
            most = min(PACKED_ROWS, self.room_rows)
            some = slice(done, min(done + most, len(table)))
            rows = np.empty((some.stop - done, frame.MESSAGE_HEAD.itemsize + layout.size), np.uint8)
            row_schema.pack(layout, table[some], rows, frame.MESSAGE_HEAD.itemsize)
            numbers = self._number(channel, len(rows))
            frame.head(rows, channel, numbers, times_ns[some])
            places = np.arange(len(rows), dtype=np.uint64) * np.uint64(rows.shape[1])
            self._pending.append(Batch(channel, rows.tobytes(), times_ns[some], places))
            self._pending_rows += len(rows)
            done = some.stop
            if self._pending_rows == self._most_rows:
                self.flush()
        if self._pending_rows >= self._chunk_rows:
            self.flush()

    def add_event(self, time_ns: int, event: RecordedEvent) -> None:
        """An event; written with the next rows, or by `flush`. time_ns: as of a row."""
        channel = len(self._topics)
        data = row_schema.encode(event)
        message = np.empty((1, frame.MESSAGE_HEAD.itemsize + len(data)), np.uint8)
        message[0, frame.MESSAGE_HEAD.itemsize :] = np.frombuffer(data, np.uint8)
        times_ns = np.array([time_ns], np.uint64)
        frame.head(message, channel, self._number(channel, 1), times_ns)
        self._pending.append(Batch(channel, message.tobytes(), times_ns, np.zeros(1, np.uint64)))

    def _number(self, channel: int, messages: int) -> NDArray[np.uint64]:
        """Numbers of a channel's next messages."""
        first = self._numbers.get(channel, 0)
        self._numbers[channel] = first + messages
        return np.arange(first, first + messages, dtype=np.uint64)

    def keep_up(self, now_s: float) -> None:
        """Flush what has waited for `WAITED_S`; to be called every 50 ms or more often.

        now_s: of a clock that only goes on. Raises OSError as `flush`.
        """
        if not self._pending:
            self._waits_since_s = None
        elif self._waits_since_s is None:
            self._waits_since_s = now_s
        elif now_s - self._waits_since_s >= WAITED_S:
            self.flush()

    def flush(self) -> None:
        """Hand all that was added to the system: from then on only a loss of power loses it.

        Raises OSError where it cannot be written; it is lost then, and the file goes on after it.
        """
        batches, self._pending = self._pending, []
        rows, self._pending_rows = self._pending_rows, 0
        self._waits_since_s = None
        if batches:
            self._write_chunk(b"", batches)
        self.written_rows += rows

    def close(self) -> None:
        """Write what is left, and what lets a reader find its way; nothing after an error."""
        if self._file.closed:
            return
        try:
            self.flush()
            self._finish()
        finally:
            self._let_go()

    def _let_go(self) -> None:
        if not self._is_kept:
            self._file.close()

    def _finish(self) -> None:
        self._write(frame.record_bytes(DataEnd(self._crc)))
        begin = self._offset
        groups: dict[int, Sequence[McapRecord]] = {
            Opcode.SCHEMA: self._schemas,
            Opcode.CHANNEL: self._channels,
            Opcode.STATISTICS: [self._statistics()],
            Opcode.CHUNK_INDEX: self._chunks,
            Opcode.METADATA_INDEX: self._metadata,
        }
        summary, offsets = b"", b""
        for opcode, records in groups.items():
            data = frame.record_bytes(*records)
            place = SummaryOffset(opcode, begin + len(summary), len(data))
            offsets += frame.record_bytes(place)
            summary += data
        footer = Footer(begin, begin + len(summary), 0)
        covered = summary + offsets + frame.record_bytes(footer)[:-4]
        footer.summary_crc = zlib.crc32(covered)
        self._write(summary + offsets + frame.record_bytes(footer) + MAGIC)

    def _statistics(self) -> Statistics:
        held = [one for one in self._chunks if one.message_index_offsets]
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(self._written),
            chunk_count=len(self._chunks),
            message_count=sum(self._written.values()),
            message_end_time=max((one.message_end_time for one in held), default=0),
            message_start_time=min((one.message_start_time for one in held), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def __enter__(self) -> "RecordingWriter":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self.close()
        else:
            self._let_go()
