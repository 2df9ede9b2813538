"""Reads a recording, whole, damaged or cut off at any byte: every chunk that is whole and sound.

Whatever the file is, it ends in rows, or in one line that says what is wrong and how much was read.

Content of a chunk: rows and events, decoded by the descriptions that precede them.
"""

import struct
import zlib
from collections.abc import Iterator
from io import BufferedReader, BytesIO
from pathlib import Path
from stat import S_ISREG
from typing import Any, NamedTuple, NoReturn

import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, Footer, Header, Metadata, Schema
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import frame, row_schema
from opensuction.recording.cycle_file.row_schema import (
    PACKAGE,
    Layout,
    RecordedEvent,
    SchemaColumn,
    Table,
)
from opensuction.recording.cycle_file.writer import EVENTS, MAGIC

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
            return row_schema.layout_of(row_schema.columns_of(name, schema.data))
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
        return row_schema.unpack(layout, rows, frame.MESSAGE_HEAD.itemsize)
    except ValueError as error:
        raise DamageError(str(error)) from None


def _event(data: bytes) -> RecordedEvent:
    try:
        return row_schema.decode(data)
    except Exception:  # protobuf's own errors are of no common kind
        raise DamageError("no event") from None


VERSION_AT = 5
"""Where MCAP's magic has its version."""
FOOTER_BYTES = 20
WANTED = "give a recording that opensuction wrote (.mcap)"


class NothingRecordedError(InputError):
    """A sound recording that holds no row: its writer stopped before it wrote one."""


class _Record(NamedTuple):
    opcode: int
    offset: int
    data: bytes


