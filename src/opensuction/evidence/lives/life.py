"""One life of a machine: a cycle with its start, its faults and its end, and all that must hold.

The judges are the oracle, by the twin's truth alone, and the records and recordings that are left.
"""

import hashlib
import random
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from opensuction.evidence.lives import life_fault, simulated_machine
from opensuction.evidence.lives.life_fault import ALL, CONTROL, LASTS, TARGETS, Kind, LifeFault
from opensuction.evidence.lives.simulated_computer import MailShares, Step
from opensuction.evidence.lives.simulated_machine import SERIAL, SimulatedMachine
from opensuction.host.host import NS_PER_S
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import RESTING, Phase, name_of
from opensuction.machine.twin.live_judge import Verdict
from opensuction.recording.cycle_file.reader import NothingRecordedError, RecordingReader
from opensuction.records.records import Records
from opensuction.runtime import launch, replay

MACHINES = 1000
"""Machines and patients that lives are drawn from."""
LONGEST_S = 90.0
"""A life that has not settled by then never does."""
SETTLES_S = 3.0
"""So long after the last fault is over a life has settled, where the machine rests and works."""
TOLD_S, EARLY_S = 5.0, 0.1
"""Within this time people are told; the twin's clock is known to the life's within the other."""
ENDS_S = 150.0
"""Within this time all processes end that are told to."""
MAIL = MailShares(lost=0.33, twice=0.33, late=0.33)
TRACE, STEP_BYTES = 16, 10
"""Letters of the hash of a life, and bytes of a step in what it is made from."""


class BrokenInvariant(NamedTuple):
    """Something that must not be."""

    invariant: str
    """One of `INVARIANTS`."""
    detail: str


INVARIANTS = {
    "crash": "no process ends by an error that it does not know",
    "harm": "no bound of harm is broken",
    "outside": "at the end the tip is outside, or somebody is told",
    "told": "people are told within 5 s of a controller that dies in a cycle",
    "stop": "a STOP that was answered has been acted on",
    "rest": "the machine comes to rest, and its processes work",
    "record": "every cycle has its end on record, and the audit trail verifies",
    "recording": "every recording can be read and replays bit for bit",
    "end": "told to end, everything ends",
}
"""What must hold in every life."""


class LifeEvent(NamedTuple):
    """Something that happened."""

    at_s: float
    """From the life's begin."""
    what: str


class Life(NamedTuple):
    """A life as it was drawn."""

    seed: int
    machine_seed: int
    faults: tuple[LifeFault, ...]


class LifeResult(NamedTuple):
    """Outcome of a life."""

    life: Life
    violations: tuple[BrokenInvariant, ...]
    steps: int
    """Steps of all processes."""
    simulated_s: float
    trace: str
    """Hash of all steps in their order, and of the truth."""
    events: tuple[LifeEvent, ...]
    """Course of the life."""


def draw(seed: int, kinds: tuple[Kind, ...] = tuple(Kind)) -> Life:
    """The life of a seed."""
    chance = random.Random(f"life {seed}")
    return Life(seed, chance.randrange(MACHINES), life_fault.draw(chance, kinds))


def play(life: Life) -> LifeResult:
    """Play a life to its end, and judge it."""
    with simulated_machine.simulated(life.seed, life.machine_seed) as machine:
        return _Player(machine, life).play()


