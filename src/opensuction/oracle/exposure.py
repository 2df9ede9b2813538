"""Exposure of a patient in a run: depth, force, vacuum, times; by the truth, summed over the run.

Nothing here knows the controller's estimates, readings, commands or phases: a catheter without
torque is in the airway as long as it is there, and two stretches of suction count with the sum of
their lengths. Depths are those of the tip below the tube's lower end, mm.

Coughs, breaths and movements are the patient's own. The carina is where it is at that instant.
Pressure and lung volume are judged by those of the same lung under the same suction, ventilator and
faults whose muscles never moved: a cough's pressure is not the machine's doing, and a cough that
hides the effect of suction does not excuse it. A tip that a coughing carina pushes back and
releases again has not advanced. Force and contact count as they are, whoever moved.

Bounds for the patient by age, from clinical sources alone, not from the machine's own limits.

The controller has tighter limits of its own; they are not considered here. Each bound has its
source in `SOURCES`. Tags: docs/sources.md.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.twin.machine.machine import Machine


class AgeBounds(NamedTuple):
    """Bounds on the exposure of a patient of an age in a run; times are sums over all stretches."""

    contact_s: float
    """With the tip on the carina."""
    vacuum_mmhg: float
    """At the tip, in the airway."""
    suction_s: float
    """With vacuum at the tip, in the airway; `CLOSING_S` comes on top."""
    in_airway_s: float
    """With the tip below the tube's upper end."""
    pressure_s: float
    """With the airway's pressure too low or too high."""
    pressure_most_cmh2o: float
    """A higher one is too high."""
    lung_loss_ml_per_kg: float
    """Of end-expiratory volume, for each kilogram of predicted weight."""
    spo2_percent: float
    """Least saturation."""


BOUNDS: dict[AgeGroup, AgeBounds] = {
    AgeGroup.ADULT: AgeBounds(3.0, 200.0, 15.0, 30.0, 5.0, 40.0, 11.0, 83.0),
    AgeGroup.CHILD: AgeBounds(3.0, 120.0, 5.0, 20.0, 1.5, 35.0, 11.0, 83.0),
    AgeGroup.NEONATE: AgeBounds(3.0, 100.0, 5.0, 20.0, 1.5, 30.0, 11.0, 83.0),
}
"""Bounds by age group."""

FORCE_N = 0.3
"""[design-force] Force on the carina: a third of what punctures."""
ADVANCE_MM = 0.5
"""[design] Way in under vacuum: what a tip does while it settles, and no mucosa is stripped by."""
CLOSING_S = 1.0
"""[design] A time limit ends with the order to close: the cam's stroke of 0.5 s, and as much for
noticing and for what the line still holds."""
LOST_CMH2O = 5.0
"""[design-lung] Pressure below PEEP at which lung volume is being lost."""

SOURCES: dict[str, str] = {
    "contact_s": "[design-contact] 2 s, for a tip that closes its switch presses with more than "
    "the 30 mmHg of capillaries; 1 s in which a head at 30 mm/s crosses the widest gap, 26 mm",
    "vacuum_mmhg": "adult: under 200, child: under 120, [AARC-2022]; neonate: 80 to 100, "
    "[AARC-2010] [K]",
    "suction_s": "adult: at most 15, [AARC-2022]; child and neonate: under 5, [ATS-2000] and "
    "[paper] II-A",
    "in_airway_s": "[calc-apnoea] from total apnoea to a saturation of 90 %: an adult at room air "
    "30, an infant of 5 kg on 30 % oxygen 20; a catheter blocks a third of the tube at most",
    "pressure_s": "[calc-apnoea] a sixth of what apnoea at room air leaves until 90 %: an adult "
    "has 30, a child of 10 kg 9, a neonate no more",
    "pressure_most_cmh2o": "usual upper alarm limit of ventilators [assumed]",
    "lung_loss_ml_per_kg": "[Maggiore-2003] closed suction of adults loses 531 mL, SD 228: a "
    "standard deviation above that, over 70 kg; for other ages likewise [assumed], their lungs "
    "hold as much for each kilogram",
    "spo2_percent": "[assumed] 88, the least aimed at in acute lung injury [K], less 5 that "
    "suction may take [Simarmata-2019]",
}
"""Where each bound comes from."""


Truth = Mapping[str, Array]
"""Columns of a run by name, at least `COLUMNS`, one entry a tick."""
COLUMNS = (
    "time_s",
    "truth.tip_mm",
    "truth.piece_mm",
    "truth.tip_vacuum_mmhg",
    "truth.contact_n",
    "truth.carina_shift_mm",
    "truth.relaxed_pressure_cmh2o",
    "truth.relaxed_loss_ml",
    "truth.spo2_percent",
)
"""What is looked at."""
Ticks = npt.NDArray[np.bool_]

SUCKING_MMHG = 1.0
"""A tip with less draws nothing."""
TOUCHING_N = 0.01
"""Less force on the carina is no contact."""
BENCH_MARGIN_MM = 1.0
"""The bench has no patient: what is deeper by this than the tip lay at first is inside."""


