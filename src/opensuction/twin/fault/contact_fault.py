"""Faults of the contact switch, and of the tip that carries it."""

from typing import Any

from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import (
    FaultRow,
    MachineEffect,
    Strength,
    invalid_reading,
    share,
)
from opensuction.twin.fault.reading_fault import Channel
from opensuction.twin.machine.machine import Machine

NEVER_N = 1.0e9
"""Force that nothing reaches."""
ALWAYS_S = 1.0e9


def _with_switch(machine: Machine, **values: Any) -> Machine:
    return machine._replace(switch=machine.switch._replace(**values))


def _bounce(machine: Machine, strength: float) -> Machine:
    ratio = max(machine.switch.bounce_open_ratio, 0.5)
    return _with_switch(machine, bounce_s=strength, bounce_open_ratio=ratio)


def _stiffen(machine: Machine, strength: float) -> Machine:
    ratio = machine.switch.open_n / machine.switch.close_n
    return _with_switch(machine, close_n=strength, open_n=ratio * strength)


def _lower_carina(machine: Machine, strength: float) -> Machine:
    airway = machine.airway
    return machine._replace(airway=airway._replace(carina_mm=airway.carina_mm + strength))


def _soften_tip(machine: Machine, strength: float) -> Machine:
    tip = machine.airway.tip._replace(buckling_n=strength, post_buckling_ratio=0.0)
    return machine._replace(airway=machine.airway._replace(tip=tip))


def _detach_tip(machine: Machine, strength: float) -> Machine:
    conduit = machine.transmission
    shorter = conduit._replace(offset_mm=conduit.offset_mm - strength)
    return _with_switch(machine._replace(transmission=shorter), close_n=NEVER_N, open_n=NEVER_N)


ROWS = (
    FaultRow(
        Fault.SWITCH_STUCK_OPEN,
        "the contact switch never closes",
        MachineEffect(lambda machine, _: _with_switch(machine, close_n=NEVER_N, open_n=NEVER_N)),
        detected_by="no contact within the window",
    ),
    FaultRow(
        Fault.SWITCH_STUCK_CLOSED,
        "the contact switch is closed although nothing touches the tip",
        MachineEffect(
            lambda machine, _: _with_switch(machine, close_n=-1.0, open_n=-1.0, bounce_s=0.0)
        ),
        detected_by="pre-use test, contact where none can be, contact too long",
    ),
    FaultRow(
        Fault.SWITCH_BRIDGED,
        "mucus bridges the contact switch, which closes now and then without a touch",
        # Pressed for good, and chattering for good: closed in its share of the ticks.
        MachineEffect(
            lambda machine, closed_share: _with_switch(
                machine,
                close_n=-1.0,
                open_n=-1.0,
                bounce_s=ALWAYS_S,
                bounce_open_ratio=1.0 - closed_share,
            )
        ),
        share("share of the time for which it is closed", 0.3),
        detected_by="pre-use test, contact where none can be",
    ),
    FaultRow(
        Fault.SWITCH_STICKING,
        "the contact switch closes as it should but does not open again",
        MachineEffect(lambda machine, _: _with_switch(machine, open_n=-1.0)),
        detected_by="contact too long, pre-use test of the next cycle",
    ),
    FaultRow(
        Fault.SWITCH_BOUNCING,
        "the contact chatters for long after it has closed",
        MachineEffect(_bounce),
        Strength("how long", "s", 0.001, 10.0, 0.05),
    ),
    FaultRow(
        Fault.SWITCH_STIFF,
        "the contact switch needs more force than it should",
        MachineEffect(_stiffen),
        Strength("force that closes it", "N", 0.081, 5.0, 0.25),
        detected_by="no contact within the window where the catheter buckles before",
    ),
    FaultRow(
        Fault.SWITCH_LATE,
        "the contact switch is read late",
        MachineEffect(lambda machine, delay_s: _with_switch(machine, latency_s=delay_s)),
        Strength("delay", "s", 0.001, 0.059, 0.05),
    ),
    invalid_reading(Fault.SWITCH_INVALID, Channel.CONTACT, "the contact switch"),
    FaultRow(
        Fault.CARINA_MISSED,
        "the tip slips past the carina into a bronchus and meets nothing",
        MachineEffect(_lower_carina),
        Strength("how much deeper the way is free", "mm", 5.0, 100.0, 40.0),
        detected_by="no contact within the window; none by travel, which stops short of the carina",
    ),
    FaultRow(
        Fault.TUBE_DISPLACED,
        "the tube has slid down or the neck is bent: the carina is nearer than was taught",
        MachineEffect(lambda machine, nearer_mm: _lower_carina(machine, -nearer_mm)),
        Strength("how much nearer", "mm", 1.0, 60.0, 20.0),
        detected_by="contact before the window",
    ),
    FaultRow(
        Fault.TIP_BUCKLING,
        "the tip is so soft that it buckles before the contact switch closes",
        MachineEffect(_soften_tip),
        Strength("force at which it buckles", "N", 0.005, 0.08, 0.03),
        detected_by="no contact within the window",
    ),
    FaultRow(
        Fault.TIP_DETACHED,
        "the tip has come off with its contact switch, and lies in the airway",
        MachineEffect(_detach_tip),
        Strength("length of the tip", "mm", 1.0, 20.0, 5.0),
        detected_by="no contact within the window",
    ),
)
