"""Equipment of a cycle for its result: catheter and conduit, the machine's model, its settings.

Summary of the dwell of a cycle: its duration and the cause of its end.

Warnings of a cycle that no alarm gives, a sentence each.

The patient before, during and after a cycle: each vital sign with its range.

By the twin's truth, not by what the monitor showed. A range is for a reader: outside it a report
says so. Which bound must never be broken is the oracle's to say.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import CompensationKind
from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.result.cycle_result import SignCourse, Teaching, VitalSigns
from opensuction.result.identification_result import PlaysModel, TransmissionModel
from opensuction.result.plain import Json
from opensuction.safety.limits import PatientLimits
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.settings.calibration_section import Plays, write_section
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.outcome import Outcome
from opensuction.simulation.trace import Columns
from opensuction.twin.machine.catheter import CATHETERS, ROUTES, Catheter, Conduit, lay

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


SECRETION_SHARE_PERCENT = 80.0
"""Share of the secretions below which the report says why there is some left."""
LEAST_SHARE_PERCENT = 5.0
"""Share below which nothing was removed to speak of: depth and time do not explain that."""
BUDGET_MARGIN_S = 0.05
"""Timing that exceeds the guideline by less is rounding of a tick or two."""


def warnings(prepared: Prepared, result: Outcome) -> list[str]:
    """The key ``warnings``: suction too long or without effect, a model or file that lacks much."""
    found = (
        _of_suction(prepared, result),
        _of_secretion(result),
        _of_servo(prepared),
        _of_model(prepared),
    )
    return [sentence for sentence in found if sentence is not None]


def _of_suction(prepared: Prepared, result: Outcome) -> str | None:
    """Warning of suction longer than guidelines allow."""
    guideline_s = GUIDELINES[prepared.rig.site.age].negative_pressure_s
    if not result.negative_pressure_s > guideline_s + BUDGET_MARGIN_S:  # true of NaN
        return None
    planned = prepared.protocol.negative_pressure_budget_s > guideline_s + BUDGET_MARGIN_S
    return (
        f"Suction lasted {result.negative_pressure_s:.1f} s: guidelines allow "
        f"{guideline_s:g} s." + (" This protocol is for the bench only." if planned else "")
    )


def _of_secretion(result: Outcome) -> str | None:
    """Warning of secretions that are left after a completed cycle, with the reason."""
    if not (result.completed and result.removed_percent < SECRETION_SHARE_PERCENT):
        return None
    if result.removed_percent < LEAST_SHARE_PERCENT:
        return (
            f"Only {result.removed_percent:.0f} % of the secretions were removed: suction was "
            "without effect."
        )
    return (
        f"Only {result.removed_percent:.0f} % of the secretions were removed: the rest lies "
        "deeper than the tip may go, or did not come within the "
        f"{result.negative_pressure_s:.1f} s of suction."
    )


def _of_servo(prepared: Prepared) -> str | None:
    """Warning of a nominal feedforward where a parameter file has none."""
    file = prepared.resolved.parameter_file
    if file is None or file.servo is not None:
        return None
    return (
        "The parameter file holds no servo feedforward: the motor's nominal voltage for speed "
        "stands in for it, and nothing for friction; a calibration of the machine finds both."
    )


def _of_model(prepared: Prepared) -> str | None:
    """Warning of a modified Dahl model without an inverse, with what its compensator does."""
    kind, model = prepared.resolved.compensation, prepared.calibration.model
    on_dahl = kind in (CompensationKind.DIRECT_INVERSE, CompensationKind.EXACT_INVERSE)
    if not on_dahl or modified_dahl.is_monotone(model):
        return None
    crossing = "; the reversal is crossed as a gap."
    if kind == CompensationKind.DIRECT_INVERSE:
        crossing = ", and the printed compensator jumps there."
    return (
        f"The identified model is not monotone (c = {model.slope:.3f} is not above 2 beta = "
        f"{2 * model.velocity_gain:.3f}): at a reversal it has no continuous inverse{crossing}"
    )


ENDINGS = {
    Event.DWELL_ELAPSED: "dwell-elapsed",
    Event.NOTHING_CAME: "nothing-came",
}
"""What ends a dwell that is not broken off."""


class Dwell(NamedTuple):
    """Duration of the dwell, the cause of its end, and how long nothing may come; None: was not."""

    dwell_s: float | None
    dwell_ended_by: str | None
    nothing_comes_s: float | None


def of_cycle(prepared: Prepared, columns: Columns) -> Dwell:
    """The dwell of a simulated cycle.

    The dwell begins when the valve is asked to open, with the tip where it stopped.
    """
    return measure(columns, prepared.loop.controller.plan.pace.nothing_comes_s, DT_S)


def measure(columns: Columns, wait_s: float, dt_s: float) -> Dwell:
    """The same of a run that need not have been simulated.

    wait_s: how long nothing may come; 0 where nobody asks. dt_s: length of a tick.
    """
    phase = columns["phase"]
    there = np.isin(phase, (Phase.OPENING, Phase.SUCTIONING))
    ticks = np.count_nonzero(there & (columns["demand.valve_open"] > 0.0))
    leaving = phase == Phase.WITHDRAWING
    ended = None
    if np.any(leaving):
        ended = ENDINGS.get(Event(int(columns["cause"][int(np.argmax(leaving))])))
    return Dwell(
        dwell_s=ticks * dt_s if ticks else None,
        dwell_ended_by=ended,
        nothing_comes_s=wait_s if wait_s > 0.0 else None,
    )


def teaching(prepared: Prepared) -> Teaching | None:
    """Source of the protocol's depth, and its error."""
    if prepared.taught_mm is None:
        return None
    by_hand = prepared.resolved.choice.taught_mm is None
    return Teaching(
        source="hand" if by_hand else "given",
        error_mm=prepared.taught_mm - prepared.rig.machine.airway.carina_mm,
    )


