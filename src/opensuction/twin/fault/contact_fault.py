"""Faults of the contact switch, and of the tip that carries it."""

from opensuction.twin.airway.airway import Airway
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import (
    MachineEffect,
    ReadingEffect,
    Strength,
    in_machine,
    invalid_reading,
    row,
    share,
    turn,
)
from opensuction.twin.fault.fault_time import by_turns, for_a_tick
from opensuction.twin.fault.reading_fault import Channel, Mode
from opensuction.twin.machine.contact_switch import ContactSwitch
from opensuction.twin.machine.machine import Machine

NEVER_N = 1.0e9
"""Force that nothing reaches."""
ALWAYS_S = 1.0e9


def _open_for_good(switch: ContactSwitch, _strength: float = 0.0) -> ContactSwitch:
    return switch._replace(close_n=NEVER_N, open_n=NEVER_N)


def _bounce(switch: ContactSwitch, seconds: float) -> ContactSwitch:
    ratio = max(switch.bounce_open_ratio, 0.5)
    return switch._replace(bounce_s=seconds, bounce_open_ratio=ratio)


def _stiffen(switch: ContactSwitch, close_n: float) -> ContactSwitch:
    return switch._replace(close_n=close_n, open_n=switch.open_n / switch.close_n * close_n)


def _lower_carina(airway: Airway, deeper_mm: float) -> Airway:
    return airway._replace(carina_mm=airway.carina_mm + deeper_mm)


def _soften_tip(airway: Airway, buckling_n: float) -> Airway:
    return airway._replace(tip=airway.tip._replace(buckling_n=buckling_n, post_buckling_ratio=0.0))


def _detach_tip(machine: Machine, length_mm: float) -> Machine:
    conduit = machine.transmission
    shorter = conduit._replace(offset_mm=conduit.offset_mm - length_mm)
    parted = _open_for_good(machine.switch)._replace(wired=False)
    return machine._replace(transmission=shorter, switch=parted)


ROWS = {
    Fault.SWITCH_STUCK_OPEN: row(
        "the contact switch never closes",
        in_machine("switch", _open_for_good),
        detected_by="no contact within the window",
    ),
    Fault.SWITCH_STUCK_CLOSED: row(
        "the contact switch is closed although nothing touches the tip",
        in_machine(
            "switch", lambda switch, _: switch._replace(close_n=-1.0, open_n=-1.0, bounce_s=0.0)
        ),
        detected_by="pre-use test, contact where none can be, contact too long",
    ),
    Fault.SWITCH_BRIDGED: row(
        "mucus bridges the contact switch, which closes now and then without a touch",
        # Pressed for good, and chattering for good: closed in its share of the ticks.
        in_machine(
            "switch",
            lambda switch, closed_share: switch._replace(
                close_n=-1.0, open_n=-1.0, bounce_s=ALWAYS_S, bounce_open_ratio=1.0 - closed_share
            ),
        ),
        share("share of the time for which it is closed", 0.3),
        detected_by="pre-use test, contact where none can be",
    ),
    Fault.SWITCH_STICKING: row(
        "the contact switch closes as it should but does not open again",
        in_machine("switch", lambda switch, _: switch._replace(open_n=-1.0)),
        detected_by="contact too long, pre-use test of the next cycle",
    ),
    Fault.SWITCH_BOUNCING: row(
        "the contact chatters for long after it has closed",
        in_machine("switch", _bounce),
        Strength("how long", "s", 0.001, 10.0, 0.05),
    ),
    Fault.SWITCH_STIFF: row(
        "the contact switch needs more force than it should",
        in_machine("switch", _stiffen),
        Strength("force that closes it", "N", 0.081, 5.0, 0.25),
        detected_by="no contact within the window where the catheter buckles before",
    ),
    Fault.SWITCH_LATE: row(
        "the contact switch is read late",
        in_machine("switch", lambda switch, delay_s: switch._replace(latency_s=delay_s)),
        Strength("delay", "s", 0.001, 0.059, 0.05),
    ),
    Fault.SWITCH_INVALID: invalid_reading(Channel.CONTACT, "the contact switch"),
    Fault.CARINA_MISSED: row(
        "the tip slips past the carina into a bronchus and meets nothing",
        in_machine("airway", _lower_carina),
        Strength("how much deeper the way is free", "mm", 5.0, 100.0, 40.0),
        detected_by="no contact within the window; none by travel, which stops short of the carina",
    ),
    Fault.TUBE_DISPLACED: row(
        "the tube has slid down or the neck is bent: the carina is nearer than was taught",
        in_machine("airway", lambda airway, nearer_mm: _lower_carina(airway, -nearer_mm)),
        Strength("how much nearer", "mm", 1.0, 60.0, 20.0),
        detected_by="contact before the window",
    ),
    Fault.TIP_BUCKLING: row(
        "the tip is so soft that it buckles before the contact switch closes",
        in_machine("airway", _soften_tip),
        Strength("force at which it buckles", "N", 0.005, 0.08, 0.03),
        detected_by="no contact within the window",
    ),
    Fault.TIP_DETACHED: row(
        "the tip has come off with its contact switch, and lies in the airway",
        MachineEffect(_detach_tip),
        Strength("length of the tip", "mm", 1.0, 20.0, 5.0),
        detected_by="the line of its switch",
    ),
    Fault.TIP_LEFT_BEHIND: row(
        "the tip breaks off with its contact switch as the catheter begins to come out, and stays "
        "in the airway",
        in_machine("weak_tip_mm", lambda _, length_mm: length_mm),
        Strength("length of the piece", "mm", 1.0, 60.0, 20.0),
        detected_by="the line of its switch; the light barrier, where the piece is long",
    ),
    Fault.CONTACT_GLITCH: row(
        "the contact switch reads the opposite for one tick",
        ReadingEffect(Channel.CONTACT, Mode.FLIPPED, spell=for_a_tick),
    ),
    Fault.CONTACT_INTERMITTENT: row(
        "a worn contact lets the switch read open by turns, whatever the tip touches",
        ReadingEffect(Channel.CONTACT, Mode.DEAD, spell=by_turns),
        turn(0.05),
        detected_by="no contact within the window where a turn is long",
    ),
}
