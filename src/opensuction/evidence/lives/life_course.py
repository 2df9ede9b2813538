"""Course of a life for a picture: where the tip was, and in which state each process was."""

from collections.abc import Iterator
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from opensuction.evidence.lives.simulated_computer import Step
from opensuction.evidence.lives.simulated_machine import SimulatedMachine
from opensuction.host.host import NS_PER_S
from opensuction.kernel.record import Array
from opensuction.machine import port
from opensuction.machine.twin import twin_machine
from opensuction.runtime import launch

LANES = {
    twin_machine.PROCESS: "twin",
    launch.CONTROL: "control",
    launch.RECORDER: "recorder",
    launch.SUPERVISOR: "supervisor",
}
"""Names of the processes that are watched, by their modules."""
TAKEN_NS = NS_PER_S
"""The truth is taken so often: a twin overwrites it after 20 s."""
EVERY_TICKS = 10
"""Of so many ticks one is kept: the tip moves less than 1 mm meanwhile."""


class ProcessState(StrEnum):
    """State of a process."""

    STARTING = "starting"
    ALIVE = "alive"
    FROZEN = "frozen"
    DEAD = "dead"


class ProcessStretch(NamedTuple):
    """A time in which a process was in one state. Times are from the life's begin."""

    process: str
    """One of `LANES`."""
    state: ProcessState
    from_s: float
    to_s: float


class Course(NamedTuple):
    """Course of a life. Times are from its begin."""

    time_s: Array
    tip_mm: Array
    """By the truth of the twin."""
    stretches: tuple[ProcessStretch, ...]
    ended_s: float


class CourseWatch:
    """Looks on a life; it changes nothing of it."""

    def __init__(self, machine: SimulatedMachine) -> None:
        """machine: as its life begins."""
        self._machine, self._computer = machine, machine.computer
        self._began_ns = machine.computer.now_ns
        self._truth = port.open_truth(machine.folder)
        self._places = [self._truth.columns.index(name) for name in ("tick", "truth.tip_mm")]
        self._rows: list[Array] = []
        self._taken_ns = self._began_ns
        self._stepped = {machine.twin.pid}
        """Processes that have done a step: the twin does before the life begins."""
        self._now: dict[str, tuple[ProcessState, float]] = {}
        """State of each process, and since when."""
        self._stretches: list[ProcessStretch] = []
        self.look()

    def see(self, step: Step) -> None:
        """Look at the processes before a step."""
        self._stepped.add(step.pid)
        self.look()
        if step.at_ns - self._taken_ns >= TAKEN_NS:
            self._take()

    def look(self) -> None:
        """Look at the processes now."""
        now_ns = self._computer.now_ns
        for name, (state, thawed_ns) in dict(self._states()).items():
            before, since_s = self._now.get(name, (None, 0.0))
            if state is before:
                continue
            # Steps of a stretch are seen after it: a freeze may have ended before.
            is_over = before is ProcessState.FROZEN and state is not ProcessState.DEAD
            at_s = self._since_s(min(thawed_ns, now_ns) if is_over else now_ns)
            if before is not None:
                self._stretches.append(ProcessStretch(name, before, since_s, at_s))
            self._now[name] = state, at_s

    def end(self) -> Course:
        """Course up to now."""
        self._take()
        now_s = self._since_s(self._computer.now_ns)
        last = [ProcessStretch(name, *found, now_s) for name, found in self._now.items()]
        tick, tip_mm = np.concatenate(self._rows).T
        nature = self._machine.nature
        played_s = (tick * self._truth.period_s).tolist()
        return Course(
            np.array([self._since_s(nature.at_ns(one)) for one in played_s]),
            tip_mm,
            (*self._stretches, *last),
            now_s,
        )

    def _states(self) -> Iterator[tuple[str, tuple[ProcessState, int]]]:
        """State of every process, and until when it was frozen last; the newest of a name last."""
        for pid, process in self._computer.processes.items():
            name = LANES.get(process.module)
            if name is None:
                continue
            state = ProcessState.ALIVE if pid in self._stepped else ProcessState.STARTING
            if process.status is not None:
                state = ProcessState.DEAD
            elif process.frozen_until_ns > self._computer.now_ns:
                state = ProcessState.FROZEN
            yield name, (state, process.frozen_until_ns)

    def _take(self) -> None:
        self._taken_ns = self._computer.now_ns
        self._rows.append(self._truth.read().rows[::EVERY_TICKS, self._places])

    def _since_s(self, at_ns: float) -> float:
        return (at_ns - self._began_ns) / NS_PER_S
