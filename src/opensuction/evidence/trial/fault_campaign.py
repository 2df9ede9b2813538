"""Many cycles with random single and double faults: which invariants and bounds were broken.

A pool of drawn machines and patients, both approaches, is prepared once; each cycle draws one of
them, its faults, their strengths and instants from the cycle's own number, so that any cycle can
be played again alone and any part of a campaign on its own. A fault comes while it matters: the tip
is in the airway, or will be within a second. What it did to the patient is the oracle's to judge.
"""

import math
from contextlib import suppress
from functools import lru_cache
from typing import NamedTuple

from opensuction.evidence import healthy_cycle
from opensuction.evidence.healthy_cycle import AIRWAY, HealthyCycle
from opensuction.kernel import random_stream
from opensuction.kernel.errors import InputError
from opensuction.oracle.harm import Harm
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection, invariant, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.invariant import Breach
from opensuction.simulation.injection.room import Room
from opensuction.simulation.injection.run_judgement import LeftInside
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
REDRAWN = 3
"""How often a machine of a pool is drawn anew: one of 200 cannot do its protocol."""
WATCHED_S = 60.0
"""How long machine and patient are watched once the machine rests: no bound is longer."""

FAULTS = tuple(fault for fault, row in ROWS.items() if not row.is_setup)
"""Whatever can happen to a running machine."""
JUDGED = tuple(dict.fromkeys((*invariant.JUDGED, *run_judgement.COLUMNS)))
"""Columns that are looked at."""


class DrawnFault(NamedTuple):
    """A fault of a cycle, as it is drawn."""

    fault: Fault
    strength: float
    share: float
    """When it comes, as a share of the time in the airway and the second before, 0 to 1."""


class Drawn(NamedTuple):
    """What one cycle of a campaign is."""

    number: int
    machine: int
    """Index into the pool."""
    faults: tuple[DrawnFault, ...]


class Case(NamedTuple):
    """What became of it."""

    drawn: Drawn
    injections: tuple[Injection, ...]
    """Its faults with their instants."""
    faults: tuple[Fault, ...]
    """Those whose instant came."""
    told: bool
    """Whether people were told of anything from the first of them on."""
    commands: tuple[Breach, ...]
    breaches: tuple[Harm, ...]
    """Bounds of the patient that were broken, but for what the faults make unavoidable."""
    left_inside: LeftInside | None
    """None where the tip is out."""


KINDS = [(*pair, approach) for pair in BASKET for approach in APPROACHES]
"""Protocol, patient and approach of the machines of a pool, in turn."""


def prepare(index: int, first_seed: int, compensation: str) -> Prepared:
    """The machine at that index of a pool, prepared for a cycle."""
    protocol, patient, approach = KINDS[index % len(KINDS)]
    rig = RigChoice(patient=patient, seed=first_seed + index)
    choice = CycleChoice(rig, protocol, approach, compensation)
    return cycle_run.prepare(resolution.resolve(choice))


def _prepare_able(index: int, machines: int, first_seed: int, compensation: str) -> Prepared:
    for again in range(REDRAWN):
        with suppress(InputError):
            return prepare(index, first_seed + again * machines, compensation)
    return prepare(index, first_seed + REDRAWN * machines, compensation)


def pool(machines: int, first_seed: int, compensation: str) -> list[Prepared]:
    """Drawn machines, each prepared for a cycle; the basket and both approaches in turn.

    One that cannot do its protocol makes room for the next: its way out is too slow for the time
    that a small patient leaves. Raises InputError where several in a row cannot.
    """
    return [_prepare_able(index, machines, first_seed, compensation) for index in range(machines)]


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
    uniform = _uniforms(number, 8)
    faults = []
    for i in range(1 + number % 2):
        pick, strong, share = uniform[1 + 3 * i : 4 + 3 * i]
        fault = FAULTS[_pick(pick, len(FAULTS))]
        faults.append(DrawnFault(fault, _strength(fault, strong), share))
    return Drawn(number, _pick(uniform[0], machines), tuple(faults))


def place(drawn: Drawn, healthy: HealthyCycle) -> tuple[Injection, ...]:
    """The faults of a cycle at their instants, which come whatever the first of them has done.

    healthy: the machine's own cycle without any.
    """
    return tuple(
        Injection(
            one.fault,
            FaultInstant(None, healthy_cycle.find_time_s(healthy, AIRWAY, one.share)),
            one.strength,
        )
        for one in drawn.faults
    )


def judged(prepared: Prepared, healthy: HealthyCycle, drawn: Drawn, room: Room) -> Case:
    """Play a drawn cycle and hold its trace against every invariant and bound."""
    injections = place(drawn, healthy)
    run = injection.run(
        prepared.loop, prepared.start, injections, after_s=WATCHED_S, seed=drawn.number, room=room
    )
    settings = prepared.loop.controller
    came = tuple(found for found in run.faults if not math.isnan(found.at_s))
    found = run_judgement.judge(
        prepared.rig.machine, settings.limits.cap_mm, run.columns, run.faults
    )
    from_s = min((one.at_s for one in came), default=0.0)
    return Case(
        drawn=drawn,
        injections=injections,
        faults=tuple(one.injection.fault for one in came),
        told=any(one.at_s >= from_s for one in found.told),
        commands=tuple(invariant.command_side(run.sent, settings)),
        breaches=found.breaches,
        left_inside=found.left_inside,
    )


class Part(NamedTuple):
    """Cycles for one process: numbers from ``first`` to before ``last`` on a pool of machines."""

    machines: int
    first_seed: int
    compensation: str
    first: int
    last: int


@lru_cache(maxsize=1)
def _pool(machines: int, first_seed: int, compensation: str) -> list[tuple[Prepared, HealthyCycle]]:
    """A pool, and of each machine the cycle in which nothing is wrong."""
    prepared = pool(machines, first_seed, compensation)
    return [(one, healthy_cycle.play(one)) for one in prepared]


def played_part(part: Part) -> list[Case]:
    """Cases of a part, in order; a process prepares its pool once."""
    machines = _pool(part.machines, part.first_seed, part.compensation)
    drawn = [draw(number, len(machines)) for number in range(part.first, part.last)]
    room = injection.make_room(WATCHED_S, names=JUDGED)
    return [judged(*machines[one.machine], one, room) for one in drawn]
