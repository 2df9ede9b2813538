"""One life of a machine: a cycle with its start, its faults and its end, and all that must hold.

The judges are the oracle, by the twin's truth alone, and the records and recordings that are left.
"""

import math
import random
from collections.abc import Callable, Iterator
from pathlib import Path

from opensuction.evidence.lives import life_fault, record_judge, simulated_machine
from opensuction.evidence.lives.life_course import CourseWatch
from opensuction.evidence.lives.life_fault import (
    ALL,
    CONTROL,
    LASTS,
    RECORDER,
    STORAGE,
    TARGETS,
    Kind,
    LifeFault,
)
from opensuction.evidence.lives.life_record import (
    EventKind,
    Life,
    LifeEvent,
    LifeResult,
    WatchedLife,
)
from opensuction.evidence.lives.record_judge import BrokenInvariant, Circumstances
from opensuction.evidence.lives.simulated_computer import MailShares, Step
from opensuction.evidence.lives.simulated_machine import SERIAL, SimulatedMachine
from opensuction.evidence.lives.simulated_process import SimulatedProcess
from opensuction.evidence.lives.step_watch import STEADY_S, StepWatch
from opensuction.host.host import NS_PER_S
from opensuction.kernel.vocabulary import RESTING, Phase, name_of
from opensuction.machine.twin.live_judge import Verdict
from opensuction.runtime import launch
from opensuction.safety.condition import Condition

MACHINES = simulated_machine.PREPARED
"""Machines and patients that lives are drawn from."""
LONGEST_S = 90.0
"""A cycle of a life that has not settled by then never does; the patient's rest before it may come
besides."""
SETTLES_S = 3.0
"""So long after the last fault is over a life has settled, where the machine rests and works."""
TOLD_S, EARLY_S = 1.0, 0.1
"""Within this time people are told of a controller's death, by the twin's clock; they may have been
just before."""
MISSED_S, USED_S = 3.0, 1.5
"""Within this time they are told of another process that does nothing: half a second until the
controller misses it, two until it says so. It is missed where it has worked for so long."""
STANDS_S = 1.0
"""Of one that stands still for longer they are told as of one that died."""
MODULES = dict(zip(TARGETS, (launch.CONTROL, launch.RECORDER, launch.SUPERVISOR), strict=False))
ENDS_S = 150.0
"""Within this time all processes end that are told to."""
MAIL = MailShares(lost=0.33, twice=0.33, late=0.33)
TRACE = 16
"""Letters of the hash of a life."""


def draw(seed: int, kinds: tuple[Kind, ...] = tuple(Kind), cycles: int = 1) -> Life:
    """The life of a seed; its first cycle is that of a life of one."""
    chance = random.Random(f"life {seed}")
    machine_seed = chance.randrange(MACHINES)
    return Life(seed, machine_seed, life_fault.draw(chance, kinds, cycles), cycles)


def play(life: Life, room: Path | None = None) -> LifeResult:
    """Play a life to its end, and judge it.

    room: folder for its files; None: memory. Raises InputError where that has no space for them.
    """
    with simulated_machine.simulated(life.seed, life.machine_seed, room) as machine:
        return _Player(machine, life).play()


def watch(life: Life, room: Path | None = None) -> WatchedLife:
    """Play the same life, to be shown: with its course and its recordings; see `play`."""
    with simulated_machine.simulated(life.seed, life.machine_seed, room) as machine:
        course = CourseWatch(machine)
        result = _Player(machine, life, course).play()
        files = sorted(machine.out.glob("*.mcap"))
        return WatchedLife(result, course.end(), {one.name: one.read_bytes() for one in files})


