"""The machines of a trial: each drawn, identified, taught and planned, and its cycle without fault.

Until its first fault comes a cycle is that of the sound machine. So this is played once, with the
loop's state kept at marks: a cycle with faults begins at the last mark before them.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from opensuction.evidence import healthy_cycle
from opensuction.evidence.healthy_cycle import AIRWAY, HealthyCycle
from opensuction.evidence.trial import draw
from opensuction.evidence.trial.cohort import Kind
from opensuction.kernel.errors import InputError
from opensuction.result.trial_result import Trial
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, preoxygenation, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S, LoopState
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.faulty_run import FaultyRun
from opensuction.simulation.injection.injection import LIMIT_S
from opensuction.simulation.injection.row_buffer import RowBuffer

MARK_S = 0.5
"""Between two marks; to hand a state over costs as much as a few tenths of a second of play."""

Able = TypeVar("Able")


class SoundMachine(NamedTuple):
    """A machine ready for its cycle, and what that is without a fault."""

    prepared: Prepared
    healthy: HealthyCycle
    rows: npt.NDArray[np.float64]
    """Its columns, as `RowBuffer.copy` gives them."""
    marks: tuple[LoopState, ...]
    """Every `MARK_S`, the first one before the start."""


def prepare(
    kind: Kind,
    seed: int,
    compensation: str,
    oxygen: str | None = None,
    faults: tuple[str, ...] = (),
    spread: float = 1.0,
) -> Prepared:
    """A machine and a patient of a kind, ready for a cycle.

    oxygen: what a person answers; None: nobody is asked and nothing is given. faults: that are
    there before the cycle is planned. spread: how many times as far as usual both are drawn.
    Raises InputError where the machine cannot do its protocol.
    """
    rig = RigChoice(patient=kind.patient, seed=seed, spread=spread)
    choice = CycleChoice(rig, approach=kind.approach, compensation=compensation, faults=faults)
    return oxygenate(cycle_run.prepare(resolution.resolve(choice)), oxygen)


def oxygenate(prepared: Prepared, oxygen: str | None) -> Prepared:
    """The same with pre-oxygenation given, or skipped, where guidelines ask for it."""
    if oxygen is None:
        return prepared
    loop, start = preoxygenation.give(prepared.loop, prepared.start, oxygen)
    return prepared._replace(loop=loop, start=start._replace(tick=0))


def find(
    trial: Trial, machine: int, make: Callable[[Prepared], Able]
) -> tuple[Able, tuple[str, ...]]:
    """The machine of a number, and why others that were drawn before it are of no use: a line each.

    One that cannot do its protocol makes room for another: its way out is too slow for the time
    that a small patient leaves. make: what is made of a machine once it is prepared; it may refuse
    one, too. Raises InputError where several in a row are refused.
    """
    refused: list[str] = []
    kind = draw.kind_of(trial, machine)
    while True:
        seed = draw.machine_seed(trial, machine, len(refused))
        try:
            found = make(prepare(kind, seed, trial.compensation, trial.preoxygenation))
        except InputError as error:
            if len(refused) + 1 == draw.TRIES:
                raise
            refused.append(f"{kind.patient}, {kind.approach}, seed {seed}: {error}")
        else:
            return found, tuple(refused)


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
