"""A run of a campaign: from the last mark of its machine's sound cycle to the end of the watch.

Observation after a cycle, until the machine at rest can do nothing new to its patient.

The patient is then followed without the machine: saturation reaches its minimum, and the oximeter
shows it, long after the catheter is out.
"""

import gc
import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from opensuction.evidence.campaign import sound_machine
from opensuction.evidence.campaign.sound_machine import SoundMachine
from opensuction.oracle import exposure
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import AIRWAY_PRESSURE
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import closed_loop, outcome
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import fault_allowance, injection, invariant, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun, RowBuffer, is_linked
from opensuction.simulation.injection.injection import Injected, InjectedRun
from opensuction.simulation.injection.invariant import Breach
from opensuction.simulation.injection.run_judgement import Judgement, PatientAlone
from opensuction.simulation.trace import NOBODY, Columns, Watcher
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import PatientEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.machine import Machine

WATCHED_S = 60.0
"""With the machine, and with the patient alone: no bound of a patient is longer, nor the time in
which a person must be told."""
PIECE_S = 3.0
"""Between two looks whether the machine can still do anything."""
IN_PIECES = Watcher(NOBODY.hear, 5.0)
"""As long as what is written of them fits into a processor's caches."""
STILL_MM = 0.005
"""Way of a head or a tip that stands still, in a piece: 0.1 mm in the longest watch [design]."""


def watch(
    going: FaultyRun, machine: Machine, injections: Sequence[Injection] = (), whole: bool = False
) -> float:
    """Follow a run until its machine rests, and as long as it may do anything; returns that, s.

    machine: as it was built. injections: faults of the run. whole: the longest time in any case.
    """
    injection.follow(going, 0.0, 0, IN_PIECES)
    rested = going.done
    last = rested + round(WATCHED_S / DT_S)
    may_end = not whole and not any(_changes_slowly(one) for one in injections)
    while going.done < last:
        until = min(going.done + round(PIECE_S / DT_S), last)
        while going.done < until:
            going.advance(until - going.done)
        if may_end and going.is_over and is_settled(machine, going.columns, injections):
            break
    return (going.done - rested) * DT_S


def _changes_slowly(one: Injection) -> bool:
    """True for a fault that may do something new after a piece in which it did nothing."""
    course = ROWS[one.fault].course
    return course is not None and 2.0 * course.step_s(one.strength) > PIECE_S


def is_settled(machine: Machine, columns: Columns, injections: Sequence[Injection]) -> bool:
    """True if nothing new came to the patient in the last piece, by the truth.

    The head stood, and so did the tip where it is inside; no vacuum reached the patient, whose
    pressure was as it should be; and whoever must be told had been.

    machine: as it was built. columns: of the run so far.
    """
    piece = _last_piece(columns)
    if not _stands(piece, "head_mm"):  # the most frequent reason, and the quickest to see
        return False
    borne = exposure.measure(machine, piece)
    own = any(
        one.fault == mine.fault and AIRWAY_PRESSURE in one.bounds
        for one in fault_allowance.OWN_HARM
        for mine in injections
    )
    calm = borne.suction_s == 0.0 and (own or borne.pressure_unsafe_s == 0.0)
    stands = not borne.inside_at_end or _stands(piece, "tip_mm")
    return stands and calm and _is_told(piece, borne, injections)


def _stands(piece: Columns, name: str) -> bool:
    return float(np.ptp(piece[f"truth.{name}"])) <= STILL_MM


def _last_piece(columns: Columns) -> Columns:
    ticks = round(PIECE_S / DT_S)
    names = ("truth.head_mm", *exposure.COLUMNS, *outcome.COLUMNS)
    return {name: columns[name][-ticks:] for name in names}


def _is_told(piece: Columns, borne: PatientExposure, injections: Sequence[Injection]) -> bool:
    """True if people are shown what they must be.

    Of a catheter, or a piece of it, that is inside with high priority; of a fault of the patient
    anything.
    """
    told = outcome.told(piece)
    if borne.inside_at_end or borne.piece_mm > 0.0:
        return not math.isnan(run_judgement.told_s(told, -math.inf))
    patient = any(isinstance(ROWS[one.fault].effect, PatientEffect) for one in injections)
    return bool(told) or not patient


def follow_alone(going: FaultyRun, machine: Machine, duration_s: float) -> PatientAlone:
    """Exposure of a patient in a time in which the machine does nothing new.

    going: a run that has been watched. machine: as it was built.
    """
    worst = closed_loop.find_worst(going.loop, going.state, duration_s)
    piece = _last_piece(going.columns)
    inside = exposure.find_inside(machine, piece["truth.tip_mm"])[-1]
    touches = (piece["truth.contact_n"] > exposure.TOUCHING_N).all()
    return PatientAlone(
        spo2_least_percent=worst.spo2_percent,
        lung_volume_loss_ml=worst.lung_volume_loss_ml,
        in_airway_s=duration_s if inside else 0.0,
        contact_s=duration_s if touches else 0.0,
    )


PLAYED = tuple(dict.fromkeys((*run_judgement.COLUMNS, *sound_machine.COLUMNS)))
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
        """Hold what the patient bore against every bound, less what no withdrawal could spare."""
        machine = self.prepared.rig.machine
        judged = run_judgement.judge(
            machine,
            self.prepared.loop.controller.limits.cap_mm,
            self.run.columns,
            self.run.faults,
            alone=self.alone,
        )
        return run_judgement.spare(judged, machine, self.run)

    def list_command_breaches(self) -> tuple[Breach, ...]:
        """Hold what the controller sent against every invariant."""
        return tuple(invariant.command_side(self.run.sent, self.prepared.loop.controller))


def make_room(names: Sequence[str]) -> RowBuffer:
    """Room for the longest run. names: of the columns that are kept, `PLAYED` among them."""
    return injection.make_room(WATCHED_S, names=names)


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
    watched_s = watch(going, machine, injections, whole)
    alone = follow_alone(going, machine, WATCHED_S - watched_s)
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
