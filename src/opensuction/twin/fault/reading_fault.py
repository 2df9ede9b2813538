"""A sensor at fault, tick by tick: the reading changes on its way, what it measures does not.

There is no state: what a fault needs of the past, the reading at its instant and its tick, are
among its parameters, and chance is drawn from the number of the tick.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Readings
from opensuction.kernel.random_stream import RandomStream
from opensuction.kernel.record import make_zero

JUMP_TICKS = 50
"""A jumping reading jumps anew after so many ticks."""
FAULT_PURPOSE = 3_000_000
"""Streams from here on are the chance of faults, one each."""


class Channel(IntEnum):
    """Reading that a fault concerns."""

    NONE = 0
    HEAD = 1
    CAM = 2
    VACUUM = 3
    CONTACT = 4
    CURRENT = 5
    CARRIAGE = 6
    HEADS = 7
    """Both sensors of the head."""


class Mode(IntEnum):
    """Mode of a fault of a reading."""

    OFFSET = 0
    NOISY = 1
    JUMPING = 2
    SCALED = 3
    """Changes since the instant count by a factor: 0 is frozen, -1 reversed."""
    INVALID = 4
    DEAD = 5
    """It reads 0; a contact switch is open."""
    DRIFTING = 6
    FLIPPED = 7
    """A contact switch reads what is not."""


class ReadingFault(NamedTuple):
    """A fault of one sensor."""

    channel: int
    mode: int
    strength: float
    """Of a drift: for each tick."""
    anchor: float
    """Reading at the instant."""
    begin_tick: int
    there_ticks: int
    """For so long it is there; `FOR_GOOD` where it does not go away."""
    period_ticks: int
    """After so long it comes again; 0 where it does not."""
    stream: RandomStream
    """Its chance; block ``tick`` is drawn in each."""


FOR_GOOD = 2**31
"""Ticks that no run has."""
HEALTHY = make_zero(ReadingFault, stream=random_stream.stream(0, FAULT_PURPOSE))
"""No sensor is at fault."""


class Spell(NamedTuple):
    """Begin, duration and period of a fault, in ticks."""

    begin: int
    there: int = FOR_GOOD
    period: int = 0


def _anchor(channel: Channel, readings: Readings) -> float:
    return {
        Channel.HEAD: readings.head_mm,
        Channel.CARRIAGE: readings.carriage_mm,
        Channel.CAM: readings.cam_rad,
        Channel.VACUUM: readings.line_vacuum_mmhg,
    }.get(channel, 0.0)


def begin(
    channel: Channel,
    mode: Mode,
    strength: float,
    readings: Readings,
    spell: Spell,
    stream: RandomStream,
) -> ReadingFault:
    """The fault of a sensor that begins with these readings. stream: its chance."""
    return ReadingFault(
        channel=int(channel),
        mode=int(mode),
        strength=strength,
        anchor=float(_anchor(channel, readings)),
        begin_tick=spell.begin,
        there_ticks=spell.there,
        period_ticks=spell.period,
        stream=stream,
    )


def chance(seed: int, number: int) -> RandomStream:
    """Chance of a sensor's fault; number: which fault."""
    return random_stream.stream(seed, FAULT_PURPOSE + number)


@compiled
def _is_there(fault: ReadingFault, tick: int) -> bool:
    """True while the fault acts in a tick."""
    since = tick - fault.begin_tick
    if fault.period_ticks > 0:
        since %= fault.period_ticks
    return since < fault.there_ticks


@compiled
def _concerns(fault: ReadingFault, channel: int) -> bool:
    """True where the fault is one of that channel."""
    if fault.channel == Channel.HEADS:
        return channel in (Channel.HEAD, Channel.CARRIAGE)
    return fault.channel == channel


@compiled
def distort(fault: ReadingFault, channel: int, true: float, tick: int) -> float:
    """Reading of a channel whose true value is ``true``."""
    if not _concerns(fault, channel):
        return true
    if fault.mode == Mode.OFFSET:
        return true + fault.strength
    if fault.mode == Mode.DRIFTING:
        return true + fault.strength * (tick - fault.begin_tick)
    if fault.mode == Mode.SCALED:
        return fault.anchor + fault.strength * (true - fault.anchor)
    if fault.mode == Mode.DEAD:
        return 0.0
    if fault.mode == Mode.INVALID:
        return math.nan
    block = tick if fault.mode == Mode.NOISY else tick // JUMP_TICKS
    first, second, _ = random_stream.uniform_pair(fault.stream._replace(counter=block))
    if fault.mode == Mode.JUMPING:
        return true + fault.strength * (2.0 * first - 1.0)
    radius = math.sqrt(-2.0 * math.log(first))
    return true + fault.strength * radius * math.cos(2.0 * math.pi * second)


@compiled
def _is_valid(fault: ReadingFault, channel: int, valid: bool) -> bool:
    return valid and not (_concerns(fault, channel) and fault.mode == Mode.INVALID)


@compiled
def _is_closed(fault: ReadingFault, closed: bool) -> bool:
    """Reading of the contact switch."""
    if fault.channel != Channel.CONTACT:
        return closed
    if fault.mode == Mode.FLIPPED:
        return not closed
    return closed and fault.mode != Mode.DEAD


@compiled
def apply(fault: ReadingFault, readings: Readings, tick: int) -> Readings:
    """Readings that the sensors report in a tick, one of them at fault."""
    if fault.channel == Channel.NONE or not _is_there(fault, tick):
        return readings
    return readings._replace(
        head_mm=distort(fault, Channel.HEAD, readings.head_mm, tick),
        head_valid=_is_valid(fault, Channel.HEAD, readings.head_valid),
        carriage_mm=distort(fault, Channel.CARRIAGE, readings.carriage_mm, tick),
        carriage_valid=_is_valid(fault, Channel.CARRIAGE, readings.carriage_valid),
        cam_rad=distort(fault, Channel.CAM, readings.cam_rad, tick),
        cam_valid=_is_valid(fault, Channel.CAM, readings.cam_valid),
        line_vacuum_mmhg=distort(fault, Channel.VACUUM, readings.line_vacuum_mmhg, tick),
        vacuum_valid=_is_valid(fault, Channel.VACUUM, readings.vacuum_valid),
        contact_closed=_is_closed(fault, readings.contact_closed),
        contact_valid=_is_valid(fault, Channel.CONTACT, readings.contact_valid),
        insertion_current_a=distort(fault, Channel.CURRENT, readings.insertion_current_a, tick),
    )