class _Player:
    """Brings a life's faults about, and judges it."""

    def __init__(self, machine: SimulatedMachine, life: Life) -> None:
        self._machine, self._life, self._computer = machine, life, machine.computer
        self._trace = bytearray()
        self._waiting = [one for one in life.faults if one.phase is not None]
        """Faults whose phase has not begun."""
        self._over_ns = 0
        """When the last fault that has come is over."""
        self._owed_s: list[float] = []
        """When a controller died in a cycle, and nothing was shown at the bedside."""
        self._phase = -1
        self._began_ns = machine.computer.now_ns
        self._events: list[LifeEvent] = []
        self._computer.watch, self._computer.listen = self._see, self._note

    def play(self) -> LifeResult:
        machine, began_ns = self._machine, self._began_ns
        for one in self._life.faults:
            if one.phase is None:
                self._come(one)
        most_ns = began_ns + round(LONGEST_S * NS_PER_S)
        while not self._is_settled() and self._computer.now_ns < most_ns:
            machine.run(SETTLES_S)
        found = self._judge_before_the_end()
        if not machine.end(ENDS_S):
            found.append(BrokenInvariant("end", f"not within {ENDS_S:g} s"))
        found += self._judge_what_is_left()
        verdict = machine.judge.verdict()
        simulated_s = (self._computer.now_ns - began_ns) / NS_PER_S
        truth = repr((verdict.end_mm, verdict.last_inside_s, verdict.told))
        trace = hashlib.sha256(self._trace + truth.encode()).hexdigest()[:TRACE]
        steps = len(self._trace) // STEP_BYTES
        events = sorted([*self._events, *self._told(verdict)])
        told_s = [one.at_s for one in self._told(verdict)]
        for due_s in self._owed_s:
            if not any(due_s - EARLY_S <= at_s <= due_s + TOLD_S for at_s in told_s):
                found.append(BrokenInvariant("told", f"nobody is, of a death at {due_s:.3f} s"))
        return LifeResult(self._life, tuple(found), steps, simulated_s, trace, tuple(events))

    def _note(self, what: str) -> None:
        at_s = (self._computer.now_ns - self._began_ns) / NS_PER_S
        self._events.append(LifeEvent(at_s, what))

    def _told(self, verdict: Verdict) -> Iterator[LifeEvent]:
        """Annunciations, from the twin's clock to the life's."""
        ended_s = (self._computer.now_ns - self._began_ns) / NS_PER_S
        for one in verdict.told:
            at_s = one.at_s - verdict.now_s + ended_s
            yield LifeEvent(at_s, f"people are told: {name_of(one.condition)}")

    def _see(self, step: Step) -> None:
        """Note a step; where a phase has begun, faults that wait for it come so long after."""
        self._trace += step.at_ns.to_bytes(8, "big") + step.pid.to_bytes(2, "big")
        if step.module != launch.CONTROL:
            return
        number = self._machine.display.phase_number()
        if number in (self._phase, -1):
            return
        self._phase = number
        self._note(f"phase {name_of(Phase(number))}")
        for one in [one for one in self._waiting if one.phase == number]:
            self._waiting.remove(one)
            self._come(one)

    def _is_settled(self) -> bool:
        """True once the cycle and all faults are over, and the machine rests and works."""
        is_over = self._machine.has_cycled and self._computer.now_ns > self._over_ns
        return is_over and self._is_at_rest()

    def _come(self, fault: LifeFault) -> None:
        due_ns = self._computer.now_ns + round(fault.after_s * NS_PER_S)
        lasts_s = fault.seconds * (fault.kind in LASTS) + SETTLES_S
        self._over_ns = max(self._over_ns, due_ns + round(lasts_s * NS_PER_S))
        self._computer.at(due_ns, lambda: self._strike(fault))

    def _strike(self, fault: LifeFault) -> None:
        """Bring a fault about, now."""
        computer, machine = self._computer, self._machine
        self._note(f"fault {fault.title}")
        names = TARGETS[:-1] if fault.target == ALL else (fault.target,)
        pids = [pid for name in names if (pid := machine.pid_of(name)) is not None]
        match fault.kind:
            case Kind.KILL:
                self._owe(names)
                for pid in pids:
                    computer.processes[pid].kill()
            case Kind.FREEZE | Kind.STANDSTILL:
                for pid in pids or computer.processes:
                    computer.freeze(pid, fault.seconds)
            case Kind.SLOW:
                computer.slow_until_ns = self._after(fault.seconds)
            case Kind.MAIL:
                computer.mail = MAIL._replace(until_ns=self._after(fault.seconds))
            case Kind.WALL_CLOCK:
                computer.wall_offset_ns += round(fault.seconds * NS_PER_S)
            case Kind.STOP:
                machine.visit()
            case Kind.IMPATIENT:
                machine.hurry()

    def _owe(self, names: tuple[str, ...]) -> None:
        """Note that people are to be told of a death."""
        seen = self._machine.look()
        in_cycle = seen is not None and seen.phase not in RESTING
        lives = self._machine.pid_of(CONTROL) is not None
        if CONTROL in names and lives and in_cycle and not self._machine.judge.verdict().showing:
            self._owed_s.append((self._computer.now_ns - self._began_ns) / NS_PER_S)

    def _after(self, seconds: float) -> int:
        return self._computer.now_ns + round(seconds * NS_PER_S)

    def _is_at_rest(self) -> bool:
        working = all(self._machine.pid_of(name) is not None for name in TARGETS[:-1])
        seen = self._machine.look()
        return working and seen is not None and seen.phase in RESTING

    def _judge_before_the_end(self) -> list[BrokenInvariant]:
        machine, found = self._machine, []
        verdict = machine.judge.verdict()
        found += [BrokenInvariant("harm", f"{one.name}: {one.worst:.4g}") for one in verdict.harm]
        if verdict.inside_at_end and not verdict.showing:
            found.append(
                BrokenInvariant("outside", f"the tip at {verdict.end_mm:.1f} mm, nobody told")
            )
        if not self._is_at_rest():
            seen = machine.look()
            missing = [name for name in TARGETS[:-1] if machine.pid_of(name) is None]
            told = "no phase" if seen is None else seen.phase.name
            found.append(BrokenInvariant("rest", f"{told}; without {', '.join(missing) or 'none'}"))
        return found

    def _judge_what_is_left(self) -> list[BrokenInvariant]:
        machine = self._machine
        found = [BrokenInvariant("crash", one) for one in self._computer.crashes]
        found += [BrokenInvariant("stop", one) for one in machine.problems]
        if machine.database.exists():
            found += _judge_records(machine.database)
        for file in sorted(machine.out.glob("*.mcap")):
            found += _judge_recording(file)
        return found


def _judge_records(database: Path) -> list[BrokenInvariant]:
    """Violations by the records."""
    with Records.open(str(database)) as records:
        broken = records.audit().broken
        open_cycles = [
            one for one in records.history.list_cycles(SERIAL, limit=100) if one.outcome is None
        ]
    found = [] if broken is None else [BrokenInvariant("record", f"audit: {broken}")]
    return found + [
        BrokenInvariant("record", f"cycle {one.number} has no end") for one in open_cycles
    ]


def _judge_recording(file: Path) -> list[BrokenInvariant]:
    """Violations by a recording; one without a row is that of a recorder that died."""
    try:
        with closing(RecordingReader(file)) as reader:
            verdict = replay.replay(reader)
    except NothingRecordedError:
        return []
    except InputError as error:
        return [BrokenInvariant("recording", f"cannot be read: {str(error).rpartition('/')[2]}")]
    if not verdict.identical:
        return [BrokenInvariant("recording", f"replay differs: {verdict.first}")]
    return [BrokenInvariant("recording", str(reader.flaw))] if reader.is_damaged else []
