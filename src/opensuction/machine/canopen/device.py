"""A machine on a CANopen bus as its device file describes it: nodes, units, inputs and limits.

`device_file` reads it, the driver and the emulated drives go by it. Counts are a node's integers on
the bus; mm, rad, mmHg and A are ours.
"""

import math
from enum import StrEnum
from typing import Annotated, Final, Literal, NamedTuple

from annotated_types import Ge, Gt, Le, Len

from opensuction.machine.canopen.objects import AbortConnection

WRAP: Final = 1 << 32
"""Counts after which a position of 32 bits comes back to where it was."""

NodeNumber = Annotated[int, Ge(1), Le(127)]
Uint32 = Annotated[int, Ge(0), Le(WRAP - 1)]
Word = Annotated[int, Ge(-0x8000), Le(0x7FFF)]
InputBit = Annotated[int, Ge(-1), Le(15)]
Milliseconds = Annotated[int, Ge(1), Le(1000)]


class Bus(NamedTuple):
    """Bus that the nodes are on, in python-can's words."""

    interface: Annotated[str, Len(1)]
    """`unix` is our own, for processes of one computer; else one of python-can's."""
    channel: Annotated[str, Len(1)]
    bitrate: Annotated[int, Ge(0), Le(1_000_000)]
    """bit/s; 0 where the interface has none."""
    period_s: Annotated[float, Ge(0.001), Le(0.01)]
    """Between two SYNC: the control loop's period; whole ms, as drives interpolate (0x60C2)."""


class Identity(NamedTuple):
    """Identity object (0x1018) that a node must have; 0 where any will do."""

    vendor: Uint32
    product: Uint32
    revision: Uint32


class AxisMode(StrEnum):
    """Mode that an axis is driven in."""

    POSITION = "position"
    """Cyclic synchronous position: the drive's own servo."""
    TORQUE = "torque"
    """Cyclic synchronous torque: our servo, over the bus."""


class Encoder(NamedTuple):
    """Encoder on a motor, and what is between that motor and its axis."""

    counts_per_turn: Annotated[int, Ge(1), Le(1 << 24)]
    """Of the motor, four for each line of an incremental encoder."""
    gear_ratio: Annotated[float, Gt(0), Le(10_000)]
    """Turns of the motor for a turn of the pinion or the cam."""
    travel_per_turn: Annotated[float, Gt(0), Le(1000)]
    """Of the pinion: its pitch circle, mm; of the cam: 2 pi, rad."""
    reversed: bool
    """The drive counts down as the head moves in, or the valve opens."""


class AxisMotor(NamedTuple):
    """Motor of an axis, for a drive whose torque is set; volts as our servo gives them."""

    rated_v: Annotated[float, Gt(0), Le(1000)]
    """Volts that drive the rated current at standstill."""
    back_emf_v_s: Annotated[float, Gt(0), Le(1000)]
    """Volts for each mm/s or rad/s of speed."""
    speed_lag_s: Annotated[float, Ge(0), Le(0.02)]
    """How late the drive's velocity (0x606C) is, which it averages."""


HOMES_HERE: Final = (35, 37)
"""Homing methods that move nothing: where the axis stands is its home."""


class Homing(NamedTuple):
    """Way in which a drive finds its position after it was switched on (CiA 402)."""

    method: Annotated[int, Ge(-128), Le(37)]
    """Object 0x6098; 0: the drive knows its position by itself."""
    at: float
    """Position of the point that the method finds, mm or rad."""
    per_s: Annotated[float, Gt(0), Le(1000)]
    """Speed towards a switch or an end (0x6099:01), mm/s or rad/s."""
    slow_per_s: Annotated[float, Gt(0), Le(1000)]
    """Speed at which the point itself is found (0x6099:02)."""
    per_s2: Annotated[float, Gt(0), Le(100_000)]
    """Acceleration (0x609A)."""

    @property
    def moves(self) -> bool:
        """True where the axis moves while it is homed."""
        return self.method not in (0, *HOMES_HERE)