class _Player:
    """Brings a life's faults about, and judges it."""

    def __init__(
        self, machine: SimulatedMachine, life: Life, course: CourseWatch | None = None
    ) -> None:
        self._machine, self._life, self._computer = machine, life, machine.computer
        self._course = course
        self._waiting: list[LifeFault] = []
        """Faults whose phase has not begun."""
        self._over_ns = 0
        """When the last fault that has come is over."""
        self._phase = -1
        self._began_ns = machine.computer.now_ns
        self._found: list[BrokenInvariant] = []
        """While it was played."""
        disk = machine.computer.disk
        self._watch = StepWatch(
            self._began_ns, lambda said: self._break("hang", said), lambda: not disk.refuses
        )
        self._strikes = False
        """A fault comes now."""
        self._unkept_s: list[tuple[float, float]] = []
        """See `Circumstances.unkept_s`."""
        self._refused_s: float | None = None
        """When the disk or the database began to refuse, by the twin's clock."""
        self._events: list[LifeEvent] = []
        self._computer.watch, self._computer.listen = self._see, self._hear
        self._computer.watch_passed = self._see_passed
        machine.people.unanswered = self._miss
        machine.people.start_cycles(life.cycles, self._begin_cycle)
        if self._computer.stretches is not None:
            self._computer.stretches.seen_phase = self._phase

    def play(self) -> LifeResult:
        machine, began_ns = self._machine, self._began_ns
        self._begin_cycle(0)
        # A pass that may have been made before a loss of power has its rest, too.
        longest_s = LONGEST_S + machine.prepared.loop.controller.service.passes.rest_s
        most_ns = began_ns + round(self._life.cycles * longest_s * NS_PER_S)
        while not self._is_settled() and self._computer.now_ns < most_ns:
            machine.run(SETTLES_S)
        found = self._judge_before_the_end()
        self._watch.is_over = True
        for process in self._computer.processes.values():
            process.fate = None  # nobody would come after it
        if not machine.end(ENDS_S):
            found.append(BrokenInvariant("end", f"not within {ENDS_S:g} s"))
        found += self._judge_what_is_left()
        verdict = machine.judge.verdict()
        simulated_s = (self._computer.now_ns - began_ns) / NS_PER_S
        truth = repr((verdict.end_mm, verdict.last_inside_s, verdict.told))
        self._computer.trace.update(truth.encode())
        trace = self._computer.trace.hexdigest()[:TRACE]
        events = sorted([*self._events, *self._told(verdict)], key=lambda one: one.at_s)
        found += self._found
        steps = self._computer.steps
        return LifeResult(self._life, tuple(found), steps, simulated_s, trace, tuple(events))

    def _begin_cycle(self, number: int) -> None:
        """Have the faults of a cycle come: they count from the life's begin, or from its start."""
        for one in self._life.faults:
            if one.cycle == number:
                if one.phase is None:
                    self._come(one)
                else:
                    self._waiting.append(one)

    def _note(self, what: str, kind: EventKind) -> None:
        at_s = (self._computer.now_ns - self._began_ns) / NS_PER_S
        self._events.append(LifeEvent(at_s, what, kind))

    def _break(self, invariant: str, said: str) -> None:
        at_s = (self._computer.now_ns - self._began_ns) / NS_PER_S
        self._found.append(BrokenInvariant(invariant, f"{said}, at {at_s:.3f} s"))

    def _hear(self, what: str) -> None:
        """Note that a process began or ended."""
        self._note(what, "process")
        if self._course is not None:
            self._course.look()
        name, _, how = what.partition(" ")
        if name == MODULES[CONTROL].rpartition(".")[2]:
            # The rings of the next controller take the place of those of one that has ended, maybe
            # before anybody looks again: one that lived between two looks was seen by nobody.
            self._machine.witness.look()
        if how == "was killed" and not self._strikes:
            self._watch.hear_killed(name, self._computer.now_ns)

    def _miss(self, sent_ns: int) -> None:
        """Nobody has answered a person: there must be a reason."""
        before_ns = sent_ns - round(STEADY_S * NS_PER_S)
        works = self._watch.is_steady(launch.CONTROL, before_ns, self._computer.now_ns)
        if works and self._computer.mail.until_ns <= sent_ns:
            self._break("press", "a person is not answered")

    def _told(self, verdict: Verdict) -> Iterator[LifeEvent]:
        """Annunciations, from the twin's clock to the life's."""
        for one in verdict.told:
            at_s = (self._machine.nature.at_ns(one.at_s) - self._began_ns) / NS_PER_S
            yield LifeEvent(at_s, f"people are told: {name_of(one.condition)}", "told")

    def _see_passed(self, step: Step) -> None:
        """See a step that needs nothing to be done."""
        self._watch.see(step)
        if self._course is not None:
            self._course.see(step)

    def _see(self, step: Step) -> None:
        """Before a step: where a phase has begun, faults that wait for it come so long after."""
        self._see_passed(step)
        if step.module != launch.CONTROL:
            return
        number = self._machine.display.phase_number(step.pid)
        if number in (self._phase, -1):
            return
        self._phase = number
        if self._computer.stretches is not None:
            self._computer.stretches.seen_phase = number
        self._note(f"phase {name_of(Phase(number))}", "phase")
        for one in [one for one in self._waiting if one.phase == number]:
            self._waiting.remove(one)
            self._come(one)

    def _is_settled(self) -> bool:
        """True once the cycle and all faults are over, and the machine rests and works."""
        is_over = self._machine.people.has_cycled and self._computer.now_ns > self._over_ns
        return is_over and self._is_at_rest()

    def _come(self, fault: LifeFault) -> None:
        due_ns = self._computer.now_ns + round(fault.after_s * NS_PER_S)
        lasts_s = fault.seconds * (fault.kind in LASTS) + SETTLES_S
        self._over_ns = max(self._over_ns, due_ns + round(lasts_s * NS_PER_S))
        self._computer.at(due_ns, lambda: self._strike(fault))

    def _strike(self, fault: LifeFault) -> None:
        """Bring a fault about, now, of which people are told where they must be."""
        self._note(f"fault {fault.title}", "fault")
        if fault.kind in (Kind.KILL, Kind.POWER) or (fault.target and fault.seconds > STANDS_S):
            self._owe(fault)
        self._strikes = True
        if fault.kind is Kind.POWER:
            unsound_ns = max(self._computer.slow_until_ns, self._computer.disk.unsound_until_ns)
            self._unkept_s.append(self._watch.find_unkept(self._computer.now_ns, unsound_ns))
            self._machine.lose_power(fault.seconds)
        else:
            (self._strike_disk if fault.kind in STORAGE else self._do)(fault)
        self._strikes = False
        if self._course is not None:
            self._course.look()  # where the whole host stands still, the next step is after it

    def _do(self, fault: LifeFault) -> None:
        computer, machine = self._computer, self._machine
        match fault.kind:
            case Kind.SLOW:
                computer.slow_until_ns = self._after(fault.seconds)
            case Kind.MAIL:
                computer.mail = MAIL._replace(until_ns=self._after(fault.seconds))
            case Kind.WALL_CLOCK:
                computer.wall_offset_ns += round(fault.seconds * NS_PER_S)
            case Kind.STOP:
                machine.visit()
            case Kind.IMPATIENT:
                machine.people.hurry()
            case _:
                self._strike_processes(fault)

    def _strike_processes(self, fault: LifeFault) -> None:
        """Kill processes, or have them stand still, now; or die soon."""
        computer, machine = self._computer, self._machine
        names = TARGETS[:-1] if fault.target == ALL else (fault.target or RECORDER,)
        pids = [pid for name in names if (pid := machine.pid_of(name)) is not None]
        if fault.kind is Kind.STANDSTILL:
            pids = list(computer.processes)
        for pid in pids:
            process = computer.processes[pid]
            match fault.kind:
                case Kind.KILL:
                    process.kill()
                case Kind.KILL_WRITING:
                    self._doom(fault, process)
                case _:
                    computer.freeze(pid, fault.seconds)

    def _strike_disk(self, fault: LifeFault) -> None:
        """Bring a fault of the disk or the database about, now."""
        verdict = self._machine.judge.verdict()
        if self._refused_s is None:
            is_shown = Condition.RECORDER_LOST in verdict.showing
            self._refused_s = -math.inf if is_shown else verdict.now_s
        self._computer.disk.strike(fault.kind, self._after(fault.seconds))

    def _doom(self, fault: LifeFault, process: SimulatedProcess) -> None:
        """Have a process die as soon as it asks something of the disk or the database."""

        def die() -> None:
            self._note(f"fault {fault.kind} comes", "fault")
            self._over_ns = max(self._over_ns, self._after(SETTLES_S))
            self._owe(fault._replace(target=RECORDER))
            self._strikes = True
            process.kill()
            self._strikes = False

        process.fate = die

    def _owe(self, fault: LifeFault) -> None:
        """Have people told of a fault that is about to come: of whoever dies, or stands still."""
        now_ns = self._computer.now_ns
        names = TARGETS[:-1] if fault.target in (ALL, "") else (fault.target,)
        seen, verdict = self._machine.look(), self._machine.judge.verdict()
        from_s, shown = verdict.now_s - EARLY_S, verdict.showing
        if CONTROL in names:
            in_cycle = seen is not None and seen.phase not in RESTING
            lives = self._machine.pid_of(CONTROL) is not None
            if in_cycle and lives and Condition.WATCHDOG_FIRED not in shown:
                self._look_again(TOLD_S, lambda: self._judge_death(from_s))
        elif Condition.RECORDER_LOST not in shown and self._works(*names, since_ns=now_ns):
            self._look_again(MISSED_S, lambda: self._judge_loss(now_ns, from_s, names))

    def _works(self, *names: str, since_ns: int) -> bool:
        """True where these processes have been at work for a while before an instant."""
        from_ns = since_ns - round(USED_S * NS_PER_S)
        now_ns = self._computer.now_ns
        return all(self._watch.is_steady(MODULES[name], from_ns, now_ns) for name in names)

    def _look_again(self, seconds: float, judge: Callable[[], None]) -> None:
        self._computer.at(self._after(seconds), judge)

    def _judge_death(self, from_s: float) -> None:
        """The drives have acted on their own and told so, on a twin that plays."""
        verdict = self._machine.judge.verdict()
        told = [one.condition for one in verdict.told_since(from_s)]
        if Condition.WATCHDOG_FIRED in (*told, *verdict.showing):
            return
        if verdict.now_s - from_s < TOLD_S:  # it has stood still itself
            self._look_again(TOLD_S, lambda: self._judge_death(from_s))
        else:
            self._break("told", "nobody is that the drives act on their own")

    def _judge_loss(self, lost_ns: int, from_s: float, names: tuple[str, ...]) -> None:
        """A controller that has been at work since has told of a recorder or a supervisor."""
        told = [one.condition for one in self._machine.judge.verdict().told_since(from_s)]
        if self._works(CONTROL, since_ns=lost_ns) and Condition.RECORDER_LOST not in told:
            self._break("told", f"nobody is, of a {names[0]} that does nothing")

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
        if not machine.people.has_cycled:
            found.append(BrokenInvariant("rest", "no cycle took place"))
        if not self._is_at_rest():
            seen = machine.look()
            missing = [name for name in TARGETS[:-1] if machine.pid_of(name) is None]
            told = "no phase" if seen is None else seen.phase.name
            found.append(BrokenInvariant("rest", f"{told}; without {', '.join(missing) or 'none'}"))
        return found

    def _judge_what_is_left(self) -> list[BrokenInvariant]:
        machine = self._machine
        found = [BrokenInvariant("crash", one) for one in self._computer.crashes]
        found += [BrokenInvariant("stop", one) for one in machine.people.problems]
        runs, verdict = machine.witness.runs, machine.judge.verdict()
        found += record_judge.judge_presses(runs, machine.people.asked_ns)
        told_s = [one.at_s for one in verdict.told if one.condition == Condition.RECORDER_LOST]
        seen = Circumstances(
            runs,
            away_s=self._watch.away_ns / NS_PER_S,
            is_told=bool(told_s),
            is_refusal_told=self._refused_s is not None
            and max(told_s, default=-math.inf) > self._refused_s,
            synced=self._computer.disk.synced,
            unkept_s=tuple(self._unkept_s),
            set_back_s=-sum(min(one.seconds, 0.0) for one in self._life.faults),
        )
        return found + list(record_judge.judge(seen, machine.out, machine.database, SERIAL))
