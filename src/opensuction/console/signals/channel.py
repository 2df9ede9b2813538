"""Channels of signals: every column of the control loop's rows, and the tip derived from them.

Commonly used channels have a title; the others are named by their columns, since an engineer who
looks for one of them knows it from the code.

A block of rows as bytes: a header, when each row was, and a column of numbers a channel.

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
from enum import StrEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.record import Array
from opensuction.runtime.loop import ROW_COLUMNS

UNITS = {
    "mm_per_s": "mm/s",
    "mmhg_per_s": "mmHg/s",
    "per_min": "1/min",
    "mm": "mm",
    "rad": "rad",
    "mmhg": "mmHg",
    "cmh2o": "cmH2O",
    "percent": "%",
    "v": "V",
    "a": "A",
    "n": "N",
    "s": "s",
    "ticks": "ticks",
}
"""Units by the end of a column's name; longer ends first."""
COARSE = ("tick", "trips", "present", "latched", "acknowledged", "escalated", "conditions")
"""Ends of names of whole numbers that may be larger than single precision holds: the last digits of
those are lost on the way."""
TIP = "tip"
"""Group of columns that the rows do not have."""


class Origin(StrEnum):
    """Origin of a channel's value."""

    MEASURED = "measured"
    COMMANDED = "commanded"
    ESTIMATED = "estimated"
    DECIDED = "decided"
    """By the controller: phases, flags, what it remembers."""


class Group(StrEnum):
    """Subject of a channel, in the order of the chooser."""

    INSERTION = "Insertion"
    SUCTION = "Suction"
    PATIENT = "Patient"
    PROCEDURE = "Procedure and alarms"
    TIMING = "Timing"
    REQUESTS = "Requests of people"
    COMMANDS = "Other outputs"
    INSIDE = "Inside the controller"


class Channel(NamedTuple):
    """One of them."""

    name: str
    title: str
    unit: str
    """Empty where it is a number or a flag."""
    group: Group
    origin: Origin
    is_exact: bool
    """Whether single precision tells its values apart."""
    columns: tuple[int, ...]
    """Of the row; several are averaged."""
    valid: tuple[int, ...]
    """Flags of the row: where one is down there is no value."""
    is_tip: bool = False
    """Columns are head travel: the tip is worked out of them by the machine's transmission."""


_IN, _OUT, _WATCH = "inputs.readings.", "outputs.", "state.core.governor.watch."
_MEASURED, _COMMANDED = Origin.MEASURED, Origin.COMMANDED
_ESTIMATED, _DECIDED = Origin.ESTIMATED, Origin.DECIDED

TITLES: dict[Group, tuple[tuple[str, str, Origin], ...]] = {
    Group.INSERTION: (
        (f"{_IN}head_mm", "Head, motor's encoder", _MEASURED),
        (f"{_IN}carriage_mm", "Head, sensor at the catheter", _MEASURED),
        (f"{_OUT}commands.head_mm", "Head", _COMMANDED),
        (f"{_OUT}demand.reference_mm", "Tip, where it shall be", _COMMANDED),
        (f"{_OUT}verdict.deepest_mm", "Tip, deepest possible by the governor", _ESTIMATED),
        (f"{_OUT}demand.reference_mm_per_s", "Tip speed", _COMMANDED),
        (f"{_WATCH}speed_mm_per_s", "Head speed", _ESTIMATED),
        (f"{_OUT}commands.insertion_v", "Insertion motor, voltage", _COMMANDED),
        (f"{_IN}insertion_current_a", "Insertion motor, current", _MEASURED),
        (f"{_WATCH}drive.force_n", "Force at the catheter", _ESTIMATED),
        (f"{_IN}mouth_clear", "Tube's mouth clear (light barrier)", _MEASURED),
        (f"{_IN}contact_closed", "Contact at the tip", _MEASURED),
        (f"{_OUT}commands.insertion_on", "Insertion motor on", _COMMANDED),
    ),
    Group.SUCTION: (
        (f"{_IN}line_vacuum_mmhg", "Vacuum in the line", _MEASURED),
        (f"{_OUT}commands.vacuum_mmhg", "Vacuum setpoint", _COMMANDED),
        (f"{_WATCH}filter.smooth_mmhg", "Vacuum in the line, smoothed", _ESTIMATED),
        (f"{_IN}cam_rad", "Valve cam", _MEASURED),
        (f"{_OUT}commands.cam_rad", "Valve cam", _COMMANDED),
        (f"{_OUT}commands.valve_v", "Valve motor, voltage", _COMMANDED),
        (f"{_OUT}demand.valve_open", "Valve shall be open", _COMMANDED),
        (f"{_OUT}commands.pump_on", "Pump on", _COMMANDED),
    ),
    Group.PATIENT: (
        (f"{_IN}monitor.spo2_percent", "Oxygen saturation", _MEASURED),
        (f"{_IN}monitor.heart_rate_per_min", "Heart rate", _MEASURED),
        (f"{_IN}monitor.airway_pressure_cmh2o", "Airway pressure", _MEASURED),
        (f"{_IN}monitor.connected", "Patient monitor connected", _MEASURED),
    ),
    Group.PROCEDURE: (
        (f"{_OUT}phase", "Phase (number)", _DECIDED),
        (f"{_OUT}signals.priority", "Alarm priority", _DECIDED),
        (f"{_OUT}signals.audible", "Alarm sounds", _DECIDED),
        (f"{_OUT}verdict.reaction", "Governor's reaction", _DECIDED),
        (f"{_OUT}counters.passes", "Passes", _DECIDED),
        (f"{_OUT}counters.rest_left_s", "Rest left until the next start", _DECIDED),
    ),
    Group.TIMING: (
        ("loop.late_s", "Tick begins after its deadline", _MEASURED),
        ("loop.computed_s", "Tick before took", _MEASURED),
        ("loop.skipped", "Missed ticks", _MEASURED),
        (f"{_OUT}counters.late_share", "Share of late ticks", _ESTIMATED),
        (f"{_WATCH}bus.stale_ticks", "Age of the readings", _DECIDED),
        ("loop.time_s", "Deadline of the tick, monotonic clock", _MEASURED),
        ("inputs.tick", "Number of the tick", _DECIDED),
    ),
}
"""Those with a title, in the order of the chooser."""

