"""A run of a campaign: from the last mark of its machine's sound cycle to the end of the watch."""

import gc
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from opensuction.evidence.campaign import healthy_cycle, post_cycle_observation, sound_machine
from opensuction.evidence.campaign.sound_machine import SoundMachine
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection, invariant, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun, is_linked
from opensuction.simulation.injection.injection import Injected, InjectedRun
from opensuction.simulation.injection.invariant import Breach
from opensuction.simulation.injection.row_buffer import RowBuffer
from opensuction.simulation.injection.run_judgement import Judgement, PatientAlone
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault

PLAYED = tuple(dict.fromkeys((*run_judgement.COLUMNS, *healthy_cycle.COLUMNS)))
"""Columns without which no run is played."""
JUDGED = tuple(dict.fromkeys((*invariant.JUDGED, *PLAYED)))
"""Columns that are judged."""
LOOKS_BACK_TICKS = link.RING_TICKS + 1
"""For so long a link remembers what passed: it is played that long before it fails."""
LOOKS_BACK_FURTHER = (Fault.MONITOR_LATE,)
"""Faults of a link that hand on what is older: played from the start."""


class Played(NamedTuple):
    """A run, and what came after it."""

    prepared: Prepared
    run: InjectedRun
    watched_s: float
    """How long machine and patient were watched once the machine was at rest."""
    alone: PatientAlone
    """What the patient went through in the rest of the longest watch."""

    @property
    def rested(self) -> int:
        """Tick in which the machine had come to rest."""
        return len(self.run.columns["phase"]) - 1 - round(self.watched_s / DT_S)

    def judge(self) -> Judgement:
        """Hold what the patient bore against every bound."""
        return run_judgement.judge(
            self.prepared.rig.machine,
            self.prepared.loop.controller.limits.cap_mm,
            self.run.columns,
            self.run.faults,
            alone=self.alone,
        )

    def list_command_breaches(self) -> tuple[Breach, ...]:
        """Hold what the controller sent against every invariant."""
        return tuple(invariant.command_side(self.run.sent, self.prepared.loop.controller))


def make_room(names: Sequence[str]) -> RowBuffer:
    """Room for the longest run. names: of the columns that are kept, `PLAYED` among them."""
    return injection.make_room(post_cycle_observation.WATCHED_S, names=names)


@lru_cache(maxsize=2)
def share_room(names: tuple[str, ...]) -> RowBuffer:
    """Room of this process for one run of a campaign after the other.

    What is loaded by then stays: the collector of garbage, which states handed over to compiled
    code call often, need not look through all of it each time (a tenth of a cycle's time).
    """
    gc.freeze()
    return make_room(names)


def _finish(
    prepared: Prepared, going: FaultyRun, injections: Sequence[Injection], whole: bool
) -> Played:
    """Play a run to its end. whole: machine and patient together for the longest time."""
    machine = prepared.rig.machine
    watched_s = post_cycle_observation.watch(going, machine, injections, whole)
    alone = post_cycle_observation.follow_alone(
        going, machine, post_cycle_observation.WATCHED_S - watched_s
    )
    return Played(prepared, injection.take(going, injections), watched_s, alone)


def play_sound(prepared: Prepared, room: RowBuffer, whole: bool = False) -> Played:
    """Play a cycle to which no fault comes. whole: as `_finish`."""
    going = FaultyRun(prepared.loop, prepared.start, (), room, seed=0)
    return _finish(prepared, going, (), whole)


def play_planned(
    prepared: Prepared, planned: Injection, room: RowBuffer, whole: bool = False
) -> Played:
    """Play a cycle that was planned with a fault, which is among those of the run.

    prepared: with it. whole: as `_finish`.
    """
    played = play_sound(prepared, room, whole)
    return played._replace(run=played.run._replace(faults=(Injected(planned, 0.0, None),)))


def _find_tick(machine: SoundMachine, at: FaultInstant, room: RowBuffer) -> int:
    """Tick of an instant in the sound cycle; 0 where its phase does not come there."""
    ticks = round(at.after_s / DT_S)
    if at.phase is None:
        return ticks
    comes = machine.rows[room.names.index("phase")] == at.phase
    return int(np.argmax(comes)) + ticks if comes.any() else 0


def _find_begin(machine: SoundMachine, injections: Sequence[Injection], room: RowBuffer) -> int:
    """From which tick on a cycle with faults must be played."""
    if any(one.fault in LOOKS_BACK_FURTHER for one in injections):
        return 0
    first = min(_find_tick(machine, one.at, room) for one in injections)
    return first - LOOKS_BACK_TICKS if is_linked(injections) else first


def play_faulty(
    machine: SoundMachine,
    injections: Sequence[Injection],
    seed: int,
    room: RowBuffer,
    whole: bool = False,
) -> Played:
    """Play a cycle with faults from the last mark before them.

    seed: their chance. room: of the columns that the machine's own cycle was played in. whole: as
    `_finish`.
    """
    injection.check(injections)
    prepared = machine.prepared
    going = FaultyRun(prepared.loop, prepared.start, injections, room, seed)
    start = prepared.start.tick
    mark = sound_machine.find_mark(machine, start + max(_find_begin(machine, injections, room), 0))
    if mark.tick > start:
        room.fill(machine.rows, mark.tick - start)
        going.begin_at(mark)
    return _finish(prepared, going, injections, whole)
