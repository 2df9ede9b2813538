"""Faults of sensors: what is read changes on its way, what is does not.

Nothing is remembered from tick to tick: what a fault needs of the past, the value at its instant,
is among its parameters, and chance is drawn from the number of the tick.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import RandomStream
from opensuction.kernel.readings import Readings
from opensuction.twin.fault.fault import Fault

JUMP_TICKS = 50
"""A jumping reading jumps anew after so many ticks."""
FAULT_PURPOSE = 3_000_000
"""Streams from here on are the chance of faults, one each."""


class Channel(IntEnum):
    """Which reading."""

    NONE = 0
    HEAD = 1
    CAM = 2
    VACUUM = 3
    CONTACT = 4
    CURRENT = 5
    CARRIAGE = 6


class Mode(IntEnum):
    """What happens to it."""

    OFFSET = 0
    NOISY = 1
    JUMPING = 2
    SCALED = 3
    """Changes since the instant count by a factor: 0 is frozen, -1 reversed."""
    INVALID = 4
    DEAD = 5
    """It reads 0."""


class ReadingFault(NamedTuple):
    """A fault of one sensor."""

    channel: int
    mode: int
    strength: float
    anchor: float
    """Reading at the instant."""
    stream: RandomStream
    """Its chance; block ``tick`` is drawn in each."""


HEALTHY = ReadingFault(0, 0, 0.0, 0.0, random_stream.stream(0, FAULT_PURPOSE))
"""No sensor is at fault."""

KINDS: dict[Fault, tuple[Channel, Mode]] = {
    Fault.SWITCH_INVALID: (Channel.CONTACT, Mode.INVALID),
    Fault.ENCODER_FROZEN: (Channel.HEAD, Mode.SCALED),
    Fault.ENCODER_SLIPPING: (Channel.HEAD, Mode.SCALED),
    Fault.ENCODER_JUMPING: (Channel.HEAD, Mode.JUMPING),
    Fault.ENCODER_OFFSET: (Channel.HEAD, Mode.OFFSET),
    Fault.ENCODER_NOISY: (Channel.HEAD, Mode.NOISY),
    Fault.ENCODER_INVALID: (Channel.HEAD, Mode.INVALID),
    Fault.ENCODER_REVERSED: (Channel.HEAD, Mode.SCALED),
    Fault.CURRENT_SENSOR_DEAD: (Channel.CURRENT, Mode.DEAD),
    Fault.CARRIAGE_SENSOR_FROZEN: (Channel.CARRIAGE, Mode.SCALED),
    Fault.CARRIAGE_SENSOR_INVALID: (Channel.CARRIAGE, Mode.INVALID),
    Fault.CAM_ENCODER_FROZEN: (Channel.CAM, Mode.SCALED),
    Fault.CAM_ENCODER_OFFSET: (Channel.CAM, Mode.OFFSET),
    Fault.CAM_ENCODER_NOISY: (Channel.CAM, Mode.NOISY),
    Fault.CAM_ENCODER_INVALID: (Channel.CAM, Mode.INVALID),
    Fault.VACUUM_SENSOR_FROZEN: (Channel.VACUUM, Mode.SCALED),
    Fault.VACUUM_SENSOR_OFFSET: (Channel.VACUUM, Mode.OFFSET),
    Fault.VACUUM_SENSOR_NOISY: (Channel.VACUUM, Mode.NOISY),
    Fault.VACUUM_SENSOR_INVALID: (Channel.VACUUM, Mode.INVALID),
}
"""For every fault of `Means.READING`."""

FACTORS = {
    Fault.ENCODER_FROZEN: 0.0,
    Fault.CARRIAGE_SENSOR_FROZEN: 0.0,
    Fault.CAM_ENCODER_FROZEN: 0.0,
    Fault.VACUUM_SENSOR_FROZEN: 0.0,
    Fault.ENCODER_REVERSED: -1.0,
}
"""Of the scaled readings whose factor is not the fault's strength."""


def _anchor(channel: Channel, readings: Readings) -> float:
    return {
        Channel.HEAD: readings.head_mm,
        Channel.CARRIAGE: readings.carriage_mm,
        Channel.CAM: readings.cam_rad,
        Channel.VACUUM: readings.line_vacuum_mmhg,
    }.get(channel, 0.0)


def of(fault: Fault, strength: float, readings: Readings, seed: int) -> ReadingFault:
    """The fault of a sensor that begins with these readings.

    fault: one of `Means.READING`; raises KeyError for another. seed: its chance.
    """
    channel, mode = KINDS[fault]
    if mode == Mode.SCALED:
        strength = FACTORS.get(fault, 1.0 - strength)
    return ReadingFault(
        channel=int(channel),
        mode=int(mode),
        strength=strength,
        anchor=float(_anchor(channel, readings)),
        stream=random_stream.stream(seed, FAULT_PURPOSE + fault),
    )


@compiled
def at(stream: RandomStream, block: int) -> RandomStream:
    """The stream at a block, whatever was drawn before."""
    return RandomStream(stream.key_0, stream.key_1, block)


@compiled
def value(fault: ReadingFault, channel: int, true: float, tick: int) -> float:
    """What is read of a channel where ``true`` is right."""
    if fault.channel != channel:
        return true
    if fault.mode == Mode.OFFSET:
        return true + fault.strength
    if fault.mode == Mode.SCALED:
        return fault.anchor + fault.strength * (true - fault.anchor)
    if fault.mode == Mode.DEAD:
        return 0.0
    if fault.mode == Mode.INVALID:
        return math.nan
    block = tick if fault.mode == Mode.NOISY else tick // JUMP_TICKS
    first, second, _ = random_stream.uniform_pair(at(fault.stream, block))
    if fault.mode == Mode.JUMPING:
        return true + fault.strength * (2.0 * first - 1.0)
    radius = math.sqrt(-2.0 * math.log(first))
    return true + fault.strength * radius * math.cos(2.0 * math.pi * second)


@compiled
def _valid(fault: ReadingFault, channel: int, valid: bool) -> bool:
    return valid and not (fault.channel == channel and fault.mode == Mode.INVALID)


@compiled
def applied(fault: ReadingFault, readings: Readings, tick: int) -> Readings:
    """What the sensors report in a tick, one of them at fault."""
    return Readings(
        head_mm=value(fault, Channel.HEAD, readings.head_mm, tick),
        head_valid=_valid(fault, Channel.HEAD, readings.head_valid),
        carriage_mm=value(fault, Channel.CARRIAGE, readings.carriage_mm, tick),
        carriage_valid=_valid(fault, Channel.CARRIAGE, readings.carriage_valid),
        cam_rad=value(fault, Channel.CAM, readings.cam_rad, tick),
        cam_valid=_valid(fault, Channel.CAM, readings.cam_valid),
        line_vacuum_mmhg=value(fault, Channel.VACUUM, readings.line_vacuum_mmhg, tick),
        vacuum_valid=_valid(fault, Channel.VACUUM, readings.vacuum_valid),
        contact_closed=readings.contact_closed,
        contact_valid=_valid(fault, Channel.CONTACT, readings.contact_valid),
        insertion_current_a=value(fault, Channel.CURRENT, readings.insertion_current_a, tick),
        monitor=readings.monitor,
    )
