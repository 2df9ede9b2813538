"""Faults before the loop at 500 Hz: what the core counts in ticks takes twice as long there.

How many samples decide is counted in ticks (five without a reading, five beyond the command): at
500 Hz the machine goes on for some 5 ms longer until it is told. Whether that breaks a bound which
holds at 1 kHz is asked of every fault that comes in a cycle.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import START, Readings
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.machine.twin.twin_machine import READINGS
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import fault_instant, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.injection import Injected
from opensuction.simulation.injection.run_judgement import Judgement
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineSide
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import FaultOnset, LinkEffect, ReadingEffect
from opensuction.twin.fault.fault_table import ROWS
from tests.runtime.stepped_room import SteppedRoom

LIMIT_S, AFTER_S = 45.0, 6.0
"""Longest cycle, and how long the machine is watched once it rests."""
OF_CONTROLLER = (
    Fault.CONTROLLER_STOPPED,
    Fault.POWER_LOST,
    Fault.POWER_LOST_WITHOUT_RESERVE,
    Fault.POWER_RETURNING,
)
"""After these no loop runs, whatever its period."""
FAULTS = [
    fault
    for fault, row in ROWS.items()
    if fault not in OF_CONTROLLER
    and (fault_instant.is_of_machine(fault) or isinstance(row.effect, ReadingEffect | LinkEffect))
]
INSTANTS = (
    FaultInstant(Phase.INSERTING, 2.0),
    FaultInstant(Phase.BACKING_OFF, 0.05),
    FaultInstant(Phase.SUCTIONING, 0.3),
    FaultInstant(Phase.WITHDRAWING, 0.5),
)


class Course(NamedTuple):
    """A fault as it goes on."""

    sound: MachineSide
    injection: Injection
    began_s: float

    def side(self, room: SteppedRoom, now_s: float) -> MachineSide:
        """What is played now."""
        fault, strength = self.injection.fault, self.injection.strength
        row, wiring = ROWS[fault], self.sound.wiring
        if fault_instant.is_of_machine(fault):
            came = [(self.injection, now_s - self.began_s)]
            broken = fault_instant.break_machine(self.sound.machine, came, mains=True)
            return self.sound._replace(machine=broken)
        shown = room.machine.call.shown_row
        onset = FaultOnset(strength, int(shown[SHOWN_COLUMNS.index("tick")]) + 1, DT_S)
        if isinstance(row.effect, LinkEffect):
            wires = row.change_link(wiring.link, onset)
        else:
            readings = plain_row.unpack(Readings, np.ascontiguousarray(shown[READINGS]))
            sensor = row.change_reading(onset, readings, 0)
            wires = link.with_reading_fault(wiring.link, sensor)
        return self.sound._replace(wiring=wiring._replace(link=wires))

    def next_s(self, now_s: float) -> float:
        """When it changes again."""
        return now_s + fault_instant.next_change_s(self.injection, now_s - self.began_s)


def judge(folder: Path, choice: CycleChoice, injection: Injection, period: int) -> Judgement:
    """A cycle with a fault, judged by the twin's truth. period: of the loop, in machine's ticks."""
    prepared = cycle_run.prepare(resolution.resolve(choice))
    room = SteppedRoom(folder, prepared.loop, prepared.start, period)
    sound = plain_row.unpack(MachineSide, room.machine.call.side_row)
    course, phase_s, due_s, rested_s = None, np.nan, np.inf, 0.0
    room.run(0.3)
    room.step(START)
    while rested_s < AFTER_S and (now_s := len(room.machine.shown) * DT_S) < LIMIT_S + AFTER_S:
        room.step()
        if np.isnan(phase_s) and room.phase() == injection.at.phase:
            phase_s, due_s = now_s, now_s + injection.at.after_s
        if now_s >= due_s:
            course = course or Course(sound, injection, now_s)
            room.machine.call.side_row[:] = plain_row.pack(MachineSide, course.side(room, now_s))
            due_s = course.next_s(now_s)
        rests = room.phase() in RESTING and not np.isnan(phase_s)
        rested_s = rested_s + period * DT_S if rests else 0.0
    room.close()
    assert course is not None, injection
    came = [Injected(injection, course.began_s, None)]
    machine, cap_mm = prepared.loop.machine, prepared.loop.controller.limits.cap_mm
    return run_judgement.judge(machine, cap_mm, room.shown(), came)


def assert_no_more_harm(
    folder: Path, choice: CycleChoice, fault: Fault, at: FaultInstant, strength: float
) -> None:
    """The same bounds are broken at 500 Hz as at 1 kHz, whoever's doing it was; none avoidable."""
    injection = Injection(fault, at, strength)
    full, half = (judge(folder, choice, injection, period) for period in (1, 2))
    assert [one.name for one in half.harm] == [one.name for one in full.harm], injection
    assert half.breaches == (), injection
    assert (half.left_inside is None) == (full.left_inside is None), injection


BY_CONTACT = CycleChoice(
    RigChoice(patient="neonate", seed=5), approach="contact", compensation="preview"
)


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(Fault.MOTOR_REVERSED, marks=pytest.mark.soak),
        pytest.param(Fault.ENCODER_FROZEN, marks=pytest.mark.soak),
        pytest.param(Fault.READING_LOST, marks=pytest.mark.sweep),
    ],
    ids=lambda one: one.name,
)
def test_what_is_told_by_counted_ticks_breaks_no_more_bounds_at_500_hz(
    tmp_path: Path, fault: Fault
) -> None:
    at, strength = FaultInstant(Phase.SUCTIONING, 0.3), ROWS[fault].default_strength
    assert_no_more_harm(tmp_path, BY_CONTACT, fault, at, strength)


@pytest.mark.soak
@pytest.mark.parametrize(
    "choice",
    [
        BY_CONTACT,
        CycleChoice(
            RigChoice(patient="adult-ards", seed=7),
            approach="contact",
            compensation="exact-inverse",
        ),
    ],
    ids=["neonate", "adult"],
)
def test_no_fault_breaks_more_bounds_at_500_hz(tmp_path: Path, choice: CycleChoice) -> None:
    for fault in FAULTS:
        for at in INSTANTS:
            assert_no_more_harm(tmp_path, choice, fault, at, ROWS[fault].default_strength)
