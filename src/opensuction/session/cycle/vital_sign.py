"""The patient before, during and after a cycle: each vital sign with its range.

By the twin's truth, not by what the monitor showed. A range is for a reader: outside it a report
says so. Which bound must never be broken is the oracle's to say.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.phase import Phase
from opensuction.result.cycle_result import SignCourse, VitalSigns
from opensuction.safety.patient_limit import PatientLimits
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns

USUAL_SPO2_PERCENT = 88.0
"""Least saturation aimed at in acute lung injury [K]; the alarm's limit lies lower."""
USUAL_HEART_RATE_RATIO = 0.8
"""A heart that slows by more than a fifth is worth a look [assumed]."""
USUAL_LOSS_ML_PER_KG = 7.6
"""Lung volume that closed suction takes: 531 mL [Maggiore-2003], of 70 kg [assumed]."""
WINDOW_S = 5.0
"""Longer than a breath of any patient: how long a sign must be back to count as recovered."""
SETTLED_S = 1.0
"""A run that never inserts is compared with its first second."""


class VitalSign(NamedTuple):
    """One quantity of the patient."""

    column: str
    tolerance: float
    """So far from where it was before counts as back [design]: about what a monitor resolves."""


SATURATION = VitalSign("truth.spo2_percent", 1.0)
HEART_RATE = VitalSign("truth.heart_rate_per_min", 5.0)
PRESSURE = VitalSign("truth.airway_pressure_cmh2o", 1.0)
RELAXED = "truth.relaxed_pressure_cmh2o"
LOSS = "truth.lung_volume_loss_ml"
LOSS_TOLERANCE_ML_PER_KG = 1.0
"""Lung volume that counts as back."""


def _before(columns: Columns) -> slice:
    """Ticks before the catheter goes in."""
    going_in = np.flatnonzero(columns["phase"] == Phase.INSERTING)
    first = int(going_in[0]) if going_in.size else round(SETTLED_S / DT_S)
    return slice(0, max(first, 1))


def course(columns: Columns, values: npt.NDArray[np.float64], tolerance: float) -> SignCourse:
    """Course of a quantity: before, its extremes from then on, at the end, and its recovery.

    values: one a tick. tolerance: distance from what it was before that counts as back. ``before``
    and ``at_end`` are the least of several seconds, for some quantities breathe. ``is_back``:
    within the tolerance over the last `WINDOW_S`. ``recovered_s``: since when, on the run's clock;
    None where it never left, or is not back.
    """
    early = values[_before(columns)]
    low, high = float(early.min()), float(early.max())
    away = (values < low - tolerance) | (values > high + tolerance)
    last = np.flatnonzero(away)
    recent = values[-round(WINDOW_S / DT_S) :]
    is_back = not bool(away[-recent.size :].any())
    start_s = float(columns["time_s"][0])
    recovered_s = float(columns["time_s"][last[-1]]) + DT_S - start_s if last.size else None
    return SignCourse(
        before=low,
        lowest=float(values.min()),
        highest=float(values.max()),
        at_end=float(recent.min()),
        is_back=is_back,
        recovered_s=recovered_s if is_back else None,
    )


def vital_signs(columns: Columns, limits: PatientLimits, weight_kg: float) -> VitalSigns:
    """Each sign with its course, its usual range and the alarm's limit.

    limits: of this patient's monitor. ``usual_least`` and ``usual_most`` bound what needs no look;
    ``limit_least`` and ``limit_most`` are where the monitor alarms. None: there is none. Of the
    airway pressure ``relaxed_lowest`` and ``relaxed_highest`` are those of the same lung without
    muscles, which is what the machine is judged by.
    """
    rate = _course(columns, HEART_RATE)
    return VitalSigns(
        spo2_percent=_course(columns, SATURATION)._replace(
            usual_least=USUAL_SPO2_PERCENT, limit_least=limits.spo2_percent
        ),
        heart_rate_per_min=rate._replace(
            usual_least=USUAL_HEART_RATE_RATIO * (rate.before or 0.0),
            limit_least=limits.heart_rate_per_min,
        ),
        airway_pressure_cmh2o=_course(columns, PRESSURE)._replace(
            usual_least=limits.airway_least_cmh2o,
            usual_most=limits.airway_most_cmh2o,
            # Without what the patient's own muscles do: coughs and breaths are nobody else's.
            relaxed_lowest=float(columns[RELAXED].min()),
            relaxed_highest=float(columns[RELAXED].max()),
        ),
        lung_volume_loss_ml=course(
            columns, columns[LOSS], LOSS_TOLERANCE_ML_PER_KG * weight_kg
        )._replace(usual_most=USUAL_LOSS_ML_PER_KG * weight_kg),
    )


def _course(columns: Columns, sign: VitalSign) -> SignCourse:
    return course(columns, columns[sign.column], sign.tolerance)
