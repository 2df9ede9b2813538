"""Link between controller and machine: sensors' wires, messages and power, sound or faulty.

A run without such faults does not use it. A run with one passes every reading and every command
through here, and controller and drives get what comes out. Recent messages of both directions are
kept in rings of rows, so that one can come late.
"""

from typing import NamedTuple

import numpy as np

from opensuction.kernel import random_stream
from opensuction.kernel.codegen import row
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Commands, Monitor, Readings
from opensuction.kernel.random_stream import RandomStream
from opensuction.kernel.record import Array, make_zero
from opensuction.twin.fault import bus, reading_fault
from opensuction.twin.fault.bus import Bus, BusTicks
from opensuction.twin.fault.reading_fault import FAULT_PURPOSE, ReadingFault

RING_TICKS = 2048
"""Rows that a ring holds, a power of two: more than the longest delay has ticks."""
Ring = Array
"""Last messages one way, shape (`RING_TICKS`, columns)."""


class Message(NamedTuple):
    """Message of the controller in a tick."""

    commands: Commands
    wanted: int
    """Mask of what it wants people to be told."""
    number: int
    """Its tick. The drives take no number that is not above the last: an old or repeated one is
    none."""


SILENT = -1
"""Number of the message of a controller that does not run: below every other."""
_NUMBER = row.columns(Message).index("number")
_write_message = row.table_writer(Message)
_read_message = row.table_reader(Message)
_write_readings = row.table_writer(Readings)
_read_readings = row.table_reader(Readings)
_write_monitor = row.table_writer(Monitor)
_read_monitor = row.table_reader(Monitor)


class Turns(NamedTuple):
    """Turns by which losses come and go: all of one length, the first with them."""

    ticks: int
    """0: they are there all the time."""
    from_tick: int


ALWAYS = make_zero(Turns)
MONITOR_TICKS = 10
"""The patient monitor's values change once in so many ticks."""
MONITOR_ROWS = 2048
"""Values of a monitor that are remembered, a power of two: 20 s."""


class Link(NamedTuple):
    """Link between controller and machine, with its faults."""

    first: ReadingFault
    second: ReadingFault
    """Of sensors; two at most."""
    reading_delay_ticks: int
    reading_lost_share: float
    reading_turns: Turns
    readings_repeated: bool
    command_delay_ticks: int
    command_lost_share: float
    command_turns: Turns
    commands_repeated: bool
    monitor_frozen: bool
    monitor_delay_steps: int
    """In steps of `MONITOR_TICKS`."""
    late_until_tick: int
    """The host reports every tick before this as late."""
    controller_runs: bool
    mains: bool
    reserve: bool
    """Energy for the drives without the mains."""
    carrier: BusTicks
    """A bus under it: what messages take on top of the delays, and how many it loses."""
    stream: RandomStream
    """Chance of losses; block ``tick`` is drawn in each."""


class LinkState(NamedTuple):
    """Last messages that both sides received."""

    readings: Readings
    message: Message


class LinkPast(NamedTuple):
    """Earlier messages that arrive now; not looked at where the link delays nothing.

    It is read before a tick, and kept after it, by whoever has the rings: what hands them on has
    their references counted at every hand, which took longer than the tick.
    """

    readings: Readings
    reading_ticks: int
    """How old they are; 0: they are those that are sent in this tick; -1: none has come."""
    message: Message
    command_ticks: int
    """How old it is; 0 where none has come of those that were sent before this tick."""
    at_once: bool
    """What is sent in this tick comes in it, though there is a bus."""
    monitor: Monitor


def healthy(seed: int) -> Link:
    """A link that lets everything through. seed: its chance once it does not."""
    return make_zero(
        Link,
        first=reading_fault.HEALTHY,
        second=reading_fault.HEALTHY,
        controller_runs=True,
        mains=True,
        reserve=True,
        stream=random_stream.stream(seed, FAULT_PURPOSE),
    )


def rings(state: LinkState) -> tuple[Ring, Ring, Ring]:
    """Rings for readings, messages and the monitor's values, as if they had always been so."""
    got = np.zeros((RING_TICKS, len(row.columns(Readings))))
    sent = np.zeros((RING_TICKS, len(row.columns(Message))))
    _write_readings(got, 0, state.readings)
    _write_message(sent, 0, state.message)
    shown = np.zeros((MONITOR_ROWS, len(row.columns(Monitor))))
    _write_monitor(shown, 0, state.readings.monitor)
    got[1:], sent[1:], shown[1:] = got[0], sent[0], shown[0]
    return got, sent, shown


def on_bus(link: Link, carrier: Bus, dt_s: float) -> Link:
    """The same link with a bus under it. Raises InputError for what no bus does."""
    carrier.check()
    return link._replace(carrier=bus.spread_of(carrier, dt_s))


def with_reading_fault(link: Link, fault: ReadingFault) -> Link:
    """The same link with one more sensor at fault."""
    if link.first.channel == reading_fault.Channel.NONE:
        return link._replace(first=fault)
    return link._replace(second=fault)


@compiled
def sense(link: Link, true: Readings, tick: int) -> Readings:
    """Readings that the sensors report of the true ones."""
    once = reading_fault.apply(link.first, true, tick)
    return reading_fault.apply(link.second, once, tick)


