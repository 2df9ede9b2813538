"""Every fault that can be injected, one row each; those of drives and suction line in files beside.

Here are those of the patient, ventilator and monitor (the bench has none of them), of the set-up,
of the contact switch, of power, controller and messages.
"""

import math

from opensuction.twin.airway.airway import Airway
from opensuction.twin.fault import drive_fault, suction_fault
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import (
    Course,
    FaultOnset,
    FaultRow,
    LinkEffect,
    MachineEffect,
    ReadingEffect,
    SetupEffect,
    Strength,
    by_turns,
    for_a_tick,
    in_machine,
    in_patient,
    invalid_reading,
    row,
    share,
    turn,
)
from opensuction.twin.fault.link import ALWAYS, MONITOR_TICKS, Link, Turns
from opensuction.twin.fault.reading_fault import Channel, Mode
from opensuction.twin.machine.machine import Machine
from opensuction.twin.machine.tip_sensor import ContactSwitch
from opensuction.twin.patient.patient import L_PER_MIN_PER_ML_PER_S


def _turns(onset: FaultOnset) -> Turns:
    return Turns(onset.ticks, onset.tick)


def _lose_commands(link: Link, share_lost: float, turns: Turns) -> Link:
    return link._replace(command_lost_share=share_lost, command_turns=turns)


def _lose_readings(link: Link, share_lost: float, turns: Turns) -> Link:
    return link._replace(reading_lost_share=share_lost, reading_turns=turns)


def _delay_monitor(link: Link, onset: FaultOnset) -> Link:
    return link._replace(monitor_delay_steps=max(round(onset.ticks / MONITOR_TICKS), 1))


LINK_FAULT_ROWS = {
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


CONTACT_FAULT_ROWS = {
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


SETUP_FAULT_ROWS = {
    Fault.WRONG_PRESET: row(
        "an adult's protocol is set for a neonate",
        SetupEffect(is_planned=True),
        detected_by="the guidelines of the patient's age, before the start",
    ),
    Fault.CATHETER_TOO_WIDE: row(
        "a catheter is fitted that is too wide for the tube",
        SetupEffect(is_planned=True),
        detected_by="the guideline's ratio, before the start",
    ),
    Fault.CATHETER_EXPIRED: row(
        "the catheter has been used for more than its life",
        SetupEffect(is_planned=False),
        Strength("since its first use", "h", 24.0, 1000.0, 25.0),
        detected_by="its clock, at the request",
    ),
    Fault.TAUGHT_TOO_DEEP: row(
        "the way to the carina was taught longer than it is",
        SetupEffect(is_planned=True),
        Strength("too much", "mm", 1.0, 60.0, 20.0),
        detected_by="the range that is plausible for the age; contact before the window",
    ),
}


COUGH_S = 0.4
"""[assumed] Time from the first to the last pressure of the muscles in one cough."""
COUGH_STEP_S = 0.01
"""The bedside's own step."""
SHORTENING_MM_PER_CMH2O = 0.15
"""[assumed] The trachea shortens by about a centimetre in a cough: 9 mm at 60 cmH2O."""


def _cough_share(_peak_cmh2o: float, since_s: float) -> float:
    """A pulse that rises and falls smoothly, at the middle of a step."""
    return math.sin(math.pi * (since_s + 0.5 * COUGH_STEP_S) / COUGH_S) ** 2


def _cough(machine: Machine, pressure_cmh2o: float) -> Machine:
    """Muscles that press on the lung are a lung that would rest at a smaller volume."""
    lung, airway = machine.patient.lung, machine.airway
    pressed = lung._replace(
        relaxed_ml=lung.relaxed_ml - lung.compliance_ml_per_cmh2o * pressure_cmh2o
    )
    nearer_mm = SHORTENING_MM_PER_CMH2O * pressure_cmh2o
    return machine._replace(
        patient=machine.patient._replace(lung=pressed),
        airway=airway._replace(carina_mm=airway.carina_mm - nearer_mm),
    )


def _decannulate(machine: Machine, out_mm: float) -> Machine:
    """The catheter comes with the tube, so that its tip is so much higher in the airway."""
    conduit, bed = machine.transmission, machine.patient
    return machine._replace(
        transmission=conduit._replace(offset_mm=conduit.offset_mm - out_mm),
        patient=bed._replace(ventilator=bed.ventilator._replace(connected=False)),
    )


PATIENT_FAULT_ROWS = {
    Fault.CIRCUIT_DISCONNECTED: row(
        "the breathing circuit has come off the tube",
        in_patient("ventilator", lambda ventilator, _: ventilator._replace(connected=False)),
        detected_by="pressure at the connector on the patient monitor",
    ),
    Fault.VENTILATOR_PRESSURE: row(
        "the ventilator gives a multiple of the pressures it is set to",
        in_patient(
            "ventilator", lambda ventilator, ratio: ventilator._replace(pressure_ratio=ratio)
        ),
        Strength("of the pressures it is set to", "1", 0.0, 4.0, 3.0),
        detected_by="pressure at the connector on the patient monitor",
    ),
    Fault.DESATURATION: row(
        "blood passes the lung without oxygen",
        in_patient("gas_exchange", lambda gas, shunt: gas._replace(shunt=shunt)),
        Strength("share of the blood that does", "1", 0.3, 0.9, 0.7),
        detected_by="saturation on the patient monitor, late",
    ),
    Fault.BRADYCARDIA: row(
        "the heart slows when the airway is touched",
        in_patient("heart", lambda heart, ratio: heart._replace(vagal_ratio=ratio)),
        Strength("share of the rate that the strongest stimulus takes", "1", 0.5, 0.9, 0.8),
        detected_by="heart rate on the patient monitor",
    ),
    Fault.LUNG_VOLUME_LOST: row(
        "the ventilator makes up for less gas than suction takes",
        in_patient(
            "ventilator",
            lambda ventilator, l_per_min: ventilator._replace(
                compensation_ml_per_s=l_per_min / L_PER_MIN_PER_ML_PER_S
            ),
        ),
        Strength("flow that it makes up for", "L/min", 0.0, 30.0, 0.0),
        detected_by="pressure at the connector on the patient monitor",
    ),
    Fault.MONITOR_LOST: row(
        "nothing of the patient monitor arrives",
        in_patient("monitor", lambda monitor, _: monitor._replace(linked=False)),
        detected_by="the link's own silence",
    ),
    Fault.COUGH: row(
        "the patient coughs: pressure in the lung, and the trachea shortens for a moment",
        MachineEffect(_cough),
        Strength("peak pressure of the muscles", "cmH2O", 5.0, 150.0, 60.0),
        detected_by="pressure at the connector on the patient monitor",
        course=Course(lambda _: COUGH_STEP_S, _cough_share, COUGH_S),
    ),
    Fault.DECANNULATION: row(
        "the tube comes out of the stoma with the circuit, which now blows into the room",
        MachineEffect(_decannulate),
        Strength("how far it comes out", "mm", 10.0, 200.0, 120.0),
        detected_by="pressure at the connector on the patient monitor",
    ),
}


ROWS: dict[Fault, FaultRow] = {
    fault: part(fault)
    for rows in (
        CONTACT_FAULT_ROWS,
        drive_fault.ROWS,
        drive_fault.VALVE_FAULT_ROWS,
        suction_fault.ROWS,
        LINK_FAULT_ROWS,
        PATIENT_FAULT_ROWS,
        SETUP_FAULT_ROWS,
    )
    for fault, part in rows.items()
}
"""Rows by fault. Their order counts: campaigns draw a fault by its place here."""
