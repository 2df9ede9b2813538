"""Machines of a campaign: drawn, identified, taught and planned; their cycles without fault.

Until its first fault comes a cycle is that of the sound machine. So this is played once, with the
loop's state kept at marks: a cycle with faults begins at the last mark before them.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.evidence.campaign import healthy_cycle
from opensuction.evidence.campaign.healthy_cycle import AIRWAY, HealthyCycle
from opensuction.kernel.errors import InputError
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, preoxygenation, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S, LoopState
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.simulation.injection.faulty_run import FaultyRun
from opensuction.simulation.injection.injection import LIMIT_S
from opensuction.simulation.injection.row_buffer import RowBuffer
from opensuction.twin.fault.fault_table import ROWS

MARK_S = 0.5
"""Between two marks; to hand a state over costs as much as a few tenths of a second of play."""


class Kind(NamedTuple):
    """A patient's preset, and how the stopping point is found."""

    patient: str
    approach: str


class SoundMachine(NamedTuple):
    """A machine ready for its cycle, and what that is without a fault."""

    prepared: Prepared
    healthy: HealthyCycle
    rows: npt.NDArray[np.float64]
    """Its columns, as `RowBuffer.copy` gives them."""
    marks: tuple[LoopState, ...]
    """Every `MARK_S`, the first one before the start."""


def _write(one: Injection) -> str:
    """The fault of a set-up as a person writes it."""
    title = one.fault.title
    return title if ROWS[one.fault].strength is None else f"{title}={one.strength!r}"


def prepare(
    kind: Kind,
    seed: int,
    compensation: str,
    oxygen: str | None = None,
    planned: Injection | None = None,
    spread: float = 1.0,
) -> Prepared:
    """A machine and a patient of a kind, ready for a cycle.

    oxygen: what a person answers; None: nobody is asked and nothing is given. planned: a fault
    that is there before the cycle is planned. spread: how many times as far as usual both are
    drawn. Raises InputError where the machine cannot do its protocol.
    """
    rig = RigChoice(patient=kind.patient, seed=seed, spread=spread)
    faults = () if planned is None else (_write(planned),)
    choice = CycleChoice(rig, approach=kind.approach, compensation=compensation, faults=faults)
    return oxygenate(cycle_run.prepare(resolution.resolve(choice)), oxygen)


def oxygenate(prepared: Prepared, oxygen: str | None) -> Prepared:
    """The same with pre-oxygenation given, or skipped, where guidelines ask for it."""
    if oxygen is None:
        return prepared
    loop, start = preoxygenation.give(prepared.loop, prepared.start, oxygen)
    return prepared._replace(loop=loop, start=start._replace(tick=0))


def play(prepared: Prepared, room: RowBuffer) -> SoundMachine:
    """Play the cycle without fault. Raises InputError where the tip never comes inside."""
    going = FaultyRun(prepared.loop, prepared.start, (), room, seed=0)
    marks = [going.state]
    active = False
    while not (active and going.is_resting) and going.done < round(LIMIT_S / DT_S):
        going.advance(round(MARK_S / DT_S))
        marks.append(going.state)
        active = active or not going.is_resting
        if not active and going.done >= round(injection.IDLE_S / DT_S):
            break
    healthy = healthy_cycle.of(prepared.rig.machine, going.columns)
    if AIRWAY not in healthy.spans:
        raise InputError("the cycle is broken off without a fault before the tip is inside")
    return SoundMachine(prepared, healthy, room.copy(going.done), tuple(marks))


def find_mark(machine: SoundMachine, before_tick: int) -> LoopState:
    """The last mark that is no later than a tick."""
    return max(
        (mark for mark in machine.marks if mark.tick <= before_tick), key=lambda mark: mark.tick
    )
