"""MCAP records of many messages at once: chunks of rows, and what indexes them.

The library writes message by message, some microseconds each. A row's message has one length, so a
chunk of them is one table of bytes. Everything else is left to the library's records.

Extent of a file: a length, and the SHA-256 of the bytes up to it.

Heading of a recording, ahead of its rows: its origin, and the data that a replay needs.
"""

import errno
import hashlib
import json
import os
import struct
import zlib
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from stat import S_ISREG
from typing import Any, NamedTuple

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk, ChunkIndex
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError

PROFILE = "opensuction"
"""In the header of the file: by it a recording is told from other MCAP files."""
FORMAT = 1
"""Of what this version writes; a change that older versions would misread takes the next number."""
ABOUT, SETTINGS = "opensuction", "settings"
"""Names of the two metadata records."""
NOTICE = (
    "In-silico: recorded on a digital twin. Research software, not a medical device, not for use "
    "on people or animals."
)
_FIXED = ("format", "software_version", "settings_hash", "fingerprint", "began_utc", "checksum")


class Heading(NamedTuple):
    """The description of a recording."""

    software_version: str
    settings: str
    """Of the controller, as JSON."""
    settings_hash: str
    fingerprint: str
    """Of the arithmetic that the controller ran with; see `kernel.arithmetic_fingerprint`."""
    began_ns: int
    """UTC at tick 0, in nanoseconds since 1970."""
    about: dict[str, str]
    """Whatever else is known, by name: patient, protocol, seed, notice."""

    @property
    def began_utc(self) -> str:
        """The beginning as people read it."""
        return datetime.fromtimestamp(self.began_ns / 1e9, tz=UTC).isoformat()


Metadata = dict[str, dict[str, str]]
"""Metadata records of an MCAP file, by name."""


