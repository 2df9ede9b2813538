"""A run of the loop as far as it has come, with faults that are waiting for their instants."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from opensuction.controller import controller
from opensuction.kernel.commands import Commands
from opensuction.kernel.constant import HOUR_S
from opensuction.kernel.errors import InputError
from opensuction.kernel.generated import row
from opensuction.kernel.phase import RESTING, Phase
from opensuction.kernel.requests import NO_REQUESTS, START, Requests
from opensuction.safety.head import head_vote
from opensuction.simulation import closed_loop, input_log, wiring
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.simulation.injection.faulty_machine import (
    break_machine,
    is_of_machine,
    next_change_s,
)
from opensuction.simulation.injection.room import PIECE_ROWS, Room
from opensuction.simulation.input_log import InputLog, InputSpan
from opensuction.simulation.trace import Columns
from opensuction.simulation.wiring import Messages, Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import LinkEffect, ReadingEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.fault.fault_time import FaultOnset
from opensuction.twin.machine import drive_watchdog, machine

MAINS = (Fault.POWER_LOST, Fault.POWER_LOST_WITHOUT_RESERVE, Fault.POWER_RETURNING)
RESTARTING = (Fault.CONTROLLER_STOPPED, Fault.POWER_RETURNING)
"""Faults after which a new controller starts."""
_COMMANDS = row.columns(Commands)
_FIRST_SENT = row.columns(link.Message).index(f"commands.{_COMMANDS[0]}")
_SENT = slice(_FIRST_SENT, _FIRST_SENT + len(_COMMANDS))
"""Where a message has them, one after the other."""


def is_linked(injections: Sequence[Injection]) -> bool:
    """Whether any fault lies between controller and machine, so that the link must be played."""
    return any(ROWS[one.fault].is_linked for one in injections)


class FaultyRun:
    """A run so far: its trace, its state, and what is still to come."""

    def __init__(
        self,
        loop: Loop,
        start: LoopState,
        injections: Sequence[Injection],
        room: Room,
        seed: int,
    ) -> None:
        self.state = start
        self.done = 0
        self.requests: Requests = START
        """Pressed in the next tick."""
        self.at_s = [float("nan")] * len(injections)
        """First tick with each fault; nan before."""
        self.stopped_tick = -1
        """When the controller stopped; -1 where it did not."""
        self._injections = injections
        self._seed = seed
        self._held: set[int] = set()
        """Places of the faults whose time has not come."""
        self._restart_tick: int | None = None
        self._next_course: dict[int, int] = {}
        """Next tick in which the course of a fault changes the machine, by its place."""
        self._began: dict[Phase, int] = {}
        """First tick of each phase that a fault waits for, once it has come."""
        self._noted = 0
        """Rows that have been looked through for them."""
        self.inputs = InputLog()
        """What the controller got beside its readings, since the rows began."""
        self._messages: Messages | None = None
        """Of a run whose link is played."""
        if is_linked(injections):
            reading = machine.read(loop.machine, start.machine)
            self._messages = wiring.start(reading, start.tick)
        self._room = room
        self.last_row: npt.NDArray[np.float64] = room.piece(1)[0]
        """Of the last tick, with all columns; until the next piece is played."""
        wanted = any(f"commands.{name}" in room.names for name in _COMMANDS)
        self._commands = np.empty((0, len(_COMMANDS)))
        if wanted and self._messages is not None:
            self._commands = room.sent(len(_COMMANDS))
        home_mm = loop.controller.limits.park_head_mm
        loop = loop._replace(machine=preset.limit_rack(loop.machine, home_mm))
        self._loop = loop
        self._sound = loop.machine
        """The machine without its faults."""
        self._wiring = Wiring(
            link=link.healthy(seed),
            watchdog=drive_watchdog.of(loop.machine, home_mm),
        )

    @property
    def is_abandoned(self) -> bool:
        """Whether the controller has stopped and none will start."""
        return not self._wiring.link.controller_runs and self._restart_tick is None

    @property
    def is_resting(self) -> bool:
        """Whether the machine waits for a person."""
        runs = self._wiring.link.controller_runs
        return runs and self.state.controller.core.procedure.phase in RESTING

    @property
    def is_halted(self) -> bool:
        """Whether a reset is what it waits for."""
        return self.is_resting and self.state.controller.core.procedure.phase == Phase.HALTED

    @property
    def columns(self) -> Columns:
        """The run so far, by name, in its room."""
        return self._room.columns(self.done)

    @property
    def loop(self) -> Loop:
        """Both sides as they are now, with the machine's faults."""
        return self._loop

    def carry_on(self, controls: Loop, state: LoopState, requests: Requests) -> None:
        """Begin the rows anew from a state in which the machine has rested for a while.

        Its controller runs. What is broken stays broken, and what was due meanwhile comes at once;
        a fault that waits goes on waiting, its instant counted from here. controls: whose
        controller goes on; of its machine only the oxygen that the patient gets counts. requests:
        pressed in the next tick.
        """
        passed = self.done + state.tick - self.state.tick
        self.at_s = [at_s - passed * DT_S for at_s in self.at_s]
        self.stopped_tick = -1
        self._next_course = {i: max(at - passed, 0) for i, at in self._next_course.items()}
        self._began, self._noted, self.done = {}, 0, 0
        self.state, self.requests = state, requests
        self.inputs = InputLog()
        self._loop = controls._replace(machine=self._loop.machine)
        oxygen_ratio = controls.machine.patient.ventilator.oxygen_ratio
        self._sound = preset.ventilate(self._sound, oxygen_ratio)
        self._break_machine()

    def begin_at(self, state: LoopState) -> None:
        """Begin behind ticks that were played before, without a fault; the room has their columns.

        state: after them. No fault may be due within them, and none may look further back than the
        first tick that is played now: a link remembers nothing of what was before.
        """
        self.done, self.state = state.tick - self.state.tick, state
        self.requests = NO_REQUESTS
        if self._messages is not None:
            reading = machine.read(self._loop.machine, state.machine)
            self._messages = wiring.start(reading, state.tick)
            self._commands[: self.done] = 0.0
            obeyed = self.columns
            for i, name in enumerate(_COMMANDS):
                if f"commands.{name}" in obeyed:
                    self._commands[: self.done, i] = obeyed[f"commands.{name}"]

    @property
    def is_over(self) -> bool:
        """Whether the machine waits for a person, no fault its instant, no controller its start."""
        waits = any(self._is_waiting(place) for place in range(len(self._injections)))
        return self.is_resting and not waits and self._restart_tick is None

    def hold(self, place: int, waits: bool) -> None:
        """Let a fault wait whatever its instant, or no longer. place: among the injections."""
        (self._held.add if waits else self._held.discard)(place)

    def advance(self, most: int) -> None:
        """Run one piece of at most so many ticks; it ends before a fault that is due."""
        self._note()
        self._change()
        most = min(most, link.RING_TICKS if self._commands.size else PIECE_ROWS)
        begun, state, messages = self.done, self.state, self._messages
        if messages is not None and self._awaits_phase:
            messages = Messages(*(rows.copy() for rows in messages))
        due = self._next_due()
        self._play(most if due is None else min(most, due - begun))
        due = self._next_due()
        if due is not None and due < self.done:  # a phase that it waits for began meanwhile
            self.done, self.state, self._messages = begun, state, messages
            self._play(due - begun)
        self.requests = NO_REQUESTS

    @property
    def _awaits_phase(self) -> bool:
        """Whether a fault waits for a phase that has not come."""
        return any(
            self._is_waiting(i) and self._due_tick(injection) is None
            for i, injection in enumerate(self._injections)
        )

    def _play(self, ticks: int) -> None:
        piece, before = self._room.piece(ticks), self.state
        first = before.tick
        self.state, ran = closed_loop.run(
            self._loop, self.state, self.requests, piece, self._wiring, self._messages
        )
        if self._messages is not None and self._commands.size:
            self._keep_sent(self._messages, first, ran)
        self._room.keep(self.done, ran)
        wires = self._wiring.link
        span = InputSpan(
            first=self.done,
            ticks=ran,
            tick=first,
            requests=self.requests,
            late_until_tick=0 if self._messages is None else wires.late_until_tick,
            runs=self._messages is None or wires.controller_runs,
        )
        self.inputs.note(span, before.controller)
        self.done, self.last_row = self.done + ran, piece[ran - 1]

    def _keep_sent(self, messages: Messages, first: int, ran: int) -> None:
        """Copy what the controller sent from the ring; none sends nothing."""
        kept = self._commands[self.done : self.done + ran]
        if self._wiring.link.controller_runs:
            begin, done = first % link.RING_TICKS, 0
            while done < ran:  # the ring goes on from its first row
                rows = messages.sent[begin : begin + ran - done, _SENT]
                kept[done : done + len(rows)] = rows
                begin, done = 0, done + len(rows)
        else:
            kept[:] = 0.0

    def sent(self, columns: Columns) -> Columns:
        """The columns of the run so far with the commands as the controller sent them.

        columns: of the trace, in which they are those that the drives obeyed. A healthy link makes
        no difference.
        """
        if not self._commands.size:
            return columns
        own = {
            f"commands.{name}": np.ascontiguousarray(self._commands[: self.done, i])
            for i, name in enumerate(_COMMANDS)
            if f"commands.{name}" in columns
        }
        return {**columns, **own}

    def _due_tick(self, injection: Injection) -> int | None:
        """First tick that a fault acts in; None while its phase has not come.

        A phase is known after its first tick: a fault that comes with it acts from the second.
        """
        after, phase = round(injection.at.after_s / DT_S), injection.at.phase
        if phase is None:
            return after
        began = self._began_tick(phase)
        return None if began is None else began + max(after, 1)

    def _began_tick(self, phase: Phase) -> int | None:
        """First tick of a phase; None while it has not come."""
        if phase in self._began:
            return self._began[phase]
        phases = self._room.columns(self.done)["phase"]
        found = np.flatnonzero(phases[self._noted :] == phase)
        return self._noted + int(found[0]) if found.size else None

    def _note(self) -> None:
        """Look for phases in the rows that will not be played again."""
        for phase in (injection.at.phase for injection in self._injections):
            began = None if phase is None else self._began_tick(phase)
            if phase is not None and began is not None:
                self._began[phase] = began
        self._noted = self.done

    def _is_waiting(self, place: int) -> bool:
        """Whether a fault has yet to come, and may."""
        return bool(np.isnan(self.at_s[place])) and place not in self._held

    def _next_due(self) -> int | None:
        """Tick of the next change whose instant is known."""
        waiting = [
            self._due_tick(injection)
            for i, injection in enumerate(self._injections)
            if self._is_waiting(i)
        ]
        coming = (*waiting, self._restart_tick, *self._next_course.values())
        return min((tick for tick in coming if tick is not None), default=None)

    def _change(self) -> None:
        """Make the changes that are due before the next tick."""
        for i, injection in enumerate(self._injections):
            if self._is_waiting(i) and self._due_tick(injection) == self.done:
                self.at_s[i] = self.done * DT_S
                self._inject(i, injection)
            elif self._next_course.get(i) == self.done:
                self._follow_course(i)
        if self._restart_tick == self.done:
            self._restart()

    def _inject(self, place: int, injection: Injection) -> None:
        fault, strength = injection.fault, injection.strength
        row = ROWS[fault]
        onset = FaultOnset(strength, self.state.tick, DT_S)
        if is_of_machine(fault):
            self._follow_course(place)
        elif isinstance(row.effect, ReadingEffect):
            readings = machine.read(self._loop.machine, self.state.machine)
            sensor = row.change_reading(onset, readings, self._seed)
            self._relink(link.with_reading_fault(self._wiring.link, sensor))
        elif isinstance(row.effect, LinkEffect):
            ran = self._wiring.link.controller_runs
            self._relink(row.change_link(self._wiring.link, onset))
            if ran and not self._wiring.link.controller_runs:
                self.stopped_tick = self.done
            self._plan_restart(fault, strength)
        elif fault == Fault.CATHETER_EXPIRED:
            kept = self.state.controller.core.upkeep._replace(catheter_age_s=strength * HOUR_S)
            self.state = self.state._replace(
                controller=controller.with_upkeep(self.state.controller, kept)
            )
            self.inputs.set_state(input_log.EXPIRED)
        else:
            raise InputError(
                f"fault '{fault.title}' is one of the set-up: it is injected before the cycle is "
                "planned"
            )

    def _follow_course(self, place: int) -> None:
        """Change the machine as the course of a fault wants it now, and note when it does next."""
        self._break_machine()
        self._next_course.pop(place, None)
        since_s = self.done * DT_S - self.at_s[place]
        left_s = next_change_s(self._injections[place], since_s)
        if np.isfinite(left_s):
            self._next_course[place] = self.done + max(round(left_s / DT_S), 1)

    def _break_machine(self) -> None:
        """Give the machine all the faults that it has now, in the order in which they came."""
        now_s = self.done * DT_S
        pairs = zip(self._injections, self.at_s, strict=True)
        came = [(injection, now_s - at_s) for injection, at_s in pairs if not np.isnan(at_s)]
        came.sort(key=lambda one: -one[1])
        faulty = break_machine(self._sound, came, self._wiring.link.mains)
        self._loop = self._loop._replace(machine=faulty)

    def _plan_restart(self, fault: Fault, strength: float) -> None:
        """A fault of the link came: when the next controller starts, if one does."""
        if fault in MAINS:
            self._restart_tick = None
            self._break_machine()
        if fault == Fault.POWER_RETURNING or (
            fault == Fault.CONTROLLER_STOPPED and self._wiring.link.mains
        ):
            self._restart_tick = self.done + round(strength / DT_S)

    def _relink(self, faulty: link.Link) -> None:
        self._wiring = self._wiring._replace(link=faulty)

    def _restart(self) -> None:
        """A new controller starts: it knows what the head's sensors read and what its record holds.

        Where the mains were gone, they are back.
        """
        readings = link.sense(
            self._wiring.link,
            machine.read(self._loop.machine, self.state.machine),
            self.state.tick,
        )
        head_mm = head_vote.first_mm(readings)
        settings, before = self._loop.controller, self.state.controller.core
        fresh = controller.restart(
            settings, head_mm, before.upkeep, self._restart_gap_s, before.procedure.phase
        )
        self.state = self.state._replace(controller=fresh)
        self.inputs.set_state(input_log.RESTARTED)
        if self._messages is not None:
            wiring.release_drives(self._messages.state)
        self._relink(self._wiring.link._replace(controller_runs=True, mains=True))
        self._break_machine()
        self._restart_tick = None

    @property
    def _restart_gap_s(self) -> float:
        return (self.done - self.stopped_tick) * DT_S
