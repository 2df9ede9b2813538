"""A part of a trial: the cycles of one machine, for one process."""

import gc
from functools import lru_cache
from typing import NamedTuple

from opensuction.evidence.trial import cohort, draw, judged_cycle, sound_machine
from opensuction.evidence.trial.judged_cycle import Case
from opensuction.evidence.trial.sound_machine import SoundMachine
from opensuction.kernel.errors import InputError
from opensuction.result.trial_result import Trial
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import COLUMNS
from opensuction.simulation.injection.fault_instant import AT_START, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.simulation.injection.row_buffer import RowBuffer
from opensuction.twin.fault.fault import Fault


class Part(NamedTuple):
    """Part of a trial: the cycles of one machine."""

    trial: Trial
    machine: int
    cycles: int
    """Of the whole trial."""


class PlayedPart(NamedTuple):
    """Result of a part that was played."""

    machine: int
    cases: tuple[Case, ...]
    refused: tuple[str, ...]
    """Why machines that were drawn before this one are of no use: a line each."""


@lru_cache(maxsize=1)
def _room() -> RowBuffer:
    """Room of this process for one run after the other.

    What is loaded by then stays: the collector of garbage, which states handed over to compiled
    code call often, need not look through all of it each time (a tenth of a cycle's time).
    """
    gc.freeze()
    return judged_cycle.make_room()


def list_parts(trial: Trial, cycles: int) -> list[Part]:
    """The parts of a trial of so many cycles."""
    return [Part(trial, machine, cycles) for machine in range(draw.count_machines(trial, cycles))]


def check(trial: Trial) -> None:
    """Refuse a trial that cannot be, such as one with an unknown compensation; quick.

    Raises InputError.
    """
    for kind in cohort.list_kinds(trial.cohort):
        rig = RigChoice(patient=kind.patient)
        choice = CycleChoice(rig, approach=kind.approach, compensation=trial.compensation)
        if resolution.resolve(choice).parameter_file is not None:
            raise InputError(
                f"--compensation {trial.compensation}: a trial draws its machines, and a parameter "
                "file is of one of them; name a compensator"
            )


def warm_up(part: Part) -> None:
    """Play a tick of all that a part plays, so that whatever must be compiled is."""
    prepared, _ = sound_machine.find(part.trial, part.machine, lambda prepared: prepared)
    plays: list[tuple[Injection, ...]] = [()]
    if draw.FAULT_COUNTS[part.trial.faults]:
        plays.append((Injection(Fault.CONTROLLER_STOPPED, AT_START, 1.0),))
    for injections in plays:
        FaultyRun(prepared.loop, prepared.start, injections, _room(), seed=0).advance(1)


def play(part: Part) -> PlayedPart:
    """Play the cycles of a part, in order. Raises InputError where there is no such machine."""
    numbers = draw.list_numbers(part.trial, part.machine, part.cycles)
    machine, refused = _find_machine(part.trial, part.machine, _room())
    cases = tuple(_play_one(part.trial, number, machine, _room()).case for number in numbers)
    return PlayedPart(part.machine, cases, refused)


class PlayedCycle(NamedTuple):
    """One cycle, with its run."""

    prepared: Prepared
    run: InjectedRun
    case: Case


def play_again(trial: Trial, number: int) -> PlayedCycle:
    """The cycle of a number alone, with all columns of its run, watched for the longest time."""
    room = judged_cycle.make_room(COLUMNS)
    machine, _ = _find_machine(trial, draw.find_machine(trial, number), room)
    return _play_one(trial, number, machine, room, whole=True)


Machine = Prepared | SoundMachine
"""Ready for its cycle; with its cycle without fault where there will be one with."""


def _find_machine(trial: Trial, machine: int, room: RowBuffer) -> tuple[Machine, tuple[str, ...]]:
    if not draw.FAULT_COUNTS[trial.faults]:
        return sound_machine.find(trial, machine, lambda prepared: prepared)
    return sound_machine.find(trial, machine, lambda one: sound_machine.play(one, room))


def _play_one(
    trial: Trial, number: int, machine: Machine, room: RowBuffer, whole: bool = False
) -> PlayedCycle:
    if isinstance(machine, SoundMachine):
        prepared = machine.prepared
        injections = judged_cycle.place(draw.draw_faults(trial, number), machine.healthy)
        seed = draw.chance_seed(trial, number)
        played = judged_cycle.play_faulty(machine, injections, seed, room, whole)
    else:
        prepared = machine
        played = judged_cycle.play_sound(prepared, room, whole)
    return PlayedCycle(prepared, played.run, judged_cycle.judge(number, prepared, played))
