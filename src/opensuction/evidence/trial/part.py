"""A part of a trial: the cycles of one machine, for one process."""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import Played
from opensuction.evidence.campaign.sound_machine import SoundMachine
from opensuction.evidence.trial import cohort, draw, judged_cycle
from opensuction.evidence.trial.judged_cycle import JUDGED, Case
from opensuction.kernel.errors import InputError
from opensuction.result.trial_result import Trial
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import COLUMNS
from opensuction.simulation.injection.fault_instant import AT_START, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun
from opensuction.simulation.injection.row_buffer import RowBuffer
from opensuction.twin.fault.fault import Fault

Able = TypeVar("Able")


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
    prepared, _ = find_machine(part.trial, part.machine, lambda prepared: prepared)
    room = played_cycle.share_room(JUDGED)
    plays: list[tuple[Injection, ...]] = [()]
    if draw.FAULT_COUNTS[part.trial.faults]:
        plays.append((Injection(Fault.CONTROLLER_STOPPED, AT_START, 1.0),))
    for injections in plays:
        FaultyRun(prepared.loop, prepared.start, injections, room, seed=0).advance(1)


def play(part: Part) -> PlayedPart:
    """Play the cycles of a part, in order. Raises InputError where there is no such machine."""
    numbers = draw.list_numbers(part.trial, part.machine, part.cycles)
    room = played_cycle.share_room(JUDGED)
    machine, refused = _ready(part.trial, part.machine, room)
    cases = tuple(
        judged_cycle.judge(number, _play_one(part.trial, number, machine, room))
        for number in numbers
    )
    return PlayedPart(part.machine, cases, refused)


def play_again(trial: Trial, number: int) -> Played:
    """The cycle of a number alone, with all columns of its run, watched for the longest time."""
    room = played_cycle.make_room(COLUMNS)
    machine, _ = _ready(trial, draw.find_machine(trial, number), room)
    return _play_one(trial, number, machine, room, whole=True)


def find_machine(
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
            found = make(
                sound_machine.prepare(kind, seed, trial.compensation, trial.preoxygenation)
            )
        except InputError as error:
            if len(refused) + 1 == draw.TRIES:
                raise
            refused.append(f"{kind.patient}, {kind.approach}, seed {seed}: {error}")
        else:
            return found, tuple(refused)


Machine = Prepared | SoundMachine
"""Ready for its cycle; with its cycle without fault where there will be one with."""


def _ready(trial: Trial, machine: int, room: RowBuffer) -> tuple[Machine, tuple[str, ...]]:
    if not draw.FAULT_COUNTS[trial.faults]:
        return find_machine(trial, machine, lambda prepared: prepared)
    return find_machine(trial, machine, lambda one: sound_machine.play(one, room))


def _play_one(
    trial: Trial, number: int, machine: Machine, room: RowBuffer, whole: bool = False
) -> Played:
    if not isinstance(machine, SoundMachine):
        return played_cycle.play_sound(machine, room, whole)
    injections = judged_cycle.place(draw.draw_faults(trial, number), machine.healthy)
    seed = draw.chance_seed(trial, number)
    return played_cycle.play_faulty(machine, injections, seed, room, whole)