@compiled
def _invalidate(readings: Readings) -> Readings:
    """The same readings as a lost message leaves them: not valid."""
    # The monitor has a link of its own.
    return readings._replace(
        head_valid=False,
        carriage_valid=False,
        cam_valid=False,
        vacuum_valid=False,
        contact_valid=False,
    )


@compiled
def _is_turn(turns: Turns, tick: int) -> bool:
    """True while a loss that comes and goes by turns is there."""
    return turns.ticks == 0 or (tick - turns.from_tick) // turns.ticks % 2 == 0


@compiled
def _chances(link: Link, tick: int) -> tuple[float, float]:
    if link.reading_lost_share == 0.0 and link.command_lost_share == 0.0:
        return 1.0, 1.0
    first, second, _ = random_stream.uniform_pair(link.stream._replace(counter=tick))
    return first, second


@compiled
def _ring_row(tick: int) -> int:
    return tick & (RING_TICKS - 1)


@compiled
def _monitor_row(step: int) -> int:
    return step & (MONITOR_ROWS - 1)


@compiled
def _step_of(tick: int) -> int:
    return tick // MONITOR_TICKS


@compiled
def _is_command_lost(link: Link, tick: int) -> bool:
    lost = _chances(link, tick)[1] < link.command_lost_share
    return lost and _is_turn(link.command_turns, tick)


@compiled
def _reading_ticks(link: Link, tick: int) -> int:
    """Age of the newest readings that have come; -1 where none have for long."""
    delay = link.reading_delay_ticks
    if not bus.is_there(link.carrier):
        return delay
    for old in range(delay, delay + bus.oldest_ticks(link.carrier) + 1):
        if bus.has_come(link.carrier, link.stream, bus.READINGS, tick - old, old - delay):
            return old
    return -1


@compiled
def _takes_command(link: Link, tick: int, old: int) -> bool:
    """True where a command of so many ticks ago has come over the bus by now."""
    taken = old - link.command_delay_ticks
    if not bus.has_come(link.carrier, link.stream, bus.COMMANDS, tick - old, taken):
        return False
    return not _is_command_lost(link, tick - old)


@compiled
def _command_ticks(link: Link, sent: Ring, tick: int) -> int:
    """Age of the newest command that has come, of those that were sent before this tick.

    0: over a bus none has, or there is no bus and no delay.
    """
    delay = link.command_delay_ticks
    if not bus.is_there(link.carrier):
        return delay
    for old in range(max(delay, 1), delay + bus.oldest_ticks(link.carrier) + 1):
        if sent[_ring_row(tick - old), _NUMBER] > SILENT and _takes_command(link, tick, old):
            return old
    return 0


@compiled
def recall(link: Link, got: Ring, sent: Ring, shown: Ring, tick: int) -> LinkPast:
    """Messages sent before a tick that arrive in it. got, sent, shown: see `rings`."""
    # All three, needed or not: no branch lies between the references' counts, so there are none.
    step, reading_ticks = _step_of(tick), _reading_ticks(link, tick)
    command_ticks = _command_ticks(link, sent, tick)
    return LinkPast(
        readings=_read_readings(got, _ring_row(tick - reading_ticks)),
        reading_ticks=reading_ticks,
        message=_read_message(sent, _ring_row(tick - command_ticks)),
        command_ticks=command_ticks,
        at_once=bus.is_there(link.carrier) and _takes_command(link, tick, 0),
        monitor=_read_monitor(shown, _monitor_row(step - link.monitor_delay_steps)),
    )


@compiled
def keep(
    reported: Readings, message: Message, got: Ring, sent: Ring, shown: Ring, tick: int
) -> None:
    """Keep what was sent in a tick. got, sent, shown: see `rings`; written."""
    _write_readings(got, _ring_row(tick), reported)
    _write_message(sent, _ring_row(tick), message)
    if tick % MONITOR_TICKS == 0:
        _write_monitor(shown, _monitor_row(_step_of(tick)), reported.monitor)


@compiled
def receive_readings(
    link: Link, state: LinkState, reported: Readings, past: LinkPast, tick: int
) -> Readings:
    """Readings that the controller receives in a tick of those that the sensors report."""
    if link.readings_repeated:
        return state.readings
    lost = _chances(link, tick)[0] < link.reading_lost_share
    if lost and _is_turn(link.reading_turns, tick):
        return _invalidate(state.readings)
    if past.reading_ticks < 0:
        return state.readings
    if past.reading_ticks == 0:
        return reported
    return past.readings


@compiled
def receive_monitor(link: Link, state: LinkState, shown: Monitor, past: LinkPast) -> Monitor:
    """Values that the controller receives of the patient monitor, which has a link of its own."""
    if link.monitor_frozen:
        return state.readings.monitor
    if link.monitor_delay_steps == 0:
        return shown
    return past.monitor


@compiled
def receive_message(
    link: Link, state: LinkState, sent: Message, past: LinkPast, tick: int
) -> tuple[Message, bool]:
    """Message that the drives go by in a tick; true where it is new."""
    carried = bus.is_there(link.carrier)
    lost = not carried and _is_command_lost(link, tick)  # over a bus each message for itself
    if lost or link.commands_repeated or not link.controller_runs:
        return state.message, False
    arrived: Message = sent
    earlier = carried and not (past.at_once and sent.number > SILENT)
    if earlier or link.command_delay_ticks > 0:
        arrived = past.message
    if arrived.number <= state.message.number or (earlier and past.command_ticks == 0):
        return state.message, False
    return arrived, True
