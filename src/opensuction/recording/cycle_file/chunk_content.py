"""Content of a chunk: rows and events, decoded by the descriptions that precede them."""

import struct
import zlib
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from numpy.typing import NDArray

from opensuction.recording.cycle_file import event as events
from opensuction.recording.cycle_file import frame, row_layout, row_schema
from opensuction.recording.cycle_file.event import RecordedEvent
from opensuction.recording.cycle_file.row_layout import Layout, Table
from opensuction.recording.cycle_file.row_schema import PACKAGE, SchemaColumn
from opensuction.recording.cycle_file.writer import EVENTS

LARGEST_BYTES = 256_000_000
"""Of a record, and of what a chunk holds: a hundred times what is written here."""


class DamageError(ValueError):
    """Damage of a file: its content cannot be what was written."""


class Rows(NamedTuple):
    """Rows of a topic that follow each other in a chunk."""

    topic: str
    times_ns: NDArray[np.uint64]
    """UTC, nanoseconds since 1970."""
    table: Table
    """Shape (rows, columns)."""


class TimedEvent(NamedTuple):
    """An event and its time."""

    time_ns: int
    event: RecordedEvent


def parse(kind: Any, data: bytes) -> Any:
    """A record of the library. Raises DamageError."""
    try:
        return kind.read(ReadDataStream(BytesIO(data)))
    except Exception:  # whatever the bytes are, the library raises as it happens to
        raise DamageError(f"no {kind.__name__.lower()}") from None


def unpack(record: bytes) -> bytes:
    """Content of a chunk, its checksum verified. Raises DamageError."""
    chunk = parse(Chunk, record)
    if chunk.compression != frame.COMPRESSION:
        raise DamageError(f"a chunk packed as {chunk.compression!r}")
    try:
        size = zstandard.get_frame_parameters(chunk.data).content_size
        if size != chunk.uncompressed_size or size > LARGEST_BYTES:
            raise DamageError("a chunk of another size than it says")
        content = zstandard.ZstdDecompressor().decompress(chunk.data)
    except zstandard.ZstdError:
        raise DamageError("a chunk that cannot be unpacked") from None
    if zlib.crc32(content) != chunk.uncompressed_crc:
        raise DamageError("a chunk with another checksum")
    return content


class ChunkReader:
    """Reads chunks in their order; what one describes the next ones use."""

    def __init__(self) -> None:
        self._schemas: dict[int, Schema] = {}
        self._layouts: dict[int, tuple[str, Layout]] = {}
        """By channel: topic and layout."""
        self._event_channel = 0

    @property
    def tables(self) -> dict[str, tuple[SchemaColumn, ...]]:
        """Columns of the topics that have been described."""
        return {topic: layout.columns for topic, layout in self._layouts.values()}

    def read(self, record: bytes) -> list[Rows | TimedEvent]:
        """Content of a chunk, in its order. Raises DamageError."""
        content = unpack(record)
        found: list[Rows | TimedEvent] = []
        at = 0
        while at < len(content):
            try:
                opcode, length = frame.RECORD_HEAD.unpack_from(content, at)
            except struct.error:
                raise DamageError("a chunk that ends within a record") from None
            if opcode == Opcode.MESSAGE:
                at = self._read_messages(content, at, length, found)
                continue
            at += frame.RECORD_HEAD.size
            self._describe(opcode, content[at : at + length])
            at += length
        return found

    def _describe(self, opcode: int, record: bytes) -> None:
        if opcode == Opcode.SCHEMA:
            schema = parse(Schema, record)
            self._schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = parse(Channel, record)
            if channel.topic == EVENTS:
                self._event_channel = channel.id
            else:
                self._layouts[channel.id] = channel.topic, self._layout(channel)

    def _layout(self, channel: Channel) -> Layout:
        try:
            schema = self._schemas[channel.schema_id]
            name = schema.name.removeprefix(f"{PACKAGE}.")
            return row_layout.layout_of(row_schema.columns_of(name, schema.data))
        except Exception:  # protobuf's own errors are of no common kind
            raise DamageError(f"no description of the rows of {channel.topic}") from None

    def _read_messages(
        self, content: bytes, at: int, length: int, found: list[Rows | TimedEvent]
    ) -> int:
        """Messages of one channel from a place on; returns the place after them."""
        step = frame.RECORD_HEAD.size + length
        most = (len(content) - at) // step
        if length < frame.OF_MESSAGE or most == 0:
            raise DamageError("a message longer than its chunk")
        heads: NDArray[Any] = np.ndarray(
            most, frame.MESSAGE_HEAD, buffer=content, offset=at, strides=(step,)
        )
        channel = int(heads["channel"][0])
        if channel not in self._layouts:  # an event, or a topic that this version does not know
            if channel == self._event_channel:
                data = content[at + frame.MESSAGE_HEAD.itemsize : at + step]
                found.append(TimedEvent(int(heads["log_time"][0]), _event(data)))
            return at + step
        alike = (heads["opcode"] == Opcode.MESSAGE) & (heads["length"] == length)
        alike &= heads["channel"] == channel
        count = most if alike.all() else int(np.argmin(alike))
        topic, layout = self._layouts[channel]
        if length - frame.OF_MESSAGE != layout.size:
            raise DamageError("a row of another length than its description says")
        rows = np.frombuffer(content, np.uint8, count * step, at).reshape(count, step)
        table = _table(layout, rows)
        found.append(Rows(topic, heads["log_time"][:count].copy(), table))
        return at + count * step


def _table(layout: Layout, rows: NDArray[np.uint8]) -> Table:
    try:
        return row_layout.unpack(layout, rows, frame.MESSAGE_HEAD.itemsize)
    except ValueError as error:
        raise DamageError(str(error)) from None


def _event(data: bytes) -> RecordedEvent:
    try:
        return events.decode(data)
    except Exception:  # protobuf's own errors are of no common kind
        raise DamageError("no event") from None
