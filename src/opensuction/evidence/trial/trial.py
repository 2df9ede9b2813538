"""A trial: its parts spread over processes, each kept as soon as it is played.

The parts of a trial on disk: one that was cut off goes on where it was.

A file of lines: the first says which trial it is and of which sources, each other one holds a part.
A line is written when its part is there; one that was cut off in the middle is as if it were not.

A part of a trial: the cycles of one machine, for one process.
"""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypeVar

from pydantic import ConfigDict, TypeAdapter, ValidationError

from opensuction import __version__
from opensuction.evidence import worker_pool
from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import Played
from opensuction.evidence.campaign.sound_machine import SoundMachine
from opensuction.evidence.trial import draw, judged_cycle
from opensuction.evidence.trial.judged_cycle import JUDGED, Case
from opensuction.kernel.compiled import PACKAGE, sources_hash
from opensuction.kernel.errors import InputError
from opensuction.result.plain import to_json
from opensuction.result.trial_result import Trial
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.settings.validation import choose
from opensuction.simulation.closed_loop import COLUMNS
from opensuction.simulation.injection.fault_instant import AT_START, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun, RowBuffer
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


def check_names(trial: Trial) -> None:
    """Refuse unknown names of faults, answer and cohort; raises InputError."""
    choose(trial.faults, draw.FAULT_COUNTS, "--faults")
    choose(trial.preoxygenation, resolution.ANSWERS, "--preoxygenation")
    draw.list_kinds(trial.cohort)


def check(trial: Trial) -> None:
    """Refuse a trial that cannot be, such as one with an unknown compensation; quick.

    Raises InputError.
    """
    check_names(trial)
    for kind in draw.list_kinds(trial.cohort):
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


NAME = "trial-parts.jsonl"
JUDGING_ROOMS = ("oracle", "result", "session", "settings", "evidence")
"""Rooms that decide what a case is, beside the core."""


class Heading(NamedTuple):
    """Heading of a trial's log."""

    version: str
    """Of the software."""
    sources: str
    """Hash of all that decides what a case is."""
    trial: Trial
    cycles: int


class TrialLog(NamedTuple):
    """Content of a trial's log."""

    heading: Heading
    parts: dict[int, PlayedPart]
    """By the number of the machine."""
    size: int
    """Bytes that are whole."""


_HEADING = TypeAdapter(Heading)
_PART = TypeAdapter(PlayedPart, config=ConfigDict(ser_json_inf_nan="constants"))