_MONITOR = (f"{_IN}monitor.connected",)
VALID = {
    f"{_IN}head_mm": (f"{_IN}head_valid",),
    f"{_IN}carriage_mm": (f"{_IN}carriage_valid",),
    f"{_IN}cam_rad": (f"{_IN}cam_valid",),
    f"{_IN}line_vacuum_mmhg": (f"{_IN}vacuum_valid",),
    f"{_IN}contact_closed": (f"{_IN}contact_valid",),
    f"{_IN}monitor.spo2_percent": (*_MONITOR, f"{_IN}monitor.spo2_valid"),
    f"{_IN}monitor.heart_rate_per_min": (*_MONITOR, f"{_IN}monitor.heart_rate_valid"),
    f"{_IN}monitor.airway_pressure_cmh2o": (*_MONITOR, f"{_IN}monitor.airway_pressure_valid"),
}
"""A reading whose flag is down is no value, whatever its column holds."""

_FOREMOST, _REARMOST = (
    ROW_COLUMNS.index(f"{_WATCH}tip.{end}_mm") for end in ("foremost", "rearmost")
)
_TIPS = (
    ("tip.middle_mm", "Tip, middle of what is possible", (_FOREMOST, _REARMOST)),
    ("tip.high_mm", "Tip, deepest possible", (_FOREMOST,)),
    ("tip.low_mm", "Tip, shallowest possible", (_REARMOST,)),
)
"""No sensor tells where the tip is: what is possible by the measured head and the gap's bounds."""


def unit_of(name: str) -> str:
    """Unit by the end of a column's name; empty where it has none."""
    last = name.rsplit(".", 1)[-1]
    if last.isdigit():
        last = name.split(".")[-2]
    return next(
        (unit for end, unit in UNITS.items() if last == end or last.endswith(f"_{end}")), ""
    )


def _group_of(name: str) -> tuple[Group, Origin]:
    """Of a column without a title."""
    if name.startswith("inputs.requests."):
        return Group.REQUESTS, Origin.MEASURED
    if name.startswith(("inputs.", "loop.")):
        return Group.TIMING, Origin.MEASURED
    if name.startswith(f"{_OUT}commands."):
        return Group.COMMANDS, Origin.COMMANDED
    return (Group.COMMANDS if name.startswith(_OUT) else Group.INSIDE), Origin.DECIDED


def _of_column(name: str, title: str, group: Group, origin: Origin) -> Channel:
    return Channel(
        name,
        title,
        unit_of(name),
        group,
        origin,
        is_exact=name.rsplit(".", 1)[-1] not in COARSE and name != "loop.time_s",
        columns=(ROW_COLUMNS.index(name),),
        valid=tuple(ROW_COLUMNS.index(flag) for flag in VALID.get(name, ())),
    )


def _list() -> dict[str, Channel]:
    tips = [
        Channel(name, title, "mm", Group.INSERTION, _ESTIMATED, True, columns, (), is_tip=True)
        for name, title, columns in _TIPS
    ]
    titled = [
        _of_column(name, title, group, origin)
        for group, rows in TITLES.items()
        for name, title, origin in rows
    ]
    named = {one.name for one in titled}
    others = [_of_column(name, name, *_group_of(name)) for name in ROW_COLUMNS if name not in named]
    found = sorted(
        (*titled[:5], *tips, *titled[5:], *others), key=lambda one: list(Group).index(one.group)
    )
    return {one.name: one for one in found}


CHANNELS = _list()
"""All of them by name, those of a group together."""


def plain(channel: Channel) -> dict[str, str | bool]:
    """As a page takes it."""
    return {
        "name": channel.name,
        "title": channel.title,
        "unit": channel.unit,
        "group": str(channel.group),
        "origin": str(channel.origin),
        "is_exact": channel.is_exact,
    }


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
