"""Faults to inject: kind, instant and strength.

The machine with the faults that it has at an instant, and when the next of them changes.

A machine and its link with the faults that have come so far: what a run has before its commands.

Whoever plays the machine asks when the next change is due, and makes it then: a simulated run, and
the twin that plays in real time. Ticks are those of whoever plays it, counted from the begin of its
run; what the tick itself must know of (`link`, sensors) goes by the machine's own.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Readings
from opensuction.kernel.vocabulary import Phase
from opensuction.simulation.closed_loop import DT_S
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import (
    FaultOnset,
    LinkEffect,
    MachineEffect,
    PatientEffect,
    ReadingEffect,
)
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.fault.link import Link
from opensuction.twin.machine.machine import Machine


class FaultInstant(NamedTuple):
    """Instant at which a fault begins."""

    phase: Phase | None
    """None: reckoned from the start; else from the first tick of that phase."""
    after_s: float

    @property
    def title(self) -> str:
        """As the command line writes it."""
        if self.phase is None:
            return f"@{self.after_s:g}"
        return f"@{self.phase.name.lower()}+{self.after_s:g}"


AT_START = FaultInstant(phase=None, after_s=0.0)


class Injection(NamedTuple):
    """A fault, when it comes and how strong it is."""

    fault: Fault
    at: FaultInstant
    strength: float


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


MAINS = (Fault.POWER_LOST, Fault.POWER_LOST_WITHOUT_RESERVE, Fault.POWER_RETURNING)


class Instant(NamedTuple):
    """Now."""

    done: int
    """Ticks of the run so far."""
    tick: int
    """The machine's own."""


class _Fault(NamedTuple):
    """One that has come."""

    injection: Injection
    at_s: float
    """First tick with it; negative where it came before the run began."""


class FaultySide:
    """Machine and link with the faults of the present."""

    def __init__(self, sound: Machine, wires: Link, seed: int) -> None:
        """A machine and a link without a fault. seed: chance of the sensors' faults."""
        self.sound = sound
        """The machine without its faults."""
        self.machine, self.link = sound, wires
        """As they are now."""
        self.stopped_done = -1
        """When the controller stopped; -1 where it did not."""
        self.restart_done: int | None = None
        """When its successor starts, if one does."""
        self._seed = seed
        self._came: list[_Fault] = []
        self._next_course: dict[int, int] = {}
        """Next tick in which the course of a fault changes the machine, by its place."""

    @property
    def next_done(self) -> int | None:
        """The next tick before which there is something to do; None where there is none known."""
        return min(
            (done for done in (self.restart_done, *self._next_course.values()) if done is not None),
            default=None,
        )

    def inject(self, injection: Injection, now: Instant, readings: Readings) -> None:
        """A fault comes. readings: what the sensors measure now.

        Raises InputError for one of the set-up: it is there before anything is played.
        """
        fault, row = injection.fault, ROWS[injection.fault]
        onset = FaultOnset(injection.strength, now.tick, DT_S)
        if row.is_setup:
            raise InputError(
                f"fault '{fault.title}' is one of the set-up: it is injected before the cycle is "
                "planned"
            )
        self._came.append(_Fault(injection, now.done * DT_S))
        if is_of_machine(fault):
            self._follow(len(self._came) - 1, now.done)
        elif isinstance(row.effect, ReadingEffect):
            sensor = row.change_reading(onset, readings, self._seed)
            self.link = link.with_reading_fault(self.link, sensor)
        elif isinstance(row.effect, LinkEffect):
            ran = self.link.controller_runs
            self.link = row.change_link(self.link, onset)
            if ran and not self.link.controller_runs:
                self.stopped_done = now.done
            self._plan_restart(injection, now.done)

    def follow(self, done: int) -> None:
        """Change the machine as the courses of its faults want it, where one is due."""
        for place in [place for place, due in self._next_course.items() if due <= done]:
            self._follow(place, done)

    def restart(self, done: int) -> None:
        """A controller runs again; where the mains were gone, they are back."""
        self.link = self.link._replace(controller_runs=True, mains=True)
        self.restart_done = None
        self.rebuild(done)

    def rebuild(self, done: int) -> None:
        """Give the sound machine all the faults that it has now, in the order they came in."""
        now_s = done * DT_S
        came = [(one.injection, now_s - one.at_s) for one in self._came]
        came.sort(key=lambda one: -one[1])
        self.machine = break_machine(self.sound, came, self.link.mains)

    def begin_anew(self, passed: int) -> None:
        """Count from here: so many ticks have passed. What was due meanwhile is due at once."""
        self._came = [one._replace(at_s=one.at_s - passed * DT_S) for one in self._came]
        self._next_course = {i: max(at - passed, 0) for i, at in self._next_course.items()}
        self.stopped_done = -1

    def _follow(self, place: int, done: int) -> None:
        """Change the machine as the course of a fault wants it now, and note when it does next."""
        self.rebuild(done)
        self._next_course.pop(place, None)
        injection, at_s = self._came[place]
        left_s = next_change_s(injection, done * DT_S - at_s)
        if math.isfinite(left_s):
            self._next_course[place] = done + max(round(left_s / DT_S), 1)

    def _plan_restart(self, injection: Injection, done: int) -> None:
        """A fault of the link came: when the next controller starts, if one does."""
        fault = injection.fault
        if fault in MAINS:
            self.restart_done = None
            self.rebuild(done)
        stopped = fault == Fault.CONTROLLER_STOPPED and self.link.mains
        if stopped or fault == Fault.POWER_RETURNING:
            self.restart_done = done + round(injection.strength / DT_S)
