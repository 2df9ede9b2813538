"""Numbers of a control loop's tick around the controller's step: its times, and what is sent.

Whoever runs the loop reads the machine before `begin`, steps the controller between it and
`conclude`, and sends afterwards. All arrays but the state are views of the loop's one row, or its
own.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller.real_time_call import INPUT_COLUMNS, OUTPUT_COLUMNS, STATE_COLUMNS
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import RESTING

AT_REST = -1.0
"""Tick in which the machine left its rest, while it rests."""
RELEASED_S = 0.2
"""For how long a controller says that drives which act on their own shall obey it again: once it
has started, and once a person has reset a machine at rest. Whoever drives the machine looks for a
new controller now and then."""
RESET_S = 0.06
"""For how long a person's reset is sent to the bedside: one that comes as the controller has just
started would not be heard in its one tick. No longer, for what comes meanwhile is put out with it.
"""
NEVER = -1_000_000
"""Tick of what has not been yet."""
TICK, NUMBER, SAME, RELEASED, RESET = range(5)
"""Places of a loop's counts: number of the next tick; number of the newest readings, and for how
many ticks they have been the same; tick in which the drives were released, and in which a person
has reset."""
COUNTS = 5

_TICK, _DT, _OVERRUN = (INPUT_COLUMNS.index(name) for name in ("tick", "dt_s", "host.overrun"))
_VALID = np.array([i for i, name in enumerate(INPUT_COLUMNS) if name.endswith("_valid")])
_PHASE = OUTPUT_COLUMNS.index("phase")
_PRESENT, _LATCHED = (OUTPUT_COLUMNS.index(name) for name in ("signals.present", "signals.latched"))
_WANTED, _RESET, _RELEASED, _SPEED = (
    MESSAGE_COLUMNS.index(name) for name in ("wanted", "reset", "released", "head_mm_per_s")
)
_COMMANDED_SPEED = STATE_COLUMNS.index("core.governor.last.head_mm_per_s")
_RESTING = np.array(sorted(int(phase) for phase in RESTING))


def _first(columns: tuple[str, ...]) -> tuple[int, int]:
    """First of a row's commands, and their number."""
    found = [i for i, name in enumerate(columns) if name.startswith("commands.")]
    return found[0], len(found)


_COMMANDS, _COUNT = _first(OUTPUT_COLUMNS)
_SENT_COMMANDS, _ = _first(MESSAGE_COLUMNS)


class LoopPace(NamedTuple):
    """Times of a loop."""

    period_s: float
    stale_ticks: int
    """For so many the same readings may come: from then on they are none."""


class TickTime(NamedTuple):
    """Times of a tick."""

    deadline_ns: int
    """When it was due."""
    begun_ns: int
    skipped: int
    """Ticks that were missed before it."""
    computed_s: float
    """Duration of the tick before."""


class LoopMemory(NamedTuple):
    """Memory that a tick changes."""

    times: Array
    """Deadline in s, lateness in s, duration of the tick before in s, ticks skipped, and the tick
    in which the machine left its rest."""
    inputs: Array
    """By `real_time_call.INPUT_COLUMNS`."""
    outputs: Array
    """By `real_time_call.OUTPUT_COLUMNS`."""
    state: Array
    """The controller's after the tick, by `real_time_call.STATE_COLUMNS`."""
    sent: Array
    """By `kernel.interface.MESSAGE_COLUMNS`."""
    counts: npt.NDArray[np.int64]


@compiled
def begin(memory: LoopMemory, pace: LoopPace, time: TickTime, number: int) -> None:
    """Note a tick's times among its inputs; its readings are none where they have come too often.

    number: of the readings that have been read.
    """
    counts, inputs, times = memory.counts, memory.inputs, memory.times
    times[0] = time.deadline_ns * 1e-9
    times[1] = (time.begun_ns - time.deadline_ns) * 1e-9
    times[2] = time.computed_s
    times[3] = time.skipped
    inputs[_TICK] = counts[TICK]
    inputs[_DT] = pace.period_s
    inputs[_OVERRUN] = time.skipped > 0
    counts[SAME] = counts[SAME] + 1 if number == counts[NUMBER] else 0
    counts[NUMBER] = number
    if counts[SAME] > pace.stale_ticks:
        for i in range(_VALID.size):
            inputs[_VALID[i]] = 0.0


@compiled
def is_resting(outputs: Array) -> bool:
    """True of outputs with which a machine waits for a person."""
    for i in range(_RESTING.size):
        if outputs[_PHASE] == _RESTING[i]:
            return True
    return False


@compiled
def conclude(memory: LoopMemory, pace: LoopPace, state: Array, reset: bool) -> None:
    """Fill in what is sent and the rest of the row, and count the tick.

    state: of the controller now. reset: a person has reset the machine in this tick.
    """
    counts, outputs, sent = memory.counts, memory.outputs, memory.sent
    tick = counts[TICK]
    for i in range(_COUNT):
        sent[_SENT_COMMANDS + i] = outputs[_COMMANDS + i]
    sent[_WANTED] = np.int64(outputs[_PRESENT]) | np.int64(outputs[_LATCHED])
    if reset:
        counts[RESET] = tick
    sent[_RESET] = (tick - counts[RESET]) * pace.period_s <= RESET_S
    sent[_SPEED] = state[_COMMANDED_SPEED]
    sent[_RELEASED] = (tick - counts[RELEASED]) * pace.period_s <= RELEASED_S
    if is_resting(outputs):
        memory.times[4] = AT_REST
    elif memory.times[4] == AT_REST:
        memory.times[4] = tick
    memory.state[:] = state
    counts[TICK] = tick + 1