class RecordingReader:
    """An open recording, read from its beginning to its end once."""

    def __init__(self, path: Path) -> None:
        """Open the file and read its heading.

        Raises InputError for what is no recording, is of a newer version, or has no heading:
        NothingRecordedError where its writer stopped before it had written that.
        """
        self.path = path
        self._file, self._size = _open(path)
        self._crc = self._offset = 0
        self._rows, self._span_ns = 0, (0, 0)
        self._chunks = ChunkReader()
        self._records = self._walk()
        self.flaw: str | None = None
        """What is wrong with the file, in one line, once its end has been reached."""
        self.is_damaged = False
        """Whether that is more than an end that is missing."""
        try:
            self._check_magic()
            self.heading = self._read_heading()
            self._chunks.read(self._next(Opcode.CHUNK))
        except DamageError as damage:
            self.close()
            said = f"{path}: {self._say(damage)}; nothing of it can be read"
            raise (InputError if self.is_damaged else NothingRecordedError)(said) from None
        except InputError:
            self.close()
            raise
        self.tables: dict[str, tuple[SchemaColumn, ...]] = self._chunks.tables

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _check_magic(self) -> None:
        found = self._file.read(len(MAGIC))
        if not found:
            raise NothingRecordedError(f"{self.path}: is empty; {WANTED}")
        if found != MAGIC:
            if found[:VERSION_AT] == MAGIC[:VERSION_AT] and len(found) == len(MAGIC):
                raise InputError(
                    f"{self.path}: is an MCAP file of version {found[VERSION_AT:][:1]!r}, not 0; "
                    f"{WANTED}"
                )
            raise InputError(f"{self.path}: is no MCAP file; {WANTED}")
        self._offset, self._crc = len(MAGIC), zlib.crc32(found)

    def _walk(self) -> Iterator[_Record]:
        """Records from here on; ends where the file does. Raises DamageError."""
        while self._offset < self._size:
            head = self._file.read(frame.RECORD_HEAD.size)
            if len(head) < frame.RECORD_HEAD.size:
                break
            opcode, length = frame.RECORD_HEAD.unpack(head)
            if self._offset + len(head) + length > self._size:
                break
            if length > LARGEST_BYTES:
                raise DamageError("a record of an impossible length")
            data = self._file.read(length)
            if opcode == Opcode.DATA_END:
                self._check_end(data)
                return
            yield _Record(opcode, self._offset, data)
            self._offset += len(head) + length
            self._crc = zlib.crc32(data, zlib.crc32(head, self._crc))
        self._file.seek(max(self._size - len(MAGIC), len(MAGIC)))
        if self._file.read() == MAGIC:  # it was closed: nothing is missing
            raise DamageError("a record that goes beyond the end")
        raise _CutError

    def _check_end(self, data: bytes) -> None:
        """Check the checksums behind the rows: of all that was read, and of the index."""
        if parse(DataEnd, data).data_section_crc not in (0, self._crc):
            raise DamageError("something before it, for the checksum of the whole is another")
        rest = self._file.read(LARGEST_BYTES)
        at = len(rest) - len(MAGIC) - FOOTER_BYTES
        if at < 0 or not rest.endswith(MAGIC):
            raise _CutError
        footer = parse(Footer, rest[at:])
        if footer.summary_crc not in (0, zlib.crc32(rest[: -len(MAGIC) - 4])):
            raise DamageError("the index behind the rows has another checksum")

    def _say(self, damage: DamageError) -> str:
        """Describe the damage of the file."""
        if isinstance(damage, _CutError):
            return f"was not finished: it ends at byte {self._size}, where its writer stopped"
        self.is_damaged = True
        return f"is damaged at byte {self._offset}: {damage}"

    def _next(self, opcode: int) -> bytes:
        """The next record, which must be of a kind."""
        record = next(self._records, None)
        if record is None or record.opcode != opcode:
            raise DamageError("another record than should be there")
        return record.data

    def _read_heading(self) -> frame.Heading:
        first = parse(Header, self._next(Opcode.HEADER))
        if first.profile != frame.PROFILE:
            raise InputError(
                f"{self.path}: is an MCAP file by {first.library!r}, no recording of "
                f"opensuction; {WANTED}"
            )
        found = {}
        for _ in (frame.ABOUT, frame.SETTINGS):
            metadata = parse(Metadata, self._next(Opcode.METADATA))
            found[metadata.name] = metadata.metadata
        return frame.from_metadata(str(self.path), found)

    def contents(self) -> Iterator[Rows | TimedEvent]:
        """Rows and events in their order; `flaw` then says whether that was all.

        A chunk that is damaged is left out: what lies behind it is none the worse.
        """
        said = ""
        try:
            for record in self._records:
                if record.opcode == Opcode.CHUNK:
                    try:
                        found = self._chunks.read(record.data)
                    except DamageError as damage:
                        said = said or self._say(damage)
                        continue
                    for one in found:
                        self._note(one)
                        yield one
        except DamageError as damage:
            said = said or self._say(damage)
        finally:
            self.close()
        if said:
            self.flaw = f"{self.path}: {said}; {self._describe_read()}"

    def refuse_empty(self, said: str) -> NoReturn:
        """Raise InputError for a file read to its end of which no row is of use.

        said: what it lacks, where nothing is wrong with the file; NothingRecordedError where its
        writer stopped before it had written any.
        """
        if self.flaw is None:
            raise InputError(f"{self.path}: {said}")
        raise (InputError if self.is_damaged else NothingRecordedError)(self.flaw)

    def _note(self, one: Rows | TimedEvent) -> None:
        if isinstance(one, Rows) and one.topic == next(iter(self.tables)):
            first = self._span_ns[0] or int(one.times_ns[0])
            self._span_ns = first, int(one.times_ns[-1])
            self._rows += len(one.table)

    def _describe_read(self) -> str:
        """Rows that were read, and their span of time: rows may be missing in between."""
        seconds = (self._span_ns[1] - self._span_ns[0]) / 1e9
        rows = f"{self._rows} row{'' if self._rows == 1 else 's'}"
        span = f" of {seconds:.3f} s" if self.is_damaged else f", {seconds:.3f} s,"
        return f"{rows}{span} could be read"


class _CutError(DamageError):
    """The file ends before its end."""


def _open(path: Path) -> tuple[BufferedReader, int]:
    """The file and its size in bytes. Raises InputError."""
    try:
        status = path.stat()
        if path.is_dir():
            raise InputError(f"{path}: is a folder; {WANTED}")
        if not S_ISREG(status.st_mode):
            raise InputError(f"{path}: is a device or a pipe; {WANTED}")
        return path.open("rb"), status.st_size
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; {WANTED}") from None
    except PermissionError:
        raise InputError(f"{path}: may not be read; change its permissions") from None
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{path}: cannot be read: {reason}") from None