def hash_sources() -> str:
    """Hash of the core's sources and of those that draw and judge; 16 hexadecimal digits."""
    digest = hashlib.sha256(sources_hash().encode())
    for room in JUDGING_ROOMS:
        for source in sorted((PACKAGE / room).rglob("*.py")):
            digest.update(str(source.relative_to(PACKAGE)).encode() + b"\0")
            digest.update(source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def make_heading(trial: Trial, cycles: int) -> Heading:
    """Heading of a trial by this software."""
    return Heading(__version__, hash_sources(), trial, cycles)


def begin(folder: Path, heading: Heading) -> None:
    """Begin a log in a folder; what another trial has left there is gone. May raise OSError."""
    _write(folder / NAME, json.dumps(to_json(heading)).encode() + b"\n", "wb")


def keep(folder: Path, part: PlayedPart) -> None:
    """Add a part that was played. May raise OSError; what was kept before stays."""
    _write(folder / NAME, _PART.dump_json(part) + b"\n", "ab")


def _write(file: Path, line: bytes, mode: str) -> None:
    try:
        with file.open(mode) as stream:
            stream.write(line)
    except OSError as error:
        # An error while writing has no name: it is about a file that was opened before.
        raise OSError(error.errno, error.strerror, str(file)) from None


def read(folder: Path) -> TrialLog:
    """Trial that a folder keeps. Raises InputError where there is none, or it is damaged."""
    file = folder / NAME
    if not file.is_file():
        raise InputError(
            f"--resume: {folder} holds no trial (no {NAME}); name the folder of one with --out, or "
            "leave --resume out"
        )
    lines = file.read_bytes().splitlines(keepends=True)
    if lines and not lines[-1].endswith(b"\n"):  # its writer was cut off
        lines.pop()
    heading, parts = None, {}
    for number, line in enumerate(lines, start=1):
        try:
            if heading is None:
                heading = _HEADING.validate_json(line)
            else:
                part = _PART.validate_json(line)
                parts[part.machine] = part
        except ValidationError:
            raise InputError(
                f"{file}, line {number}: this is no part of a trial; begin anew in another folder"
            ) from None
    if heading is None:
        raise InputError(f"{file}: the trial has not begun; leave --resume out and add --force")
    return TrialLog(heading, parts, sum(len(line) for line in lines))


def go_on(folder: Path, wanted: Heading) -> dict[int, PlayedPart]:
    """The parts of a trial that goes on, by machine; a line that was cut off is removed.

    Raises InputError where the folder holds another trial, or one by other software.
    """
    found = read(folder)
    for name in Trial._fields:
        old, new = (getattr(heading.trial, name) for heading in (found.heading, wanted))
        if old != new:
            _refuse(folder, name, old, new)
    if found.heading.cycles != wanted.cycles:
        _refuse(folder, "cycles", found.heading.cycles, wanted.cycles)
    if found.heading.sources != wanted.sources:
        raise InputError(
            f"--resume: the trial in {folder} was begun by other sources "
            f"(version {found.heading.version}, {found.heading.sources}; these are version "
            f"{wanted.version}, {wanted.sources}): its cycles would be other cycles; begin anew in "
            "another folder"
        )
    with (folder / NAME).open("rb+") as stream:
        stream.truncate(found.size)
    return found.parts


def _refuse(folder: Path, name: str, old: object, new: object) -> None:
    raise InputError(
        f"--resume: {folder} holds another trial: --{name} {old}, not {new}; leave --{name} out, "
        "or begin anew in another folder"
    )


class Standing(NamedTuple):
    """Progress of a trial."""

    cycles: int
    broken: int
    """Cycles in which something was broken, or said that is not so."""

    def with_part(self, played: PlayedPart) -> "Standing":
        """So far, with one part more."""
        return Standing(
            self.cycles + len(played.cases),
            self.broken + sum(case.is_broken for case in played.cases),
        )


class Listener(NamedTuple):
    """Callbacks on the progress of a trial; called from other threads, one call at a time."""

    tell: Callable[[Standing], None] = lambda _: None
    warn: Callable[[str], None] = lambda _: None
    """Of a process that died."""


NOBODY = Listener()


def list_found(parts: dict[int, PlayedPart]) -> list[PlayedPart]:
    """Parts in the order of their machines."""
    return [parts[machine] for machine in sorted(parts)]


def run(
    folder: Path,
    heading: Heading,
    kept: dict[int, PlayedPart],
    workers: int,
    listener: Listener = NOBODY,
) -> list[PlayedPart]:
    """Play what is left of a trial; all of its parts, in order.

    folder: has a log, which takes each part. kept: what it holds. What is compiled is compiled here
    first, and found by the processes in the cache. Raises OSError where the log cannot be written,
    WorkerLostError where process after process dies; what was kept stays.
    """
    parts = dict(kept)
    todo = [one for one in list_parts(heading.trial, heading.cycles) if one.machine not in parts]
    if not todo:
        return list_found(parts)
    standing = Standing(0, 0)
    for one in kept.values():
        standing = standing.with_part(one)

    def note(_: int, played: PlayedPart) -> None:
        nonlocal standing
        keep(folder, played)
        parts[played.machine] = played
        standing = standing.with_part(played)
        listener.tell(standing)

    warm_up(todo[0])
    listener.tell(standing)
    worker_pool.spread(play, todo, workers, note, listener.warn)
    return list_found(parts)
