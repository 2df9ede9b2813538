"""Faults of power, controller and messages: of what lies between controller and drives."""

from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import LinkEffect, Strength, row, share, turn
from opensuction.twin.fault.fault_time import FaultOnset
from opensuction.twin.fault.link import ALWAYS, MONITOR_TICKS, Link, Turns


def _turns(onset: FaultOnset) -> Turns:
    return Turns(onset.ticks, onset.tick)


def _lose_commands(link: Link, share_lost: float, turns: Turns) -> Link:
    return link._replace(command_lost_share=share_lost, command_turns=turns)


def _lose_readings(link: Link, share_lost: float, turns: Turns) -> Link:
    return link._replace(reading_lost_share=share_lost, reading_turns=turns)


def _delay_monitor(link: Link, onset: FaultOnset) -> Link:
    return link._replace(monitor_delay_steps=max(round(onset.ticks / MONITOR_TICKS), 1))


ROWS = {
    Fault.POWER_LOST: row(
        "mains power is gone; the drives draw the catheter out on reserve energy",
        LinkEffect(lambda link, _: link._replace(mains=False, controller_runs=False)),
        detected_by="the drives themselves",
    ),
    Fault.POWER_LOST_WITHOUT_RESERVE: row(
        "mains power and reserve energy are gone: no torque, valve shut by its spring, line vented",
        LinkEffect(
            lambda link, _: link._replace(mains=False, reserve=False, controller_runs=False)
        ),
        detected_by="an alarm on a battery of its own",
    ),
    Fault.POWER_RETURNING: row(
        "mains power is gone and comes back, with which a new controller starts",
        LinkEffect(lambda link, _: link._replace(mains=False, controller_runs=False)),
        Strength("time until then", "s", 0.001, 600.0, 5.0),
        detected_by="the drives themselves",
    ),
    Fault.CONTROLLER_STOPPED: row(
        "the controller stops; a new one starts later",
        LinkEffect(lambda link, _: link._replace(controller_runs=False)),
        Strength("time until then", "s", 0.001, 600.0, 10.0),
        detected_by="the drives' own watchdog",
    ),
    Fault.TICK_LATE: row(
        "the controller's ticks end after their deadline",
        LinkEffect(lambda link, onset: link._replace(late_until_tick=onset.tick + onset.ticks)),
        Strength("for how long", "s", 0.001, 60.0, 1.0),
        detected_by="the host's report of each",
    ),
    Fault.MESSAGE_LATE: row(
        "commands reach the drives late",
        LinkEffect(lambda link, onset: link._replace(command_delay_ticks=onset.ticks)),
        Strength("delay", "s", 0.001, 0.06, 0.02),
        detected_by="the drives, over 5 ms; their own watchdog, over 20 ms",
    ),
    Fault.MESSAGE_LOST: row(
        "commands are lost on their way to the drives, which keep the last",
        LinkEffect(lambda link, onset: _lose_commands(link, onset.strength, ALWAYS)),
        share("share that is lost", 1.0),
        detected_by="the drives' own watchdog",
    ),
    Fault.MESSAGE_REPEATED: row(
        "the drives are sent the same old command again and again",
        LinkEffect(lambda link, _: link._replace(commands_repeated=True)),
        detected_by="the drives' own watchdog: its number does not change",
    ),
    Fault.READING_LATE: row(
        "readings reach the controller late",
        LinkEffect(lambda link, onset: link._replace(reading_delay_ticks=onset.ticks)),
        Strength("delay", "s", 0.001, 0.06, 0.02),
    ),
    Fault.READING_LOST: row(
        "readings are lost on their way and come without a valid flag",
        LinkEffect(lambda link, onset: _lose_readings(link, onset.strength, ALWAYS)),
        share("share that is lost", 1.0),
        detected_by="the flags",
    ),
    Fault.READING_REPEATED: row(
        "the controller is sent the same old readings again and again",
        LinkEffect(lambda link, _: link._replace(readings_repeated=True)),
        detected_by="head reading",
    ),
    Fault.MESSAGE_INTERMITTENT: row(
        "commands are lost by turns on their way to the drives, which keep the last",
        LinkEffect(lambda link, onset: _lose_commands(link, 1.0, _turns(onset))),
        turn(0.01),
        detected_by="the drives, where a turn is over 5 ms; their own watchdog, over 20 ms",
    ),
    Fault.READING_INTERMITTENT: row(
        "readings are lost by turns and come without a valid flag",
        LinkEffect(lambda link, onset: _lose_readings(link, 1.0, _turns(onset))),
        turn(0.01),
        detected_by="the flags, from five ticks in a row on",
    ),
    Fault.MONITOR_FROZEN: row(
        "the patient monitor's values no longer change",
        LinkEffect(lambda link, _: link._replace(monitor_frozen=True)),
        detected_by="an airway pressure that no longer breathes",
    ),
    Fault.MONITOR_LATE: row(
        "the patient monitor's values come late",
        LinkEffect(_delay_monitor),
        Strength("delay", "s", 0.01, 20.0, 5.0),
    ),
}
