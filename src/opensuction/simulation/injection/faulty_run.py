"""A run of the loop as far as it has come, with faults that are waiting for their instants.

Memory for the rows of a run with faults: written a piece at a time, kept as columns.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from opensuction.controller import controller
from opensuction.kernel.codegen import row
from opensuction.kernel.interface import NO_REQUESTS, START, Commands, Requests
from opensuction.kernel.unit import HOUR_S
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.safety.head import head_vote
from opensuction.simulation import closed_loop, trace, wiring
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.injection.fault_instant import FaultySide, Injection, Instant
from opensuction.simulation.trace import Columns, InputLog, InputSpan
from opensuction.simulation.wiring import Messages, Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine import fail_safe, machine

PIECE_ROWS = 20_000
"""Simulated at once, at most: 14 MB, used again and again. To hand a state to compiled code and
take it back costs as much as hundreds of ticks."""


class RowBuffer:
    """Room for the rows of one run after the other.

    longest_s: the longest run. names: columns that are kept, the phase among them.
    """

    def __init__(self, longest_s: float, names: Sequence[str] = COLUMNS) -> None:
        self.names = tuple(names)
        self._piece = np.zeros((PIECE_ROWS, len(COLUMNS)))
        self._columns = np.empty((len(self.names), round(longest_s / DT_S)))
        self._index = trace.indices(self.names)
        self._sent: npt.NDArray[np.float64] | None = None

    @property
    def ticks(self) -> int:
        """Of the longest run."""
        return self._columns.shape[1]

    def piece(self, most: int) -> npt.NDArray[np.float64]:
        """Rows for the next ticks, ``most`` of them or fewer: to be written, then to be kept."""
        return self._piece[:most]

    def keep(self, done: int, ticks: int) -> None:
        """Keep so many rows of the piece that follow the ``done`` ones."""
        trace.transpose(self._piece[:ticks], self._index, self._columns[:, done : done + ticks])

    def sent(self, columns: int) -> npt.NDArray[np.float64]:
        """Room for what a controller sends in the longest run, shape (ticks, columns).

        It holds what the last run has left there.
        """
        if self._sent is None:
            self._sent = np.empty((self.ticks, columns))
        return self._sent

    def copy(self, done: int) -> npt.NDArray[np.float64]:
        """The first ``done`` rows, shape (columns, done), for `fill`."""
        return self._columns[:, :done].copy()

    def fill(self, kept: npt.NDArray[np.float64], done: int) -> None:
        """Take over the first ``done`` rows of what a run of the same columns has left."""
        self._columns[:, :done] = kept[:, :done]

    def columns(self, done: int) -> Columns:
        """The first ``done`` rows, by name; they are of this room, and the next run's after it."""
        return dict(zip(self.names, self._columns[:, :done], strict=True))


RESTARTING = (Fault.CONTROLLER_STOPPED, Fault.POWER_RETURNING)
"""Faults after which a new controller starts."""
_COMMANDS = row.columns(Commands)
_FIRST_SENT = row.columns(link.Message).index(f"commands.{_COMMANDS[0]}")
_SENT = slice(_FIRST_SENT, _FIRST_SENT + len(_COMMANDS))
"""Where a message has them, one after the other."""


def is_linked(injections: Sequence[Injection]) -> bool:
    """True where any fault lies between controller and machine, so that the link must be played."""
    return any(ROWS[one.fault].is_linked for one in injections)


class FaultyRun:
    """A run so far: its trace, its state, and what is still to come."""

    def __init__(
        self,
        loop: Loop,
        start: LoopState,
        injections: Sequence[Injection],
        room: RowBuffer,
        seed: int,
    ) -> None:
        self.state = start
        self.done = 0
        self.requests: Requests = START
        """Pressed in the next tick."""
        self.at_s = [float("nan")] * len(injections)
        """First tick with each fault; nan before."""
        self.before: list[LoopState | None] = [None] * len(injections)
        """State before that tick."""
        self._injections = injections
        self._held: set[int] = set()
        """Places of the faults whose time has not come."""
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
        self._side = FaultySide(loop.machine, link.healthy(seed), seed)
        self._wiring = Wiring(
            link=self._side.link,
            watchdog=fail_safe.of(loop.machine, home_mm),
        )

    @property
    def is_abandoned(self) -> bool:
        """True once the controller has stopped and none will start."""
        return not self._wiring.link.controller_runs and self._side.restart_done is None

    @property
    def stopped_tick(self) -> int:
        """Tick at which the controller stopped; -1 where it did not."""
        return self._side.stopped_done

    @property
    def is_resting(self) -> bool:
        """True while the machine waits for a person."""
        runs = self._wiring.link.controller_runs
        return runs and self.state.controller.core.procedure.phase in RESTING

    @property
    def is_halted(self) -> bool:
        """True while the machine waits for a reset."""
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
        self._side.begin_anew(passed)
        self._began, self._noted, self.done = {}, 0, 0
        self.state, self.requests = state, requests
        self.inputs = InputLog()
        self._loop = controls
        oxygen_ratio = controls.machine.patient.ventilator.oxygen_ratio
        self._side.sound = preset.ventilate(self._side.sound, oxygen_ratio)
        self._side.rebuild(self.done)
        self._take_over()

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
        """True once the machine waits for a person, and no fault and no restart is to come."""
        waits = any(self._is_waiting(place) for place in range(len(self._injections)))
        return self.is_resting and not waits and self._side.restart_done is None

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
        """True while a fault waits for a phase that has not come."""
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
        """True while a fault has yet to come, and may."""
        return bool(np.isnan(self.at_s[place])) and place not in self._held

    def _next_due(self) -> int | None:
        """Tick of the next change whose instant is known."""
        waiting = [
            self._due_tick(injection)
            for i, injection in enumerate(self._injections)
            if self._is_waiting(i)
        ]
        coming = (*waiting, self._side.next_done)
        return min((tick for tick in coming if tick is not None), default=None)

    def _change(self) -> None:
        """Make the changes that are due before the next tick."""
        for i, injection in enumerate(self._injections):
            if self._is_waiting(i) and self._due_tick(injection) == self.done:
                self.at_s[i], self.before[i] = self.done * DT_S, self.state
                self._inject(injection)
        self._side.follow(self.done)
        self._take_over()
        if self._side.restart_done == self.done:
            self._restart()

    def _inject(self, injection: Injection) -> None:
        if injection.fault == Fault.CATHETER_EXPIRED:
            kept = self.state.controller.core.upkeep._replace(
                catheter_age_s=injection.strength * HOUR_S
            )
            self.state = self.state._replace(
                controller=controller.with_upkeep(self.state.controller, kept)
            )
            self.inputs.set_state(trace.EXPIRED)
        else:
            readings = machine.read(self._side.machine, self.state.machine)
            self._side.inject(injection, Instant(self.done, self.state.tick), readings)

    def _take_over(self) -> None:
        """Play what is broken by now."""
        self._loop = self._loop._replace(machine=self._side.machine)
        self._wiring = self._wiring._replace(link=self._side.link)

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
        self.inputs.set_state(trace.RESTARTED)
        if self._messages is not None:
            wiring.release_drives(self._messages.state)
        self._side.restart(self.done)
        self._take_over()

    @property
    def _restart_gap_s(self) -> float:
        return (self.done - self.stopped_tick) * DT_S
