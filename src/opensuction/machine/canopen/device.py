"""A machine on a CANopen bus as its device file describes it: nodes, units, inputs and limits.

`device_file` reads it, the driver and the emulated drives go by it. Counts are a node's integers on
the bus; mm, rad, mmHg and A are ours.
"""

import math
from enum import StrEnum
from typing import Final, NamedTuple

from opensuction.machine.canopen.objects import AbortConnection

WRAP: Final = 1 << 32
"""Counts after which a position of 32 bits comes back to where it was."""


class Bus(NamedTuple):
    """Bus that the nodes are on, in python-can's words."""

    interface: str
    """`unix` is our own, for processes of one computer; else one of python-can's."""
    channel: str
    bitrate: int
    """bit/s; 0 where the interface has none."""
    period_s: float
    """Between two SYNC: the control loop's period."""


class Identity(NamedTuple):
    """Identity object (0x1018) that a node must have; 0 where any will do."""

    vendor: int
    product: int
    revision: int


class AxisMode(StrEnum):
    """Mode that an axis is driven in."""

    POSITION = "position"
    """Cyclic synchronous position: the drive's own servo."""
    TORQUE = "torque"
    """Cyclic synchronous torque: our servo, over the bus."""


class DriveAxis(NamedTuple):
    """One CiA 402 drive with its axis."""

    node: int
    identity: Identity
    mode: AxisMode
    counts_per_unit: float
    """Encoder counts for each mm (insertion) or rad (valve), from gear ratio, pinion and encoder;
    negative where the drive counts the other way."""
    zero_counts: int
    """Position on the bus at 0 mm or 0 rad, after homing."""
    lowest: float
    highest: float
    """Range of positions, in mm or rad, beyond which nothing is sent."""
    most_per_s: float
    """Highest speed, mm/s or rad/s: the drive's own limit is set to it."""
    rated_current_a: float
    """Current at 1000 thousandths of the rated torque (0x6077)."""
    most_torque: float
    """Highest share of the rated torque."""
    lost_host: AbortConnection
    """Reaction to a host that is lost."""


class ContactInput(NamedTuple):
    """Contact switch at the tip, on the insertion drive's digital inputs (0x60FD)."""

    closed_bit: int
    """The switch is closed: the drive's own stop on this input is armed."""
    wired_bit: int
    """Its line is closed through the resistor in the tip."""


class Analogue(NamedTuple):
    """Analogue channel of the module: value = (counts - zero) / counts_per_unit."""

    channel: int
    """From 1; 0 where the machine does not have it."""
    counts_per_unit: float
    zero_counts: int


class InputModule(NamedTuple):
    """CiA 401 module: valves, sensors and the patient monitor's outputs."""

    node: int
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
    mouth_bit: int
    """Digital input: nothing in the beam at the tube's mouth; -1 without a light barrier."""
    monitor_bit: int
    """Digital input: the monitor is connected; -1 where there is none."""
    validity_bits: tuple[int, int, int]
    """Digital inputs: saturation, heart rate and airway pressure are measured now."""
    regulator: Analogue
    """Analogue output: set point of the vacuum regulator, mmHg."""
    pump_bit: int
    """Digital output: the pump runs."""


class Heartbeats(NamedTuple):
    """Signs of life, in ms."""

    host_ms: int
    """How often the controller gives one."""
    lost_host_ms: int
    """Without one for longer than this the nodes react as `DriveAxis.lost_host` says."""
    node_ms: int
    """How often a node gives one."""
    lost_node_ms: int
    """Without one for longer than this a node counts as lost; one that is late alone does not."""


class Device(NamedTuple):
    """A machine on a bus."""

    name: str
    bus: Bus
    host_node: int
    """Our own number on the bus, which heartbeats name."""
    heartbeats: Heartbeats
    insertion: DriveAxis
    valve: DriveAxis
    contact: ContactInput
    module: InputModule

    @property
    def nodes(self) -> tuple[int, int, int]:
        """Numbers of insertion drive, valve drive and module."""
        return self.insertion.node, self.valve.node, self.module.node


def counts_of(axis: DriveAxis, position: float) -> int:
    """Target on the bus for a position in mm or rad, within the axis' range, as 32 bits hold it."""
    within = min(max(position, axis.lowest), axis.highest)
    return wrap(axis.zero_counts + round(within * axis.counts_per_unit))


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
