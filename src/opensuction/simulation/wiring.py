"""Connection of controller and twin: a link that may be faulty, and drives with a watchdog.

It is played only where a fault of sensors, messages, power or controller is injected.
"""

from typing import NamedTuple

import numpy as np

from opensuction.controller.record import Outputs
from opensuction.kernel.codegen import row
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Commands, Readings
from opensuction.twin.fault import link
from opensuction.twin.fault.link import SILENT, Link, LinkPast, LinkState, Message, Ring
from opensuction.twin.machine import fail_safe
from opensuction.twin.machine.fail_safe import Annunciator, DriveWatchdog, Lines, WatchdogState


class Wiring(NamedTuple):
    """Wiring between the two sides: link, and watchdog of the drives."""

    link: Link
    watchdog: DriveWatchdog


class LinkedState(NamedTuple):
    """State of what lies between the two sides."""

    link: LinkState
    watchdog: WatchdogState
    annunciator: Annunciator
    outputs: Outputs
    """The controller's last."""


class Messages(NamedTuple):
    """Memory of the link, as rows that it writes.

    Without them it is not played, and nothing of it is compiled.
    """

    got: Ring
    """Last readings."""
    sent: Ring
    """Last messages of the controller."""
    shown: Ring
    """Last values of the patient monitor."""
    state: row.Row
    """The `LinkedState`."""


# `start` makes the row as long as it must be.
read_link = row.reader(LinkedState, checked=False)
write_link = row.writer(LinkedState, checked=False)


HEALTHY = Wiring(
    link=link.healthy(0),
    watchdog=DriveWatchdog(silence_s=0.0, home_mm=0.0, out_mm_per_s=0.0),
)
"""Where the link is not played."""


class Between(NamedTuple):
    """State between the two sides as a tick begins."""

    linked: LinkedState
    past: LinkPast


@compiled
def receive(wires: Link, between: Between, reported: Readings, tick: int) -> Readings:
    """Readings that the controller receives of those that the sensors report."""
    before, past = between.linked.link, between.past
    readings = link.receive_readings(wires, before, reported, past, tick)
    monitor = link.receive_monitor(wires, before, reported.monitor, past)
    return readings._replace(monitor=monitor)


class Exchange(NamedTuple):
    """Exchange between the two sides in a tick."""

    reported: Readings
    """By the sensors."""
    readings: Readings
    """As the controller got them."""
    outputs: Outputs
    """The controller's; its last where it does not run."""
    reset: bool
    """A person pressed the button."""
    tick: int


class Passed(NamedTuple):
    """Messages and link state between the two sides after a tick."""

    reported: Readings
    sent: Message
    """By the controller."""
    linked: LinkedState


@compiled
def wanted(outputs: Outputs) -> int:
    """Mask of the conditions that a controller wants people to be told."""
    return outputs.signals.present | outputs.signals.latched


@compiled
def _decide_alone(
    wiring: Wiring, state: WatchdogState, obeyed: Commands, reported: Readings
) -> Commands:
    """The drives' own commands where they act on their own."""
    if not state.alone:
        return obeyed
    powered = wiring.link.mains or wiring.link.reserve
    return fail_safe.commands(wiring.watchdog, state, powered, reported.head_mm, reported.cam_rad)


@compiled
def command_drives(
    wiring: Wiring, between: Between, now: Exchange, dt_s: float
) -> tuple[Commands, Passed]:
    """Commands that the drives obey, on their own where no new ones come, and what is left."""
    wires, outputs, runs = wiring.link, now.outputs, wiring.link.controller_runs
    before = between.linked
    sent = Message(outputs.commands, wanted(outputs), now.tick if runs else SILENT)
    message, heard = link.receive_message(wires, before.link, sent, between.past, now.tick)
    alone = fail_safe.step(
        wiring.watchdog, before.watchdog, heard, wires.mains, now.reported.head_mm, dt_s
    )
    lines = Lines(
        heard=heard,
        wanted=message.wanted,
        reset=now.reset and runs,
        alone=alone.alone,
        mains=wires.mains,
        lag_s=(now.tick - message.number) * dt_s,
    )
    shown = fail_safe.step_annunciator(before.annunciator, lines, dt_s)
    linked = LinkedState(LinkState(now.readings, message), alone, shown, outputs)
    obeyed = _decide_alone(wiring, alone, message.commands, now.reported)
    return obeyed, Passed(now.reported, sent, linked)


@compiled
def recall(wires: Link, messages: Messages, tick: int) -> Between:
    """State between the two sides as a tick begins."""
    linked: LinkedState = read_link(messages.state)
    past = link.recall(wires, messages.got, messages.sent, messages.shown, tick)
    return Between(linked, past)


@compiled
def keep(messages: Messages, passed: Passed | None, tick: int) -> None:
    """Keep what a tick left. messages: written."""
    if passed is not None:
        link.keep(passed.reported, passed.sent, messages.got, messages.sent, messages.shown, tick)
        write_link(messages.state, passed.linked)


def start(reading: Readings, tick: int) -> Messages:
    """Messages of a link that has always carried these readings and no command.

    tick: the first one that it plays.
    """
    last = np.zeros(len(row.columns(LinkedState)))
    message = _begin_link(last, reading, tick)
    return Messages(*link.rings(LinkState(reading, message)), last)


@compiled
def _begin_link(last: row.Row, reading: Readings, tick: int) -> Message:
    """Write the state of a link before anything was commanded; returns its empty message."""
    blank: LinkedState = read_link(last)
    message = blank.link.message._replace(number=tick - 1)
    write_link(last, blank._replace(link=LinkState(reading, message)))
    return message


@compiled
def release_drives(last: row.Row) -> None:
    """A controller has started anew: the drives obey it. last: of `Messages`, written."""
    linked: LinkedState = read_link(last)
    write_link(last, linked._replace(watchdog=fail_safe.LISTENING))
