"""Observation after a cycle, until the machine at rest can do nothing new to its patient.

The patient is then followed without the machine: saturation reaches its minimum, and the oximeter
shows it, long after the catheter is out.
"""

import math
from collections.abc import Sequence

import numpy as np

from opensuction.oracle import exposure
from opensuction.oracle.exposure import PatientExposure
from opensuction.oracle.harm import AIRWAY_PRESSURE
from opensuction.simulation import annunciation, idle_time
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import catheter_retention, fault_allowance, injection
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.simulation.injection.faulty_run import FaultyRun
from opensuction.simulation.injection.run_judgement import PatientAlone
from opensuction.simulation.trace import NOBODY, Columns, Watcher
from opensuction.twin.fault.fault_row import PatientEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine.machine import Machine

WATCHED_S = 60.0
"""With the machine, and with the patient alone: no bound of a patient is longer, nor the time in
which a person must be told."""
PIECE_S = 3.0
"""Between two looks whether the machine can still do anything."""
IN_PIECES = Watcher(NOBODY.hear, 5.0)
"""As long as what is written of them fits into a processor's caches."""
STILL_MM = 0.005
"""Way of a head or a tip that stands still, in a piece: 0.1 mm in the longest watch [design]."""


def watch(
    going: FaultyRun, machine: Machine, injections: Sequence[Injection] = (), whole: bool = False
) -> float:
    """Follow a run until its machine rests, and as long as it may do anything; returns that, s.

    machine: as it was built. injections: faults of the run. whole: the longest time in any case.
    """
    injection.follow(going, 0.0, 0, IN_PIECES)
    rested = going.done
    last = rested + round(WATCHED_S / DT_S)
    may_end = not whole and not any(_changes_slowly(one) for one in injections)
    while going.done < last:
        until = min(going.done + round(PIECE_S / DT_S), last)
        while going.done < until:
            going.advance(until - going.done)
        if may_end and going.is_over and is_settled(machine, going.columns, injections):
            break
    return (going.done - rested) * DT_S


def _changes_slowly(one: Injection) -> bool:
    """True for a fault that may do something new after a piece in which it did nothing."""
    course = ROWS[one.fault].course
    return course is not None and 2.0 * course.step_s(one.strength) > PIECE_S


def is_settled(machine: Machine, columns: Columns, injections: Sequence[Injection]) -> bool:
    """True if nothing new came to the patient in the last piece, by the truth.

    The head stood, and so did the tip where it is inside; no vacuum reached the patient, whose
    pressure was as it should be; and whoever must be told had been.

    machine: as it was built. columns: of the run so far.
    """
    piece = _last_piece(columns)
    if not _stands(piece, "head_mm"):  # the most frequent reason, and the quickest to see
        return False
    borne = exposure.measure(machine, piece)
    own = any(
        one.fault == mine.fault and AIRWAY_PRESSURE in one.bounds
        for one in fault_allowance.OWN_HARM
        for mine in injections
    )
    calm = borne.suction_s == 0.0 and (own or borne.pressure_unsafe_s == 0.0)
    stands = not borne.inside_at_end or _stands(piece, "tip_mm")
    return stands and calm and _is_told(piece, borne, injections)


def _stands(piece: Columns, name: str) -> bool:
    return float(np.ptp(piece[f"truth.{name}"])) <= STILL_MM


def _last_piece(columns: Columns) -> Columns:
    ticks = round(PIECE_S / DT_S)
    names = ("truth.head_mm", *exposure.COLUMNS, *annunciation.COLUMNS)
    return {name: columns[name][-ticks:] for name in names}


def _is_told(piece: Columns, borne: PatientExposure, injections: Sequence[Injection]) -> bool:
    """True if people are shown what they must be.

    Of a catheter, or a piece of it, that is inside with high priority; of a fault of the patient
    anything.
    """
    told = annunciation.told(piece)
    if borne.inside_at_end or borne.piece_mm > 0.0:
        return not math.isnan(catheter_retention.told_s(told, -math.inf))
    patient = any(isinstance(ROWS[one.fault].effect, PatientEffect) for one in injections)
    return bool(told) or not patient


def follow_alone(going: FaultyRun, machine: Machine, duration_s: float) -> PatientAlone:
    """Exposure of a patient in a time in which the machine does nothing new.

    going: a run that has been watched. machine: as it was built.
    """
    worst = idle_time.find_worst(going.loop, going.state, duration_s)
    piece = _last_piece(going.columns)
    inside = exposure.find_inside(machine, piece["truth.tip_mm"])[-1]
    touches = (piece["truth.contact_n"] > exposure.TOUCHING_N).all()
    return PatientAlone(
        spo2_least_percent=worst.spo2_percent,
        lung_volume_loss_ml=worst.lung_volume_loss_ml,
        in_airway_s=duration_s if inside else 0.0,
        contact_s=duration_s if touches else 0.0,
    )
