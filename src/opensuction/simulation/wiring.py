"""What lies between controller and twin: a link that may be faulty, and drives that watch over it.

It is played only where a fault of sensors, messages, power or controller is injected.
"""

from typing import NamedTuple

import numpy as np

from opensuction.controller.record import Outputs
from opensuction.kernel.commands import Commands
from opensuction.kernel.compiled import compiled
from opensuction.kernel.generated import row
from opensuction.kernel.readings import Readings
from opensuction.twin.fault import link
from opensuction.twin.fault.link import Link, LinkState, Ring
from opensuction.twin.machine import drive_watchdog
from opensuction.twin.machine.drive_watchdog import DriveWatchdog, WatchdogState


class Wiring(NamedTuple):
    """What lies between the two sides."""

    link: Link
    watchdog: DriveWatchdog


class LinkedState(NamedTuple):
    """State of what lies between the two sides."""

    link: LinkState
    watchdog: WatchdogState
    outputs: Outputs
    """The controller's last."""


class Messages(NamedTuple):
    """What the link remembers, as rows that it writes.

    Without them it is not played, and nothing of it is compiled.
    """

    got: Ring
    """Last readings."""
    sent: Ring
    """Last commands."""
    state: row.Row
    """The `LinkedState`."""


read_link = row.reader(LinkedState)
write_link = row.writer(LinkedState)


HEALTHY = Wiring(
    link=link.healthy(0),
    watchdog=DriveWatchdog(silence_s=0.0, home_mm=0.0, out_mm_per_s=0.0),
)
"""Where the link is not played."""


@compiled
def command_drives(
    wiring: Wiring,
    messages: Messages,
    reported: Readings,
    readings: Readings,
    outputs: Outputs,
    tick: int,
    dt_s: float,
) -> Commands:
    """Commands that the drives obey, on their own where no new ones come.

    reported: by the sensors. readings: as the controller got them. messages: written.
    """
    wires, before = wiring.link, read_link(messages.state)
    obeyed, heard = link.receive_commands(wires, before.link, outputs.commands, messages.sent, tick)
    received = LinkState(readings=readings, commands=obeyed)
    alone = drive_watchdog.step(
        wiring.watchdog, before.watchdog, heard, wires.mains, reported.head_mm, dt_s
    )
    write_link(messages.state, LinkedState(received, alone, outputs))
    if alone.alone:
        powered = wires.mains or wires.reserve
        obeyed = drive_watchdog.commands(
            wiring.watchdog, alone, powered, reported.head_mm, reported.cam_rad
        )
    return obeyed


def start(reading: Readings) -> Messages:
    """Messages of a link that has always carried these readings and no command."""
    last = np.zeros(len(row.columns(LinkedState)))
    commands = _begin_link(last, reading)
    return Messages(*link.rings(LinkState(reading, commands)), last)


@compiled
def _begin_link(last: row.Row, reading: Readings) -> Commands:
    """Write the state of a link before anything was commanded; returns its empty commands."""
    blank: LinkedState = read_link(last)
    received = blank.link._replace(readings=reading)
    write_link(last, LinkedState(received, drive_watchdog.LISTENING, blank.outputs))
    return received.commands


@compiled
def read_drives(last: row.Row) -> WatchdogState:
    """What the drives remember; last: of `Messages`."""
    linked: LinkedState = read_link(last)
    return linked.watchdog


@compiled
def release_drives(last: row.Row) -> None:
    """A controller has started anew: the drives obey it. last: of `Messages`, written."""
    linked: LinkedState = read_link(last)
    write_link(last, linked._replace(watchdog=drive_watchdog.LISTENING))