def _checksum(about: dict[str, str], settings: str) -> str:
    """Of everything else, for MCAP gives metadata none."""
    rest = {name: value for name, value in about.items() if name != "checksum"}
    content = json.dumps([rest, settings], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()


def to_metadata(heading: Heading) -> Metadata:
    """The metadata records of a heading. Raises ValueError for a name that it has itself."""
    if taken := set(_FIXED) & set(heading.about):
        raise ValueError(f"a recording's heading has {', '.join(sorted(taken))} of its own")
    about = {
        "format": str(FORMAT),
        "software_version": heading.software_version,
        "settings_hash": heading.settings_hash,
        "fingerprint": heading.fingerprint,
        "began_utc": f"{heading.began_utc} ({heading.began_ns} ns)",
        # The name of a file may hold bytes that are no UTF-8.
        **{
            name: value.encode("utf-8", "backslashreplace").decode()
            for name, value in heading.about.items()
        },
    }
    about["checksum"] = _checksum(about, heading.settings)
    return {ABOUT: about, SETTINGS: {"json": heading.settings}}


def from_metadata(name: str, metadata: Metadata) -> Heading:
    """The heading of these records.

    name: of the file, for messages. Raises InputError for records of a newer version, and for
    damaged ones.
    """
    about = metadata.get(ABOUT, {})
    written = about.get("format", "")
    if written.isdecimal() and int(written) > FORMAT:
        raise InputError(
            f"{name}: is a recording of format {written}, written by opensuction "
            f"{about.get('software_version', '(unknown)')!r}; this version reads up to {FORMAT}: "
            "take a newer one"
        )
    settings = metadata.get(SETTINGS, {}).get("json", "")
    if about.get("checksum") != _checksum(about, settings):
        raise InputError(f"{name}: its heading is damaged, nothing of it can be relied upon")
    began = about["began_utc"].rpartition("(")[2].partition(" ")[0]
    return Heading(
        software_version=about["software_version"],
        settings=settings,
        settings_hash=about["settings_hash"],
        fingerprint=about["fingerprint"],
        began_ns=int(began),
        about={key: value for key, value in about.items() if key not in _FIXED},
    )


READ_BYTES = 1_000_000


class Extent(NamedTuple):
    """The first bytes of a file, or all of them."""

    size_bytes: int
    sha256: str


EMPTY = Extent(0, sha256().hexdigest())


def measure(path: Path, *until: int) -> list[Extent]:
    """A file as it is: its first bytes until each of these places, and all of it last.

    until: in bytes, ascending; of a place beyond the end all that there is. Raises OSError for a
    file that cannot be read; no link is followed, and nothing but a plain file is read.
    """
    flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK
    with os.fdopen(os.open(path, flags), "rb") as file:
        if not S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(errno.EINVAL, "no plain file", str(path))
        digest, size, found = sha256(), 0, []
        for place in (*until, None):
            while place is None or size < place:
                wanted = READ_BYTES if place is None else min(READ_BYTES, place - size)
                data = file.read(wanted)
                if not data:
                    break
                digest.update(data)
                size += len(data)
            found.append(Extent(size, digest.hexdigest()))
    return found


Bytes = NDArray[np.uint8]
Times = NDArray[np.uint64]

MESSAGE_HEAD = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
"""What stands before the data of a message."""
RECORD_HEAD = struct.Struct("<BQ")
"""What stands before every record: opcode and length of what follows."""
OF_MESSAGE = MESSAGE_HEAD.itemsize - RECORD_HEAD.size
"""Bytes of the head that the record's length counts."""
COMPRESSION = "zstd"
LEVEL = 3
"""[computed] A cycle's rows take .157 s and 23.2 MB by level 3, .153 s and 23.7 MB by level 1."""


class Batch(NamedTuple):
    """Messages of one channel in a chunk, one after the other."""

    channel: int
    data: bytes
    """As they stand in the chunk, heads included."""
    times_ns: Times
    places: NDArray[np.uint64]
    """Of each in ``data``."""


def head(rows: Bytes, channel: int, sequence: NDArray[Any], times_ns: Times) -> None:
    """Write the heads of messages, one a row of ``rows``."""
    heads: NDArray[Any] = np.ndarray(
        len(rows), MESSAGE_HEAD, buffer=rows, strides=(rows.strides[0],)
    )
    heads["opcode"] = Opcode.MESSAGE
    heads["length"] = rows.shape[1] - RECORD_HEAD.size
    heads["channel"] = channel
    heads["sequence"] = sequence
    heads["log_time"] = heads["publish_time"] = times_ns


def record_bytes(*records: Any) -> bytes:
    """Records of the library as they stand in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def _indexes(batches: list[Batch], begin: int) -> dict[int, bytes]:
    """The message index of each channel; begin: where the first batch begins in the chunk."""
    entries: dict[int, list[NDArray[np.uint64]]] = {}
    for batch in batches:
        both = np.stack((batch.times_ns, batch.places + np.uint64(begin)), axis=1)
        entries.setdefault(batch.channel, []).append(both)
        begin += len(batch.data)
    found = {}
    for channel, parts in entries.items():
        packed = np.concatenate(parts).astype("<u8").tobytes()
        body = struct.pack("<HI", channel, len(packed)) + packed
        found[channel] = RECORD_HEAD.pack(Opcode.MESSAGE_INDEX, len(body)) + body
    return found


def span_ns(batches: list[Batch]) -> tuple[int, int]:
    """Times of the first and the last message; zeros where there are none."""
    if not batches:
        return 0, 0
    times = np.concatenate([batch.times_ns for batch in batches])
    return int(times.min()), int(times.max())


def compressor() -> zstandard.ZstdCompressor:
    """Compressor of a file's chunks, for one thread."""
    return zstandard.ZstdCompressor(level=LEVEL)


def chunk(
    before: bytes, batches: list[Batch], offset: int, compressor: zstandard.ZstdCompressor
) -> tuple[bytes, ChunkIndex]:
    """A chunk and its message indexes as they stand in a file, and the index of the chunk.

    before: records that come first in it. offset: of the chunk in the file.
    """
    content = b"".join([before, *(batch.data for batch in batches)])
    first, last = span_ns(batches)
    packed = compressor.compress(content)
    written = record_bytes(
        Chunk(
            compression=COMPRESSION,
            data=packed,
            message_start_time=first,
            message_end_time=last,
            uncompressed_crc=zlib.crc32(content),
            uncompressed_size=len(content),
        )
    )
    indexes, places = b"", {}
    for channel, index in _indexes(batches, len(before)).items():
        places[channel] = offset + len(written) + len(indexes)
        indexes += index
    found = ChunkIndex(
        chunk_length=len(written),
        chunk_start_offset=offset,
        compression=COMPRESSION,
        compressed_size=len(packed),
        message_end_time=last,
        message_index_length=len(indexes),
        message_index_offsets=places,
        message_start_time=first,
        uncompressed_size=len(content),
    )
    return written + indexes, found
