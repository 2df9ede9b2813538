"""How long a cycle is watched once its machine rests: until nothing can change any more."""

from collections.abc import Iterable

import numpy as np

from opensuction.oracle import exposure
from opensuction.oracle.exposure import PatientExposure
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.faulty_run import FaultyRun
from opensuction.simulation.trace import NOBODY, Columns, Watcher
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import PatientEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.machine import Machine

WATCHED_S = 60.0
"""The longest: no bound of a patient is longer, nor the time in which a person must be told."""
PIECE_S = 5.0
"""Between two looks whether anything still changes."""
IN_PIECES = Watcher(NOBODY.hear, PIECE_S)
STILL_MM = 0.01
"""Way of a head that stands still, in a piece: 0.1 mm in the longest watch [design]."""
SLOW_PERCENT = 0.02
"""Fall of the saturation in a piece that is none: 0.2 points in the longest watch [design]."""
SLOW_SHARE = 0.001
"""Rise in a piece, of what the lung has lost, that is none [design]."""
SLOW_ML = 0.05
"""And where it has lost next to nothing [design]."""


def watch(going: FaultyRun, machine: Machine, faults: Iterable[Fault] = ()) -> float:
    """Follow a run until its machine rests, and as long as anything may change; returns that, s.

    machine: as it was built. faults: of the run. One of the patient goes on by itself, and what it
    comes to is seen late: with it the whole time is watched.
    """
    injection.follow(going, 0.0, 0, IN_PIECES)
    rested = going.done
    last = rested + round(WATCHED_S / DT_S)
    may_end = not any(isinstance(ROWS[fault].effect, PatientEffect) for fault in faults)
    while going.done < last:
        until = min(going.done + round(PIECE_S / DT_S), last)
        while going.done < until:
            going.advance(until - going.done)
        if may_end and going.is_over and is_quiet(machine, going.columns):
            break
    return (going.done - rested) * DT_S


def is_quiet(machine: Machine, columns: Columns) -> bool:
    """Whether the last piece shows nothing that could still come to anything, by the truth.

    The tip is out and the head stands, no vacuum, no contact, the pressure as it should be;
    saturation and lung volume are on their way back, or stay.

    machine: as it was built. columns: of the run so far.
    """
    ticks = round(PIECE_S / DT_S)
    piece = {name: columns[name][-ticks:] for name in exposure.COLUMNS}
    return (
        _is_left_alone(exposure.measure(machine, piece))
        and float(np.ptp(columns["truth.head_mm"][-ticks:])) <= STILL_MM
        and _has_turned(piece)
    )


def _is_left_alone(borne: PatientExposure) -> bool:
    """Whether nothing reaches the patient any more."""
    touches = borne.in_airway_s + borne.contact_s + borne.piece_mm
    return touches + borne.suction_s + borne.pressure_unsafe_s == 0.0


def _has_turned(piece: Columns) -> bool:
    """Whether what the patient has lost comes back, or is as it was."""
    spo2, lost_ml = piece["truth.spo2_percent"], piece["truth.lung_volume_loss_ml"]
    more_ml = float(lost_ml.max() - lost_ml[0])
    falls = float(spo2[0] - spo2[-1])
    return falls <= SLOW_PERCENT and more_ml <= max(SLOW_SHARE * float(lost_ml[0]), SLOW_ML)
