"""Machines of a campaign: drawn, identified, taught and planned; their cycles without fault.

Until its first fault comes a cycle is that of the sound machine. So this is played once, with the
loop's state kept at marks: a cycle with faults begins at the last mark before them.

The same cycle without a fault: when its phases come, and what its machine does when.

From it follow a fault's instants, and for how long a fault had a chance to show.

Instant and strength of a fault, by shares of a span of the sound cycle and of its own range.
"""

import math
from enum import Enum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import DT_S, LoopState
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun, RowBuffer
from opensuction.simulation.injection.injection import LIMIT_S
from opensuction.simulation.injection.invariant import Holds
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.machine import Machine

AIRWAY = "airway"
"""The time for which the tip is in the airway, and `BEFORE_S` more."""
BEFORE_S = 1.0
"""A fault this long before the tip comes in still meets it."""
MOVING_MM_PER_S = 0.5
"""[assumed] A slower head shows nothing that a sensor could tell from rest."""
SMOOTHED_S = 0.02
OPEN_RATIO = 0.95
"""[assumed] A valve this far open draws as one that is open."""
INSERTING = Phase.INSERTING.name.lower()
COLUMNS = (
    "time_s",
    "phase",
    "truth.tip_mm",
    "truth.head_mm",
    "truth.valve_open_ratio",
    "truth.contact_n",
)
"""What is looked at."""


class Shows(Enum):
    """While what a machine does a fault can show: its clock stands still in other ticks.

    Reckoned on the same cycle without the fault, so that nothing which the fault does delays it.
    """

    ALWAYS = "always"
    MOVING = "moving"
    """While the head moves: a head at rest can neither stall nor go astray."""
    OPEN = "open"
    """While the suction valve stands open: the line tells nothing before its stroke is done."""


class HealthyCycle(NamedTuple):
    """A cycle in which nothing is wrong."""

    spans: dict[str, tuple[float, float]]
    """Begin and end of each phase by name, and of the time in the airway where there is any."""
    moving: Holds
    """In which ticks the head moves."""
    open: Holds
    """In which ticks the valve stands open, for suction."""


def of(machine: Machine, columns: Columns) -> HealthyCycle:
    """Data of a cycle that was played; columns: at least `COLUMNS`."""
    spans = {
        span.phase.name.lower(): (span.start_s, span.end_s) for span in trace.phase_spans(columns)
    }
    inside = np.flatnonzero(exposure.find_inside(machine, columns["truth.tip_mm"]))
    touched = np.flatnonzero(columns["truth.contact_n"] > exposure.TOUCHING_N)
    if touched.size and INSERTING in spans:  # what comes after the touch meets no insertion
        spans[INSERTING] = (spans[INSERTING][0], float(touched[0]) * DT_S)
    if inside.size:
        spans[AIRWAY] = (inside[0] * DT_S - BEFORE_S, inside[-1] * DT_S)
    testing = columns["phase"] == Phase.CHECKING
    ticks = round(SMOOTHED_S / DT_S)
    head = columns["truth.head_mm"]
    travel = np.abs(head - np.concatenate((np.full(ticks, head[0]), head[:-ticks])))
    return HealthyCycle(
        spans=spans,
        moving=travel > MOVING_MM_PER_S * SMOOTHED_S,
        open=(columns["truth.valve_open_ratio"] >= OPEN_RATIO) & ~testing,
    )


def find_wait_s(cycle: HealthyCycle, shows: Shows, at_s: float, needed_s: float) -> float:
    """For how long a fault at an instant cannot have shown, on top of the time that it needs.

    needed_s: how long what it shows in must last. After the cycle there is nothing to wait for.
    """
    if shows == Shows.ALWAYS:
        return 0.0
    shown = cycle.moving if shows == Shows.MOVING else cycle.open
    later = shown[round(at_s / DT_S) :]
    needed = max(math.ceil(needed_s / DT_S), 1)
    counted = np.cumsum(later)
    if not counted.size or counted[-1] < needed:
        shown_s = 0.0 if not counted.size else float(counted[-1]) * DT_S
        return later.size * DT_S - shown_s
    return float(np.searchsorted(counted, needed) + 1) * DT_S - needed * DT_S


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
    loop, start = resolution.give(prepared.loop, prepared.start, oxygen)
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
    healthy = of(prepared.rig.machine, going.columns)
    if AIRWAY not in healthy.spans:
        raise InputError("the cycle is broken off without a fault before the tip is inside")
    return SoundMachine(prepared, healthy, room.copy(going.done), tuple(marks))


def find_mark(machine: SoundMachine, before_tick: int) -> LoopState:
    """The last mark that is no later than a tick."""
    return max(
        (mark for mark in machine.marks if mark.tick <= before_tick), key=lambda mark: mark.tick
    )


EDGE_S = 0.002
"""How far from an edge of a span an instant at this edge lies: within it, and not on it."""


def find_time_s(cycle: HealthyCycle, span: str, share: float) -> float:
    """The instant at a share of a span, 0 to 1, in whole ticks from the start."""
    first_s, last_s = cycle.spans[span]
    return round(first_s + EDGE_S + share * max(last_s - first_s - 2.0 * EDGE_S, 0.0), 3)


def find_instant(cycle: HealthyCycle, span: str, share: float) -> FaultInstant:
    """As `find_time_s`, written as the command line does: from the begin of its phase."""
    at_s = find_time_s(cycle, span, share)
    phases = {name: one for name, one in cycle.spans.items() if name != AIRWAY}
    name = max(
        (name for name, (begin_s, _) in phases.items() if begin_s <= at_s),
        key=lambda name: phases[name][0],
    )
    if name == Phase.PARKED.name.lower():
        return FaultInstant(None, at_s)
    return FaultInstant(Phase[name.upper()], round(at_s - phases[name][0], 3))


def find_strength(fault: Fault, share: float) -> float:
    """Anywhere in the fault's range; by ratio where it spans more than a factor of ten."""
    strength = ROWS[fault].strength
    if strength is None:
        return 0.0
    if strength.least > 0.0 and strength.most > 10.0 * strength.least:
        ratio = math.log(strength.most / strength.least)
        return min(strength.least * math.exp(share * ratio), strength.most)
    return min(strength.least + share * (strength.most - strength.least), strength.most)
