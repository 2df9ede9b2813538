"""How long a cycle is watched once its machine rests: until nothing of it reaches the patient.

Then the patient is followed alone: saturation is lowest, and shown so late, that the worst of it
comes when the catheter has long been out.
"""

from collections.abc import Sequence

import numpy as np

from opensuction.oracle import exposure
from opensuction.simulation import idle_time
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.simulation.injection.faulty_run import FaultyRun
from opensuction.simulation.injection.run_judgement import PatientAlone
from opensuction.simulation.trace import NOBODY, Columns, Watcher
from opensuction.twin.fault.fault_row import PatientEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.machine import Machine

WATCHED_S = 60.0
"""Machine and patient together: no bound of a patient is longer, nor the time in which a person
must be told."""
PIECE_S = 3.0
"""Between two looks whether the machine can still do anything."""
LOOK_S = 5.0
"""Between two looks at the patient alone: half a minute takes the saturation to its least."""
IN_PIECES = Watcher(NOBODY.hear, 5.0)
"""As long as what is written of them fits into a processor's caches."""
STILL_MM = 0.005
"""Way of a head that stands still, in a piece: 0.1 mm in the longest watch [design]."""


def watch(going: FaultyRun, machine: Machine, injections: Sequence[Injection] = ()) -> float:
    """Follow a run until its machine rests, and as long as it may do anything; returns that, s.

    machine: as it was built. injections: faults of the run.
    """
    injection.follow(going, 0.0, 0, IN_PIECES)
    rested = going.done
    last = rested + round(WATCHED_S / DT_S)
    may_end = not any(_goes_on(one) for one in injections)
    while going.done < last:
        until = min(going.done + round(PIECE_S / DT_S), last)
        while going.done < until:
            going.advance(until - going.done)
        if may_end and going.is_over and is_quiet(machine, going.columns):
            break
    return (going.done - rested) * DT_S


def _goes_on(injection: Injection) -> bool:
    """Whether a fault may do something new after a piece in which it did nothing.

    One of the patient may: it goes on by itself, and what is told of it depends on the machine. So
    may one of the machine that changes more slowly than by turns of half a piece.
    """
    row = ROWS[injection.fault]
    if isinstance(row.effect, PatientEffect):
        return True
    return row.course is not None and 2.0 * row.course.step_s(injection.strength) > PIECE_S


def is_quiet(machine: Machine, columns: Columns) -> bool:
    """Whether nothing reached the patient in the last piece, by the truth, and the head stood.

    machine: as it was built. columns: of the run so far.
    """
    ticks = round(PIECE_S / DT_S)
    piece = {name: columns[name][-ticks:] for name in exposure.COLUMNS}
    borne = exposure.measure(machine, piece)
    reaches = borne.in_airway_s + borne.contact_s + borne.suction_s + borne.piece_mm
    still = float(np.ptp(columns["truth.head_mm"][-ticks:])) <= STILL_MM
    return still and reaches + borne.pressure_unsafe_s == 0.0


def follow_alone(loop: Loop, state: LoopState, duration_s: float) -> PatientAlone:
    """What a patient goes through in a time in which the machine does nothing."""
    least, most_ml = np.inf, 0.0
    for _ in range(round(duration_s / LOOK_S)):
        state = idle_time.pass_time(loop, state, LOOK_S)
        signs = state.machine.coupling.signs
        least = min(least, signs.spo2_percent)
        most_ml = max(most_ml, signs.lung_volume_loss_ml)
    return PatientAlone(least, most_ml)