def plays(model: PrandtlIshlinskii) -> PlaysModel:
    """The plays that `prandtl-ishlinskii` and `preview` work with, and their gap."""
    section = write_section(Plays, model)
    return PlaysModel(**section._asdict(), gap_mm=prandtl_ishlinskii.gap_mm(model))


def identification(prepared: Prepared) -> TransmissionModel | None:
    """Model of the compensator and its source; None for a compensator that needs no model."""
    found, file = prepared.identification, prepared.resolved.parameter_file
    model, feedforward = prepared.calibration.model, prepared.calibration.feedforward
    data = TransmissionModel(
        model="modified-dahl",
        **model._asdict(),
        gap_mm=float(modified_dahl.gap_mm(model)),
        rmse_mm=None,
        well_posed=bool(modified_dahl.is_monotone(model)),
        driven_model=None,
        samples=None,
        feedforward_v_s_per_mm=feedforward.velocity_v_s_per_mm,
        friction_v=feedforward.friction_v,
        file=None,
        recording=None,
        recording_sha256=None,
    )
    if found is not None:
        fitted = found.plays
        return data._replace(
            rmse_mm=found.fit.rmse_mm,
            samples=found.fit.samples,
            plays=plays(fitted.model)._replace(
                rmse_mm=fitted.rmse_mm, well_posed=fitted.well_posed
            ),
        )
    if file is None:
        return None
    by_plays = prepared.resolved.compensation == CompensationKind.MODEL_PREVIEW
    return data._replace(
        rmse_mm=file.about.rmse,
        driven_model=file.driven.model if by_plays and file.driven is not None else None,
        samples=file.about.recording.fitted_samples,
        file=prepared.resolved.choice.compensation,
        recording=file.about.recording.file,
        recording_sha256=file.about.recording.sha256,
    )


def catheter_name(catheter: Catheter) -> str:
    """Name of a catheter, or its diameters where it has none."""
    for name, known in CATHETERS.items():
        if known == catheter:
            return name
    return f"{catheter.outer_mm:g} mm, bore {catheter.bore_mm:g} mm"


def conduit_name(catheter: Catheter, conduit: Conduit) -> str:
    """Name of a conduit for a catheter, or its measures where it has none."""
    for name in ROUTES:
        if lay(name, catheter) == conduit:
            return name
    return (
        f"{conduit.length_mm:g} mm, bore {conduit.bore_mm:g} mm, bent by {conduit.bend_rad:g} rad"
    )


def sections(prepared: Prepared) -> dict[str, Json]:
    """Settings of the run for the last part of the report: title to names and values."""
    settings = prepared.loop.controller
    return {
        "Protocol": prepared.protocol._asdict(),
        "Plan": {
            "preload_s": settings.plan.preload_s,
            "dwell_s": settings.plan.dwell_s,
            "gap_lead_s": settings.plan.gap_lead_s,
            "nothing_comes_s": settings.plan.pace.nothing_comes_s,
            **settings.plan.motion._asdict(),
        },
        "Governor limits": settings.limits._asdict() | {"tip": settings.limits.tip._asdict()},
        "Insertion servo": settings.insertion_servo._asdict(),
        "Catheter": prepared.rig.kind.catheter._asdict(),
        "Conduit": prepared.rig.kind.conduit._asdict(),
        "Twin (drawn by the seed)": dict(prepared.rig.values),
    }
