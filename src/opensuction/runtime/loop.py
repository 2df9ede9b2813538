"""The control loop: read, step, command, publish, once a period; all but the clock.

It calls the same core as the simulation, through `RealTimeCall`. A row of the ring is a tick: when
it was, what went in, what came out, and all that the controller remembers.

Decision that a process of the machine is lost, from its signs of life; no clock.

A process that is being started is waited for, as long as the ring still keeps all that has happened
meanwhile. One that has worked is lost when it falls silent or when another one takes its place.

Events of a recording, derived from rows of the control loop.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from opensuction.controller import loop_tick
from opensuction.controller.loop_tick import AT_REST, NEVER, LoopMemory, LoopPace, TickTime
from opensuction.controller.real_time_call import (
    INPUT_COLUMNS,
    OUTPUT_COLUMNS,
    STATE_COLUMNS,
    RealTimeCall,
)
from opensuction.host.host import Clock
from opensuction.ipc import mailbox
from opensuction.ipc.liveness import Heartbeat, Process, Signs
from opensuction.ipc.mailbox import Mailbox
from opensuction.ipc.ring import EventWriter, ProcessEvent, RingWriter
from opensuction.kernel.compiler.dispatcher import TypedCall
from opensuction.kernel.interface import MESSAGE_COLUMNS, NO_REQUESTS, Requests
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.machine.port import Port
from opensuction.procedure.cycle.transition import Event as Transition
from opensuction.recording.cycle_file.row_schema import RecordedEvent
from opensuction.runtime.machine_folder import SLOTS_S
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.safety.handling import UNANSWERED_S

MISSED_S = 0.5
"""Without a sign of life for longer than this a process is lost."""
LOST_S = 3.0
"""Lost it counts for at least so long: of every loss somebody is told, for something may not have
been kept, however soon it is there again."""
TOLD_BEFORE_S = 1.0
"""So long before the first row is gone people are told that nobody has kept it yet."""
STARTS_S = SLOTS_S - UNANSWERED_S - TOLD_BEFORE_S
"""For so long a start may take before the process is lost: a recorder that comes later finds rows
gone from the ring, and the alarm has a delay of its own (`UNANSWERED_S`)."""
WATCHED = {
    Process.SUPERVISOR: 1 << Condition.RECORDER_LOST,
    Process.RECORDER: 1 << Condition.RECORDER_LOST,
    Process.KEEPING: 1 << Condition.RECORDER_LOST,
    Process.CONSOLE: 1 << Condition.CONSOLE_LOST,
}
"""Condition of each process that the controller misses, as a mask."""


def is_lost(signs: Signs, known_deaths: int, running_s: float) -> bool:
    """Decide whether a process is lost now.

    known_deaths: how many deaths of it the controller has taken note of.
    running_s: how long the controller has run, by its ticks; before them there are no rows to lose.
    """
    if signs.deaths != known_deaths:
        return True
    if signs.starting_s is not None:
        return min(signs.starting_s, running_s) > STARTS_S
    return signs.is_expected and signs.age_s > MISSED_S


TIMING_COLUMNS = (
    "loop.time_s",
    "loop.late_s",
    "loop.computed_s",
    "loop.skipped",
    "loop.left_rest",
)
"""Monotonic time of the tick's deadline; how long after it the tick began; what the tick before
took, until its commands were out and until its row was; ticks that were missed before it; tick in
which the machine left its rest, and `AT_REST` while it rests."""
ROW_COLUMNS = (
    *TIMING_COLUMNS,
    *(f"inputs.{name}" for name in INPUT_COLUMNS),
    *(f"outputs.{name}" for name in OUTPUT_COLUMNS),
    *(f"state.{name}" for name in STATE_COLUMNS),
)
"""Columns of a row of the ring."""
STARTED_FROM = "state"
"""What the ring tells of the state before its first row: the bytes of its numbers."""
STALE_S = 0.02
"""For so long the same readings may come, as long as the drives wait for a command: the machine has
a clock of its own, and may be late. Then they are no readings; by its own watch the core would tell
after 50 ticks [design]."""
LOOK_S = 0.1
"""How often their signs are looked for."""
SET, CONFIGURED = "set", "configured"
"""Verdict on other settings that were taken, and the event: from this tick on the controller goes
by them, and from another state."""

_TIMING = len(TIMING_COLUMNS)
_LEFT_REST = TIMING_COLUMNS.index("loop.left_rest")
_INPUTS = slice(_TIMING, _TIMING + len(INPUT_COLUMNS))
_OUTPUTS = slice(_INPUTS.stop, _INPUTS.stop + len(OUTPUT_COLUMNS))
_STATE = slice(_OUTPUTS.stop, _OUTPUTS.stop + len(STATE_COLUMNS))


def _places(columns: tuple[str, ...], head: str) -> slice:
    """Slice of a row that holds the columns of a record."""
    found = [i for i, name in enumerate(columns) if name.startswith(f"{head}.")]
    return slice(found[0], found[-1] + 1)


_READINGS = _places(INPUT_COLUMNS, "readings")
_REQUESTS = _places(INPUT_COLUMNS, "requests")
_CONDITIONS = INPUT_COLUMNS.index("host.conditions")
_PHASE = OUTPUT_COLUMNS.index("phase")


class Around(NamedTuple):
    """Partners of the loop. None of them ever makes it wait."""

    port: Port
    mailbox: Mailbox
    ring: RingWriter
    events: EventWriter
    heartbeat: Heartbeat
    clock: Clock
    configure: Callable[[str, Array], Iterator[str]]
    """Have the controller go by the settings of this key, a piece of the work at a time; takes the
    newest readings. The last piece says what becomes of it."""


def _tick_calls(
    memory: LoopMemory, pace: LoopPace, state: Array
) -> tuple[Callable[..., None], Callable[..., None]]:
    """`loop_tick.begin` and `loop_tick.conclude`, compiled and looked up once."""
    found = (
        TypedCall(loop_tick.begin, lambda *_: 0).find((memory, pace, TickTime(0, 0, 0, 0.0), 0)),
        TypedCall(loop_tick.conclude, lambda *_: 0).find((memory, pace, state, False)),
    )
    loop_tick.is_resting(memory.outputs)
    return found


class ControlLoop:
    """A tick after the other."""

    def __init__(self, call: RealTimeCall, around: Around, period_s: float) -> None:
        """call: the controller, started with the head where it is."""
        self.call, self.around = call, around
        self.pace = LoopPace(period_s, round(STALE_S / period_s))
        self.look_ticks = round(LOOK_S / period_s)
        self.row = np.zeros(len(ROW_COLUMNS))
        """By `ROW_COLUMNS`; of the last tick between two of them."""
        inputs, outputs = self.row[_INPUTS], self.row[_OUTPUTS]
        counts = np.zeros(loop_tick.COUNTS, np.int64)
        counts[loop_tick.RESET] = NEVER
        sent = np.zeros(len(MESSAGE_COLUMNS))
        times = self.row[:_TIMING]
        times[_LEFT_REST] = AT_REST
        self.memory = LoopMemory(times, inputs, outputs, self.row[_STATE], sent, counts)
        self.readings = inputs[_READINGS]
        self._decide = call.bind(inputs, outputs)
        self._begin, self._conclude = _tick_calls(self.memory, self.pace, call.state_row)
        self._pressed = False
        self._pieces: Iterator[str] | None = None
        """Of other settings that are being taken up."""
        self._computed_s = 0.0
        self._lost_until = dict.fromkeys(WATCHED, 0)
        self._deaths = {process: around.heartbeat.deaths(process) for process in WATCHED}
        self.stopping = False
        """Whoever runs it wants to end: the catheter comes out first."""

    @property
    def tick(self) -> int:
        """Number of the next one."""
        return int(self.memory.counts[loop_tick.TICK])

    @property
    def is_resting(self) -> bool:
        """True while it waits for a person."""
        return self.tick > 0 and loop_tick.is_resting(self.memory.outputs)

    @property
    def is_left_alone(self) -> bool:
        """True while nobody wants anything of it: it only ticks."""
        busy = self.stopping or self._pressed or self._pieces is not None
        return not busy and self.around.mailbox.is_quiet

    def step(self, deadline_ns: int, skipped: int) -> None:
        """One tick. deadline_ns: when it was due. skipped: how many were missed before it."""
        memory, clock = self.memory, self.around.clock
        begun_ns = clock.monotonic_ns()
        number = self.around.port.read(self.readings)
        time = TickTime(deadline_ns, begun_ns, skipped, self._computed_s)
        self._begin(memory, self.pace, time, number)
        requests = self._hear()
        if self.tick % self.look_ticks == 0:
            self._look_around()
        self._decide()
        self._conclude(memory, self.pace, self.call.state_row, requests.reset)
        self.around.port.write(memory.sent)
        self.around.ring.write(self.row)
        self._computed_s = (clock.monotonic_ns() - begun_ns) * 1e-9

    def _hear(self) -> Requests:
        """Requests of people in this tick."""
        requests, answers = self.around.mailbox.receive()
        if self.stopping:
            requests = requests._replace(abort=True)
        if requests is not NO_REQUESTS or self._pressed:
            self.memory.inputs[_REQUESTS] = requests
            self._pressed = requests is not NO_REQUESTS
        asked = self.around.mailbox.setting
        if asked is not None and (verdict := self._set(asked.key, requests)):
            self.around.mailbox.setting, self._pieces = None, None
            answers.append(mailbox.answer(asked, verdict))
        if requests.reset and self.is_resting:
            # It may have stood still for as long as the drives wait, and know nothing of it.
            self.memory.counts[loop_tick.RELEASED] = self.tick
        for answer in answers:
            self.around.events.write("request", self.tick, **answer._asdict())
        return requests

    def _set(self, key: str, requests: Requests) -> str:
        """Go by other settings, a piece in each tick; what became of it, empty until it is done.

        Only while nothing moves and nobody wants anything else.
        """
        if self.memory.outputs[_PHASE] != Phase.PARKED or requests is not NO_REQUESTS:
            return "not at rest"
        if self._pieces is None:
            self._pieces = self.around.configure(key, self.readings)
        verdict = next(self._pieces)
        if verdict == SET:
            self.around.events.write(CONFIGURED, self.tick)
        return verdict

    def _look_around(self) -> None:
        """Give a sign of life, and look who else does."""
        heartbeat = self.around.heartbeat
        heartbeat.beat(Process.CONTROL)
        lost, running_s = 0, self.tick * self.pace.period_s
        for process, condition in WATCHED.items():
            signs = heartbeat.signs(process)
            if is_lost(signs, self._deaths[process], running_s):
                self._deaths[process] = signs.deaths
                self._lost_until[process] = self.tick + round(LOST_S / self.pace.period_s)
            if self.tick < self._lost_until[process]:
                lost |= condition
        self.memory.inputs[_CONDITIONS] = lost


_ROW_EVENT_TICK, _ROW_EVENT_PHASE, _CAUSE, _TRIPS, _ROW_EVENT_PRESENT, _ROW_EVENT_LATCHED = (
    ROW_COLUMNS.index(name)
    for name in (
        "inputs.tick",
        "outputs.phase",
        "outputs.cause",
        "outputs.verdict.trips",
        "outputs.signals.present",
        "outputs.signals.latched",
    )
)
_WATCHED_COLUMNS = (_ROW_EVENT_PHASE, _TRIPS, _ROW_EVENT_PRESENT, _ROW_EVENT_LATCHED)


class Seen(NamedTuple):
    """State in the row before, to find changes by."""

    phase: int
    trips: int
    told: int
    """Conditions that people are told."""


NOTHING = Seen(-1, 0, 0)


def told(rows: Array) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
    """Conditions that people shall be told, in each row."""
    return rows[:, _ROW_EVENT_PRESENT].astype(np.int64) | rows[:, _ROW_EVENT_LATCHED].astype(
        np.int64
    )


def seen_in(row: Array) -> Seen:
    """State in a row."""
    present, latched = int(row[_ROW_EVENT_PRESENT]), int(row[_ROW_EVENT_LATCHED])
    return Seen(int(row[_ROW_EVENT_PHASE]), int(row[_TRIPS]), present | latched)


def is_steady(rows: Array, columns: Sequence[int]) -> bool:
    """True where none of these columns changes within the rows, of which there are some."""
    watched = rows[:, columns]
    return bool((watched == watched[0]).all())


def find(rows: Array, before: Seen) -> Iterator[tuple[int, RecordedEvent]]:
    """Events with the index of their row. before: of the row before the first."""
    if is_steady(rows, _WATCHED_COLUMNS) and seen_in(rows[0]) == before:
        return
    watched = np.stack((rows[:, _ROW_EVENT_PHASE], rows[:, _TRIPS], told(rows)))
    changes = np.diff(watched, axis=1, prepend=np.array(before, float)[:, np.newaxis]).any(axis=0)
    for at in np.flatnonzero(changes):
        row = rows[at]
        tick, now = int(row[_ROW_EVENT_TICK]), seen_in(row)
        if now.phase != before.phase:
            cause = int(row[_CAUSE])
            detail = f"after {name_of(Transition(cause))}" if cause >= 0 else ""
            yield int(at), RecordedEvent(tick, "phase", name_of(Phase(now.phase)), detail)
        for number in condition_mask.decode(now.trips & ~before.trips):
            yield int(at), RecordedEvent(tick, "trip", name_of(Condition(number)))
        for number in condition_mask.decode(now.told ^ before.told):
            detail = "raised" if now.told >> number & 1 else "ended"
            yield int(at), RecordedEvent(tick, "alarm", name_of(Condition(number)), detail)
        before = now


def of_happening(happening: ProcessEvent) -> RecordedEvent:
    """Recorded event of one that the loop has told."""
    fields = happening.fields
    return RecordedEvent(
        int(fields.get("tick", 0)),
        str(fields["kind"]),
        str(fields.get("ask", fields.get("what", fields["kind"]))),
        str(fields.get("verdict", fields.get("detail", ""))),
        str(fields.get("who", "")),
        str(fields.get("key", "")),
    )