class PatientExposure(NamedTuple):
    """Exposure of the patient; nan where there is no patient to bear it."""

    inside_at_end: bool
    """The tip is still in the airway."""
    end_mm: float
    """Where the tip is now."""
    outside_mm: float
    """A tip that is no deeper is out of the airway."""
    piece_mm: float
    """Length of a piece of the catheter that lies in the airway at the end; 0 for none."""
    in_airway_s: float
    suction_s: float
    """With vacuum at the tip, in the airway."""
    vacuum_peak_mmhg: float
    """At the tip, in the airway."""
    advance_mm: float
    """How far the tip went in under vacuum, all stretches together."""
    deepest_mm: float
    past_carina_mm: float
    """How far the tip went beyond where the carina was then without a catheter; at least 0."""
    force_peak_n: float
    contact_s: float
    pressure_unsafe_s: float
    """With the airway 5 cmH2O below PEEP or lower, or above what a ventilator's alarm lets pass;
    less what the patient's own muscles do."""
    airway_pressure_least_cmh2o: float
    lung_volume_loss_ml: float
    spo2_least_percent: float


def outside_mm(machine: Machine, tip_mm: Array) -> float:
    """Deepest position of the tip out of the airway: the tube's upper end."""
    if machine.has_patient:
        return -machine.patient.tube_length_mm
    return float(tip_mm[0]) + BENCH_MARGIN_MM


def find_inside(machine: Machine, tip_mm: Array) -> Ticks:
    """True in the ticks of a whole run in which the tip was in the airway."""
    inside: Ticks = tip_mm > outside_mm(machine, tip_mm)
    return inside


def _find_unsafe_pressure(machine: Machine, truth: Truth) -> Ticks:
    """True in ticks in which the airway's pressure was too low or too high; never on the bench."""
    pressure, person = truth["truth.relaxed_pressure_cmh2o"], machine.patient
    if not machine.has_patient:
        return np.zeros(pressure.size, dtype=np.bool_)
    least = person.ventilator.peep_cmh2o - LOST_CMH2O
    unsafe: Ticks = pressure < least
    return unsafe | (pressure > BOUNDS[AgeGroup(person.age_group)].pressure_most_cmh2o)


def _lengths_s(time_s: Array) -> Array:
    """Length of each tick; the last one as the one before it, one alone has none."""
    if time_s.size < 2:
        return np.zeros_like(time_s)
    lengths: Array = np.diff(time_s, append=2.0 * time_s[-1] - time_s[-2])
    return lengths


def trace_advance_mm(position_mm: Array, counts: Ticks) -> Array:
    """Net advance so far within each unbroken stretch in which ``counts`` holds; 0 elsewhere."""
    found = np.zeros_like(position_mm)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], counts.astype(np.int8), [0]))))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        part = position_mm[first:last]
        found[first:last] = part - np.minimum.accumulate(part)
    return found


def advance_mm(position_mm: Array, counts: Ticks) -> float:
    """The furthest of each unbroken stretch in which ``counts`` holds, summed."""
    advance = trace_advance_mm(position_mm, counts)
    starts = np.flatnonzero(np.diff(np.concatenate(([0], counts.astype(np.int8)))) != 0)
    return float(np.maximum.reduceat(advance, starts).sum()) if starts.size else 0.0


def _most(values: Array, where: Ticks) -> float:
    return float(values[where].max()) if where.any() else 0.0


def _felt_shift_mm(truth: Truth) -> Array:
    """Shift of the carina when the tip met it: a tick before its place is written down anew.

    The bedside moves the carina after the tip has moved; a cough moves it by half a millimetre.
    """
    shift_mm = truth["truth.carina_shift_mm"]
    felt_mm: Array = np.concatenate((shift_mm[:1], shift_mm[:-1]))
    return felt_mm


def measure(machine: Machine, truth: Truth) -> PatientExposure:
    """Measure the exposure of the patient in a run. machine: as it was built, before any fault.

    truth: its columns, at least one tick. Raises ValueError for a value that is no number.
    """
    for name in COLUMNS:
        bad = np.flatnonzero(~np.isfinite(truth[name]))
        if bad.size:
            raise ValueError(f"{name} is no number at tick {bad[0]}")
    tip_mm, vacuum_mmhg = truth["truth.tip_mm"], truth["truth.tip_vacuum_mmhg"]
    force_n, inside = truth["truth.contact_n"], find_inside(machine, tip_mm)
    sucking = inside & (vacuum_mmhg > SUCKING_MMHG)
    shift_mm = _felt_shift_mm(truth)
    pushed = (shift_mm < 0.0) & (force_n > TOUCHING_N)
    deepest_mm = float(tip_mm.max())

    lengths_s = _lengths_s(truth["time_s"])

    def sum_s(holds: Ticks) -> float:
        """Time for which something held, all stretches together."""
        return float(lengths_s[holds].sum())

    def patient(name: str, of: np.ufunc) -> float:
        return float(of.reduce(truth[f"truth.{name}"])) if machine.has_patient else float("nan")

    return PatientExposure(
        inside_at_end=bool(inside[-1]),
        end_mm=float(tip_mm[-1]),
        outside_mm=outside_mm(machine, tip_mm),
        piece_mm=float(truth["truth.piece_mm"][-1]),
        in_airway_s=sum_s(inside),
        suction_s=sum_s(sucking),
        vacuum_peak_mmhg=_most(vacuum_mmhg, inside),
        advance_mm=advance_mm(tip_mm, sucking & ~pushed),
        deepest_mm=deepest_mm,
        past_carina_mm=max(float((tip_mm - shift_mm).max()) - machine.airway.carina_mm, 0.0),
        force_peak_n=float(force_n.max()),
        contact_s=sum_s(force_n > TOUCHING_N),
        pressure_unsafe_s=sum_s(_find_unsafe_pressure(machine, truth)),
        airway_pressure_least_cmh2o=patient("relaxed_pressure_cmh2o", np.minimum),
        lung_volume_loss_ml=patient("relaxed_loss_ml", np.maximum),
        spo2_least_percent=patient("spo2_percent", np.minimum),
    )
