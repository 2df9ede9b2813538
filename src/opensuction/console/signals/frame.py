"""A block of rows as bytes: a header, when each row was, and a column of numbers a channel.

All little-endian::

    offset  type     what
    0       uint16   0x5347, "GS"
    2       uint16   version of this layout
    4       uint16   bytes of the header
    6       uint16   channels
    8       uint32   rows
    12      uint32   rows before these that this client has not got
    16      uint32   number of the control process since the console began
    20      uint32   0
    24      float64  number of the first tick
    32      float64  time of the first tick, s: monotonic clock
    40      float64  period of a tick, s
    48      uint32   each row: periods since the first; ticks that were missed count
    ...     float32  each row of the first channel, of the second, ...; not a number: no valid value
"""

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.console.signals.channel import Channel
from opensuction.kernel.record import Array
from opensuction.runtime.loop import ROW_COLUMNS

MAGIC, VERSION = 0x5347, 1
HEADER = struct.Struct("<HHHHIIIIddd")
MISSED = struct.Struct("<I")
MISSED_AT = 12
_TIME, _TICK = (ROW_COLUMNS.index(name) for name in ("loop.time_s", "inputs.tick"))


class Block(NamedTuple):
    """Rows of one control process that follow one another."""

    source: int
    rows: Array
    missed: int
    """Rows before these that were overwritten before they were read."""
    period_s: float
    gain: float
    """Tip travel for each mm of head travel."""
    offset_mm: float


class Frame(NamedTuple):
    """Content of a frame, as a client reads it."""

    source: int
    missed: int
    first_tick: float
    period_s: float
    times_s: npt.NDArray[np.float64]
    values: npt.NDArray[np.float32]
    """Shape (channels, rows)."""


class Picker:
    """Takes the values of some channels out of rows: made once for a set of channels."""

    def __init__(self, channels: Sequence[Channel]) -> None:
        self._count = len(channels)
        self._first = np.array([one.columns[0] for one in channels], np.intp)
        self._second = [
            (i, one.columns[1]) for i, one in enumerate(channels) if len(one.columns) > 1
        ]
        self._valid = [(i, flag) for i, one in enumerate(channels) for flag in one.valid]
        self._tips = [i for i, one in enumerate(channels) if one.is_tip]

    def pick(self, block: Block) -> npt.NDArray[np.float64]:
        """Values of shape (channels, rows)."""
        rows = block.rows
        values = rows.take(self._first, axis=1).T
        for at, column in self._second:
            values[at] += rows[:, column]
            values[at] *= 0.5
        for at, flag in self._valid:
            values[at][rows[:, flag] == 0.0] = np.nan
        for at in self._tips:
            values[at] *= block.gain
            values[at] += block.offset_mm
        return values

    def encode(self, block: Block) -> bytes:
        """The block as a message."""
        rows, count = block.rows, len(block.rows)
        times_s = rows[:, _TIME]
        first_s = float(times_s[0])
        header = HEADER.pack(
            MAGIC,
            VERSION,
            HEADER.size,
            self._count,
            count,
            min(block.missed, 0xFFFFFFFF),
            block.source,
            0,
            float(rows[0, _TICK]),
            first_s,
            block.period_s,
        )
        steps = np.rint((times_s - first_s) * (1.0 / block.period_s)).astype("<u4")
        # A number too large for single precision becomes infinite, and that is what is shown.
        with np.errstate(over="ignore"):
            values = self.pick(block).astype("<f4", order="C")
        return b"".join((header, steps.tobytes(), values.tobytes()))


def with_missed(message: bytes, missed: int) -> bytes:
    """The same message to a client that lacks more rows before it."""
    (before,) = MISSED.unpack_from(message, MISSED_AT)
    told = MISSED.pack(min(before + missed, 0xFFFFFFFF))
    return message[:MISSED_AT] + told + message[MISSED_AT + MISSED.size :]


def decode(message: bytes) -> Frame:
    """Read a message, as a client does. Raises ValueError for what is none."""
    if len(message) < HEADER.size:
        raise ValueError(f"{len(message)} bytes are no frame")
    magic, version, size, channels, rows, missed, source, _, tick, first_s, period_s = (
        HEADER.unpack_from(message)
    )
    if (magic, version) != (MAGIC, VERSION):
        raise ValueError(f"no frame of version {VERSION}")
    if len(message) != size + 4 * rows * (1 + channels):
        raise ValueError(f"{len(message)} bytes do not hold {rows} rows of {channels} channels")
    steps = np.frombuffer(message, "<u4", rows, size)
    values = np.frombuffer(message, "<f4", rows * channels, size + 4 * rows)
    times_s = first_s + steps * period_s
    return Frame(source, missed, tick, period_s, times_s, values.reshape(channels, rows))
