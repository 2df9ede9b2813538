"""Row of a fault: the part that is broken, its range of strength, its effects, its detectors.

Strengths are [assumed] where no source is given: ranges run from what does nothing much to what no
machine survives, defaults are strong enough to matter.

Course of a fault in time: permanent, for one tick, in turns, or in steps of its own.

A fault of a sensor or of the link has its duration among its parameters, and each tick asks whether
it is present. A fault of machine or patient has a course, which a run follows in steps: the twin's
tick knows nothing of it.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Readings
from opensuction.twin.fault import reading_fault
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.link import Link
from opensuction.twin.fault.reading_fault import Channel, Mode, ReadingFault, Spell
from opensuction.twin.machine.machine import Machine
from opensuction.twin.patient.patient import Patient


class FaultOnset(NamedTuple):
    """Strength of a fault of the link or of a sensor, and the tick at which it begins."""

    strength: float
    tick: int
    dt_s: float

    @property
    def ticks(self) -> int:
        """A strength in seconds, in ticks."""
        return round(self.strength / self.dt_s)


def for_good(onset: FaultOnset) -> Spell:
    """It does not go away."""
    return Spell(onset.tick)


def for_a_tick(onset: FaultOnset) -> Spell:
    """One sample is wrong."""
    return Spell(onset.tick, there=1)


def by_turns(onset: FaultOnset) -> Spell:
    """It is there for its strength in seconds, away for as long, and so on."""
    return Spell(onset.tick, onset.ticks, 2 * onset.ticks)


def lasting(seconds: float) -> Callable[[FaultOnset], Spell]:
    """It is there for so long, once."""
    return lambda onset: Spell(onset.tick, round(seconds / onset.dt_s))


def by_turns_of(seconds: float) -> Callable[[FaultOnset], Spell]:
    """It is there for so long, away for as long, and so on."""
    return lambda onset: by_turns(onset._replace(strength=seconds))


class Course(NamedTuple):
    """Course of a fault of machine or patient in time; a run follows it in steps."""

    step_s: Callable[[float], float]
    """Time between two changes, from the strength."""
    share: Callable[[float, float], float]
    """Share of the strength that acts, from the strength and the time since the instant; 0: none
    of the fault is there."""
    lasts_s: float
    """When it is over."""


BY_TURNS = Course(
    step_s=lambda turn_s: turn_s,
    share=lambda turn_s, since_s: 1.0 - round(since_s / turn_s) % 2,
    lasts_s=math.inf,
)
"""There for its strength in seconds, away for as long, and so on."""


class Strength(NamedTuple):
    """Strength of a fault: its meaning and range."""

    meaning: str
    unit: str
    """``1`` for a share or ratio."""
    least: float
    most: float
    default: float


def share(meaning: str, default: float, least: float = 0.01, most: float = 1.0) -> Strength:
    """A strength that is a share."""
    return Strength(meaning, "1", least, most, default)


class MachineEffect(NamedTuple):
    """The machine goes on with other parameters.

    A run swaps the record at the instant; nothing of the twin's tick knows of faults. What a fault
    changes in the state, such as a slide that stops, follows from the parameters in the next tick.
    """

    change: Callable[[Machine, float], Machine]
    """From a machine and the strength to the machine with the fault; other faults of it stay."""


class PatientEffect(NamedTuple):
    """The patient, or what stands at the bed, goes on with other parameters."""

    change: Callable[[Patient, float], Patient]
    """From a patient and the strength to the patient with the fault."""


Change = Callable[[Any, float], Any]
"""From a part of machine or patient and the strength to that part with the fault."""


def _exchange(whole: Any, part: str, change: Change, strength: float) -> Any:
    return whole._replace(**{part: change(getattr(whole, part), strength)})


def in_machine(part: str, change: Change) -> MachineEffect:
    """One part of the machine goes on with other parameters. part: a field of `Machine`."""
    return MachineEffect(lambda machine, strength: _exchange(machine, part, change, strength))


def in_patient(part: str, change: Change) -> PatientEffect:
    """One part of the patient does. part: a field of `Patient`."""
    return PatientEffect(lambda patient, strength: _exchange(patient, part, change, strength))


class ReadingEffect(NamedTuple):
    """A reading changes on its way to the controller; what it measures does not."""

    channel: Channel
    mode: Mode
    factor: float | None = None
    """For `Mode.SCALED`; None where it is 1 less the strength."""
    spell: Callable[[FaultOnset], Spell] = for_good


class LinkEffect(NamedTuple):
    """Power, the controller or the messages between it and the drives fail."""

    change: Callable[[Link, FaultOnset], Link]
    """From a link to the link with the fault."""


class SetupEffect(NamedTuple):
    """The machine was set up wrongly; the session that sets up a run does it."""

    is_planned: bool
    """Whether it is there before the cycle is planned, or only when it is requested."""


Effect = MachineEffect | PatientEffect | ReadingEffect | LinkEffect | SetupEffect


class FaultRow(NamedTuple):
    """A fault that can be injected."""

    fault: Fault
    meaning: str
    """In one sentence: what is broken, and what that does."""
    effect: Effect
    strength: Strength | None
    """None where there is no more or less of it."""
    detected_by: str
    """What can detect it; empty where nothing in this machine can while it is the only fault."""
    course: Course | None = None
    """None where it stays as it came."""

    @property
    def default_strength(self) -> float:
        """Strength where none is given; 0 for a fault without one."""
        return 0.0 if self.strength is None else self.strength.default

    @property
    def is_linked(self) -> bool:
        """True where it lies between controller and machine."""
        return isinstance(self.effect, ReadingEffect | LinkEffect)

    @property
    def is_setup(self) -> bool:
        """True where it can only be there from the start."""
        return isinstance(self.effect, SetupEffect)

    @property
    def is_planned(self) -> bool:
        """True where it is there before the cycle is planned."""
        return isinstance(self.effect, SetupEffect) and self.effect.is_planned

    def check_strength(self, strength: float) -> None:
        """Refuse a strength that the fault cannot have; raises InputError."""
        name, known = self.fault.title, self.strength
        if known is None:
            if strength != 0.0:
                raise InputError(f"fault '{name}' has no strength: leave '={strength:g}' out")
            return
        if not known.least <= strength <= known.most:
            unit = "" if known.unit == "1" else f" {known.unit}"
            raise InputError(
                f"fault '{name}' has no strength {strength:g}{unit} ({known.meaning}): "
                f"{known.least:g} to {known.most:g}{unit}"
            )

    def change_machine(self, machine: Machine, strength: float, since_s: float = 0.0) -> Machine:
        """The same machine with the fault; nothing of a machine with other faults is undone.

        since_s: time since its instant, for a fault with a course. Raises InputError for a
        strength out of range, TypeError where the fault changes neither machine nor patient.
        """
        self.check_strength(strength)
        if self.course is not None:
            share = self.course.share(strength, since_s) if since_s < self.course.lasts_s else 0.0
            if share == 0.0:
                return machine
            strength *= share
        if isinstance(self.effect, MachineEffect):
            return self.effect.change(machine, strength)
        if isinstance(self.effect, PatientEffect):
            return machine._replace(patient=self.effect.change(machine.patient, strength))
        raise TypeError(f"fault '{self.fault.title}' does not change the machine")

    def change_reading(self, onset: FaultOnset, readings: Readings, seed: int) -> ReadingFault:
        """The fault of a sensor that begins with these readings.

        seed: its chance. Raises TypeError where the fault changes no reading.
        """
        if not isinstance(self.effect, ReadingEffect):
            raise TypeError(f"fault '{self.fault.title}' does not change a reading")
        channel, mode, factor, spell = self.effect
        strength = onset.strength
        if mode == Mode.SCALED:
            strength = 1.0 - strength if factor is None else factor
        elif mode == Mode.DRIFTING:
            strength *= onset.dt_s
        source = reading_fault.chance(seed, self.fault)
        return reading_fault.begin(channel, mode, strength, readings, spell(onset), source)

    def change_link(self, link: Link, onset: FaultOnset) -> Link:
        """The same link with the fault. Raises TypeError where the fault does not change it."""
        if not isinstance(self.effect, LinkEffect):
            raise TypeError(f"fault '{self.fault.title}' does not change the link")
        return self.effect.change(link, onset)


Part = Callable[[Fault], FaultRow]
"""A row but for its fault: that is its key in the table."""


def row(
    meaning: str,
    effect: Effect,
    strength: Strength | None = None,
    detected_by: str = "",
    course: Course | None = None,
) -> Part:
    """The row of the fault that is its key; see `FaultRow`."""
    return lambda fault: FaultRow(fault, meaning, effect, strength, detected_by, course)


def frozen_reading(channel: Channel, value: str, detected_by: str) -> Part:
    """The fault of a sensor whose value stays what it was. value: how it is called."""
    effect = ReadingEffect(channel, Mode.SCALED, factor=0.0)
    return row(f"{value} no longer changes", effect, detected_by=detected_by)


def invalid_reading(channel: Channel, sensor: str) -> Part:
    """The fault of a sensor whose readings are flagged as not valid. sensor: with its article."""
    effect = ReadingEffect(channel, Mode.INVALID)
    return row(f"{sensor} gives no valid reading", effect, detected_by="its flag")


def glitch(channel: Channel, value: str, strength: Strength, detected_by: str = "") -> Part:
    """The fault of a sensor of which one sample is wrong. value: how it is called."""
    effect = ReadingEffect(channel, Mode.OFFSET, spell=for_a_tick)
    return row(f"{value} is wrong for one tick", effect, strength, detected_by)


def drifting(channel: Channel, value: str, strength: Strength, detected_by: str) -> Part:
    """The fault of a sensor that moves away from the truth at one rate."""
    effect = ReadingEffect(channel, Mode.DRIFTING)
    return row(f"{value} drifts away from the truth", effect, strength, detected_by)


def turn(default_s: float, least_s: float = 0.001) -> Strength:
    """The strength of what comes and goes by turns. default_s, least_s: length of a turn."""
    return Strength("how long it is there, and then away", "s", least_s, 10.0, default_s)


def intermittent_reading(channel: Channel, sensor: str, detected_by: str) -> Part:
    """The fault of a sensor whose readings are not valid by turns. sensor: with its article."""
    effect = ReadingEffect(channel, Mode.INVALID, spell=by_turns)
    return row(f"{sensor} gives no valid reading by turns", effect, turn(0.05), detected_by)