class DriveAxis(NamedTuple):
    """One CiA 402 drive with its axis."""

    node: NodeNumber
    identity: Identity
    mode: AxisMode
    encoder: Encoder
    zero_counts: Annotated[int, Ge(-WRAP // 2), Le(WRAP // 2 - 1)]
    """Position on the bus at 0 mm or 0 rad, after homing."""
    lowest: float
    highest: float
    """Range of positions, in mm or rad, beyond which nothing is sent."""
    most_per_s: Annotated[float, Gt(0), Le(1000)]
    """Highest speed, mm/s or rad/s: the drive's own limit is set to it."""
    rated_current_a: Annotated[float, Gt(0), Le(100)]
    """Current at 1000 thousandths of the rated torque (0x6077)."""
    most_torque: Annotated[float, Gt(0), Le(5)]
    """Highest share of the rated torque."""
    motor: AxisMotor
    lost_host: AbortConnection
    """Reaction to a host that is lost."""
    velocity_offset: bool
    """The drive's servo has its feedforward from us (0x60B1), not from its targets."""
    following_window: Annotated[float, Ge(0), Le(10_000)]
    """Distance from set point to position beyond which the drive takes its torque off (0x6065), mm
    or rad; 0: it never does."""
    homing: Homing

    @property
    def counts_per_unit(self) -> float:
        """Encoder counts for each mm or rad; negative where the drive counts the other way."""
        one = self.encoder
        counts = one.counts_per_turn * one.gear_ratio / one.travel_per_turn
        return -counts if one.reversed else counts

    @property
    def most_rpm(self) -> int:
        """Highest speed of the motor, turns each minute (0x6080)."""
        one = self.encoder
        return round(60.0 * self.most_per_s * one.gear_ratio / one.travel_per_turn)


class MakerObject(NamedTuple):
    """An object of a drive's maker, with the value that it must have."""

    object_index: Annotated[int, Ge(0x2000), Le(0x5FFF)]
    """In the part of the dictionary that CiA 301 leaves to makers."""
    sub: Annotated[int, Ge(0), Le(255)]
    bits: Literal[8, 16, 32]
    """Length of the value."""
    value: Uint32


class ContactInput(NamedTuple):
    """Contact switch at the tip, on the insertion drive's digital inputs (0x60FD)."""

    closed_bit: Annotated[int, Ge(0), Le(31)]
    """The switch is closed."""
    wired_bit: Annotated[int, Ge(0), Le(31)]
    """Its line is closed through the resistor in the tip."""
    stop: tuple[MakerObject, ...]
    """Objects of the insertion drive by which it stops on its own while the switch is closed,
    whether a host lives or not. They are written with every set-up of the drive."""


class Analogue(NamedTuple):
    """Analogue channel of the module: value = (counts - zero) / counts_per_unit."""

    channel: Annotated[int, Ge(0), Le(8)]
    """From 1; 0 where the machine does not have it."""
    counts_per_unit: float
    zero_counts: Word


class InputModule(NamedTuple):
    """CiA 401 module: valves, sensors and the patient monitor's outputs."""

    node: NodeNumber
    identity: Identity
    vacuum: Analogue
    """Vacuum in the canister, mmHg."""
    carriage: Analogue
    """Second sensor of the head's position, mm."""
    spo2: Analogue
    """Oxygen saturation, %, by the monitor's analogue output."""
    heart_rate: Analogue
    """1/min."""
    airway_pressure: Analogue
    """cmH2O."""
    mouth_bit: InputBit
    """Digital input: nothing in the beam at the tube's mouth; -1 without a light barrier."""
    monitor_bit: InputBit
    """Digital input: the monitor is connected; -1 where there is none."""
    validity_bits: tuple[InputBit, InputBit, InputBit]
    """Digital inputs: saturation, heart rate and airway pressure are measured now; -1 without."""
    regulator: Analogue
    """Analogue output: set point of the vacuum regulator, mmHg."""
    most_vacuum_mmhg: Annotated[float, Gt(0), Le(200)]
    """Highest set point that is sent."""
    pump_bit: Annotated[int, Ge(0), Le(7)]
    """Digital output: the pump runs."""


class Heartbeats(NamedTuple):
    """Signs of life, in ms."""

    host_ms: Milliseconds
    """How often the controller gives one."""
    lost_host_ms: Annotated[int, Ge(2), Le(99)]
    """Without one for longer than this the nodes react as `DriveAxis.lost_host` says."""
    node_ms: Milliseconds
    """How often a node gives one."""
    lost_node_ms: Milliseconds
    """Without one for longer than this a node counts as lost; one that is late alone does not."""


class Device(NamedTuple):
    """A machine on a bus."""

    name: Annotated[str, Len(1, 60)]
    in_silico: bool
    """Its nodes are emulated: nothing moves but numbers."""
    bus: Bus
    host_node: NodeNumber
    """Our own number on the bus, which heartbeats name."""
    heartbeats: Heartbeats
    insertion: DriveAxis
    valve: DriveAxis
    contact: ContactInput
    module: InputModule

    @property
    def axes(self) -> tuple[DriveAxis, DriveAxis]:
        """Insertion and valve."""
        return self.insertion, self.valve

    @property
    def nodes(self) -> tuple[int, int, int]:
        """Numbers of insertion drive, valve drive and module."""
        return self.insertion.node, self.valve.node, self.module.node


def counts_of(axis: DriveAxis, position: float) -> int:
    """Target on the bus for a position in mm or rad, within the axis' range, as 32 bits hold it."""
    within = min(max(position, axis.lowest), axis.highest)
    return wrap(axis.zero_counts + round(within * axis.counts_per_unit))


def window_of(axis: DriveAxis) -> int:
    """Following error window in counts; all bits switch the drive's watch off (CiA 402)."""
    counts = round(axis.following_window * abs(axis.counts_per_unit))
    return counts if axis.following_window > 0.0 else WRAP - 1


def wrap(counts: int) -> int:
    """A count as a signed number of 32 bits holds it."""
    return (counts + WRAP // 2) % WRAP - WRAP // 2


def position_of(axis: DriveAxis, counts: int) -> float:
    """Position in mm or rad of counts on the bus, across the wrap at 32 bits.

    The shorter way round from zero: no axis is half of 2^32 counts long.
    """
    return wrap(counts - axis.zero_counts) / axis.counts_per_unit


def value_of(channel: Analogue, counts: int) -> float:
    """Value of an analogue input in its unit; NaN where the machine does not have it."""
    if channel.channel == 0:
        return math.nan
    return (counts - channel.zero_counts) / channel.counts_per_unit


def output_of(channel: Analogue, value: float) -> int:
    """Counts of an analogue output, within 16 bits."""
    counts = channel.zero_counts + round(value * channel.counts_per_unit)
    return min(max(counts, -0x8000), 0x7FFF)
