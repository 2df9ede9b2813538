"""Many cycles with random single and double faults: which invariants and bounds were broken.

A pool of drawn machines and patients, both approaches, is prepared once; each cycle draws one of
them, its faults, their strengths and instants from the cycle's own number, so that any cycle can
be played again alone and any part of a campaign on its own.
"""

import math
from functools import lru_cache
from typing import NamedTuple

from opensuction.kernel import random_stream
from opensuction.kernel.phase import CYCLE
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection, invariant
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.injection import Room
from opensuction.simulation.injection.invariant import Breach
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

PURPOSE = 71
"""Number of the noise stream of campaigns."""

BASKET = (
    ("adult", "adult-icu"),
    ("adult", "adult-ards"),
    ("paediatric", "child-10kg"),
    ("paediatric", "neonate"),
)
"""Protocols and patients of the pool."""
APPROACHES = ("travel", "contact")
PHASES = CYCLE
"""Phases in which a fault may come; one whose phase never comes is drawn in vain."""
LATEST_S = 8.0
"""A fault comes within so long of its phase's begin: the longest phases last 8 s."""

FAULTS = tuple(fault for fault, row in ROWS.items() if not row.is_setup)
"""Whatever can happen to a running machine."""


class Drawn(NamedTuple):
    """What one cycle of a campaign is."""

    number: int
    machine: int
    """Index into the pool."""
    injections: tuple[Injection, ...]


class Case(NamedTuple):
    """What became of it."""

    drawn: Drawn
    faults: tuple[Fault, ...]
    """Those whose instant came."""
    noticed: bool
    commands: tuple[Breach, ...]
    physical: tuple[Breach, ...]


def pool(machines: int, first_seed: int, compensation: str) -> list[Prepared]:
    """Drawn machines, each prepared for a cycle; the basket and both approaches in turn."""
    kinds = [(*pair, approach) for pair in BASKET for approach in APPROACHES]
    found = []
    for i in range(machines):
        protocol, patient, approach = kinds[i % len(kinds)]
        rig = RigChoice(patient=patient, seed=first_seed + i)
        choice = CycleChoice(rig, protocol, approach, compensation)
        found.append(cycle_run.prepare(resolution.resolve(choice)))
    return found


def _uniforms(number: int, count: int) -> list[float]:
    source = random_stream.stream(number, PURPOSE)
    drawn: list[float] = []
    while len(drawn) < count:
        first, second, source = random_stream.uniform_pair(source)
        drawn += [first, second]
    return drawn


def _strength(fault: Fault, share: float) -> float:
    """Anywhere in the fault's range; by ratio where it spans more than a factor of ten."""
    strength = ROWS[fault].strength
    if strength is None:
        return 0.0
    if strength.least > 0.0 and strength.most > 10.0 * strength.least:
        ratio = math.log(strength.most / strength.least)
        return strength.least * math.exp(share * ratio)
    return strength.least + share * (strength.most - strength.least)


def _pick(share: float, count: int) -> int:
    return min(int(share * count), count - 1)


def draw(number: int, machines: int) -> Drawn:
    """The cycle of that number: even ones have one fault, odd ones two."""
    uniform = _uniforms(number, 10)
    injections = []
    for i in range(1 + number % 2):
        pick, strong, where, when = uniform[1 + 4 * i : 5 + 4 * i]
        fault = FAULTS[_pick(pick, len(FAULTS))]
        at = FaultInstant(PHASES[_pick(where, len(PHASES))], round(LATEST_S * when, 3))
        injections.append(Injection(fault, at, _strength(fault, strong)))
    return Drawn(number, _pick(uniform[0], machines), tuple(injections))


def judged(prepared: Prepared, drawn: Drawn, room: Room) -> Case:
    """Play a drawn cycle and hold its trace against every invariant and bound."""
    run = injection.run(prepared.loop, prepared.start, drawn.injections, room=room)
    settings = prepared.loop.controller
    came = tuple(found for found in run.faults if not math.isnan(found.at_s))
    faults = tuple(found.injection.fault for found in came)
    return Case(
        drawn=drawn,
        faults=faults,
        noticed=any(found.notice is not None for found in came),
        commands=tuple(invariant.command_side(run.sent, settings)),
        physical=tuple(invariant.physical(run.columns, settings, faults)),
    )


class Part(NamedTuple):
    """Cycles for one process: numbers from ``first`` to before ``last`` on a pool of machines."""

    machines: int
    first_seed: int
    compensation: str
    first: int
    last: int


_pool = lru_cache(maxsize=1)(pool)


def played_part(part: Part) -> list[Case]:
    """Cases of a part, in order; a process prepares its pool once."""
    machines = _pool(part.machines, part.first_seed, part.compensation)
    drawn = [draw(number, len(machines)) for number in range(part.first, part.last)]
    room = injection.make_room(names=invariant.JUDGED)
    return [judged(machines[one.machine], one, room) for one in drawn]
