"""The machine with the faults that it has at an instant, and when the next of them changes."""

import math
from collections.abc import Iterable

from opensuction.simulation.injection.fault_instant import Injection
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import MachineEffect, PatientEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.machine import Machine


def is_of_machine(fault: Fault) -> bool:
    """True for a fault that changes the machine or the patient at it."""
    return isinstance(ROWS[fault].effect, MachineEffect | PatientEffect)


def break_machine(sound: Machine, came: Iterable[tuple[Injection, float]], mains: bool) -> Machine:
    """The machine with all the faults that it has now, one after the other.

    came: each with the time since its instant, s. Those of sensors, link and set-up are left out.
    mains: without them the pump stands still.
    """
    faulty = sound
    for injection, since_s in came:
        if is_of_machine(injection.fault):
            faulty = ROWS[injection.fault].change_machine(faulty, injection.strength, since_s)
    return faulty if mains else ROWS[Fault.PUMP_LOST].change_machine(faulty, 0.0)


def next_change_s(injection: Injection, since_s: float) -> float:
    """Time until the course of a fault changes the machine again; infinite where none does.

    since_s: time since the fault's instant.
    """
    course = ROWS[injection.fault].course
    if course is None or since_s >= course.lasts_s:
        return math.inf
    return course.step_s(injection.strength)
