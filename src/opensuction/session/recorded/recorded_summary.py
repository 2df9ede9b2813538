"""Result of a recorded cycle, from its machine's readings and its controller's estimates.

The record is that of a simulated cycle, so that the same report shows both. What only the twin
knows is None, and no bound for the patient is judged: that takes the truth.
"""

from typing import Literal

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import ON_PLAYS
from opensuction.hysteresis import modified_dahl
from opensuction.kernel.vocabulary import Phase
from opensuction.result.cycle_result import (
    RECORDED,
    AbortCause,
    Anatomy,
    ContactRecord,
    CycleResult,
    RecordedPart,
    SecretionResult,
    SignCourse,
    TimingResult,
    TipResult,
    VacuumResult,
    VitalSigns,
)
from opensuction.result.plain import measured
from opensuction.safety.alarm import alarm_log
from opensuction.session.cycle import cycle_summary, resolution, summary_section
from opensuction.session.cycle.summary_section import WINDOW_S
from opensuction.session.recorded.recorded_cycle import RecordedCycle
from opensuction.settings.wording import one_line
from opensuction.simulation import outcome, trace
from opensuction.simulation.outcome import VENTED_MMHG
from opensuction.simulation.trace import Columns

UNKNOWN = "none"
"""Of a heading's entry that is not there."""
BROKEN_OFF = "the recording ends before the cycle does"
CUT = "the report ends before the recording does: it holds more than a cycle"
Values = npt.NDArray[np.float64]


def gap_mm(cycle: RecordedCycle) -> float:
    """Width of the transmission's gap that the compensation went by, mm of tip."""
    compensation = cycle.settings.compensation
    if compensation.kind in ON_PLAYS:
        plays = compensation.plays
        pairs = zip(plays.thresholds_mm, plays.weights, strict=True)
        return 2.0 * sum(threshold_mm * weight for threshold_mm, weight in pairs)
    return float(modified_dahl.gap_mm(compensation.model))


def _extreme(values: Values, highest: bool) -> float | None:
    known = values[np.isfinite(values)]
    if not known.size:
        return None
    return float(known.max() if highest else known.min())


def touched_mm(cycle: RecordedCycle) -> float | None:
    """Depth of the tip by the controller when it met the carina; None where it did not."""
    phase = cycle.columns["phase"]
    met = np.flatnonzero(phase == Phase.BACKING_OFF)
    return float(cycle.columns["procedure.touched_mm"][met[0]]) if met.size else None


def _target_mm(cycle: RecordedCycle) -> float | None:
    """Planned depth of suction; None where contact should have set it and did not."""
    plan = cycle.settings.plan
    if not plan.contact.enabled:
        return plan.motion.target_mm
    met_mm = touched_mm(cycle)
    return None if met_mm is None else met_mm - plan.contact.backoff_mm


def _tip(cycle: RecordedCycle) -> TipResult:
    columns, limits = cycle.columns, cycle.settings.limits
    tip_mm, phase = columns["estimate.tip_mm"], columns["phase"]
    sucking = np.flatnonzero(phase == Phase.SUCTIONING)
    reached_mm = float(tip_mm[sucking[0]] if sucking.size else tip_mm.max())
    target_mm = _target_mm(cycle)
    return TipResult(
        target_mm=target_mm,
        reached_mm=reached_mm,
        stop_error_mm=None if target_mm is None else reached_mm - target_mm,
        rmse_mm=None,
        peak_error_mm=None,
        deepest_mm=float(tip_mm.max()),
        deepest_possible_mm=float(columns["verdict.deepest_mm"].max()),
        past_carina_mm=None,
        end_mm=float(tip_mm[-1]),
        # As the governor has it: a tip that may be inside counts as inside.
        inside_at_end=bool(columns["verdict.deepest_mm"][-1] > limits.outside_mm),
    )


def _sucking(columns: Columns) -> npt.NDArray[np.bool_]:
    """Ticks with the valve perhaps open and vacuum in the line; the pre-use test's do not count."""
    drawing = columns["readings.line_vacuum_mmhg"] > VENTED_MMHG
    found: npt.NDArray[np.bool_] = (columns["durations.sucking_s"] > 0.0) & drawing
    found[columns["phase"] == Phase.CHECKING] = False
    return found


def _timing(cycle: RecordedCycle) -> TimingResult:
    columns, limits, pace = cycle.columns, cycle.settings.limits, cycle.settings.plan.pace
    resting = np.isin(columns["phase"], (Phase.PARKED, Phase.HALTED))
    return TimingResult(
        cycle_s=float(np.count_nonzero(~resting)) * cycle.dt_s,
        in_airway_s=float(np.count_nonzero(columns["durations.inside_s"] > 0.0)) * cycle.dt_s,
        in_airway_budget_s=limits.in_airway_s,
        negative_pressure_s=float(np.count_nonzero(_sucking(columns))) * cycle.dt_s,
        negative_pressure_budget_s=limits.negative_pressure_s,
        guideline_s=None,
        in_airway_guideline_s=None,
        followed_s=float(columns["time_s"][-1]) + cycle.dt_s,
        **summary_section.measure(columns, pace.nothing_comes_s, cycle.dt_s)._asdict(),
    )


def _vacuum(cycle: RecordedCycle) -> VacuumResult:
    columns = cycle.columns
    testing = columns["phase"] == Phase.CHECKING
    line_mmhg = np.where(testing, np.nan, columns["readings.line_vacuum_mmhg"])
    return VacuumResult(
        setpoint_mmhg=cycle.settings.plan.vacuum_mmhg,
        peak_mmhg=_extreme(line_mmhg, highest=True),
        limit_mmhg=cycle.settings.limits.vacuum_mmhg,
        delivered_mmhg=None,
        tip_peak_mmhg=None,
        guideline_mmhg=None,
    )


def _sign(cycle: RecordedCycle, name: str) -> SignCourse | None:
    """Course of a sign that the monitor showed; None where it did not.

    Whether it came back is not known: a recording ends soon after its cycle.
    """
    values, phase = cycle.columns[f"readings.monitor.{name}"], cycle.columns["phase"]
    going_in = np.flatnonzero(phase == Phase.INSERTING)
    before = slice(0, max(int(going_in[0]) if going_in.size else 1, 1))
    lowest = _extreme(values, highest=False)
    if lowest is None:
        return None
    return SignCourse(
        before=_extreme(values[before], highest=False),
        lowest=lowest,
        highest=_extreme(values, highest=True),
        at_end=_extreme(values[-round(WINDOW_S / cycle.dt_s) :], highest=False),
        is_back=None,
        recovered_s=None,
    )


def _vitals(cycle: RecordedCycle) -> VitalSigns | None:
    """Signs that the patient's monitor showed; None where none was connected."""
    limits = cycle.settings.limits.patient
    spo2 = _sign(cycle, "spo2_percent")
    rate = _sign(cycle, "heart_rate_per_min")
    pressure = _sign(cycle, "airway_pressure_cmh2o")
    if spo2 is None and rate is None and pressure is None:
        return None
    return VitalSigns(
        spo2_percent=spo2 and spo2._replace(limit_least=limits.spo2_percent),
        heart_rate_per_min=rate and rate._replace(limit_least=limits.heart_rate_per_min),
        airway_pressure_cmh2o=pressure
        and pressure._replace(
            usual_least=limits.airway_least_cmh2o, usual_most=limits.airway_most_cmh2o
        ),
    )


def _lowest(sign: SignCourse | None) -> float | None:
    return None if sign is None else sign.lowest


def _contact(cycle: RecordedCycle) -> ContactRecord:
    touching = cycle.columns["readings.contact_closed"] > 0.0
    return ContactRecord(
        closed_s=float(np.count_nonzero(touching)) * cycle.dt_s, touched_mm=touched_mm(cycle)
    )


def _asked(cycle: RecordedCycle, name: str) -> str | None:
    """An entry of the heading on what ran; None where there is none."""
    value = cycle.heading.about.get(name, UNKNOWN)
    return None if value == UNKNOWN else one_line(value)


Ending = tuple[Literal["completed", "aborted", "interrupted"], AbortCause | None]


def _ending(cycle: RecordedCycle) -> Ending:
    """Outcome and cause of the end: a recording may end before its cycle does."""
    columns = cycle.columns
    spans = trace.phase_spans(columns)
    abort = cycle_summary.abort(outcome.find_abort(columns), columns)
    if outcome.is_completed(spans):
        return "completed", None
    if abort is None and spans[-1].phase not in (Phase.PARKED, Phase.HALTED):
        said = CUT if cycle.is_cut else BROKEN_OFF
        phase, time_s = spans[-1].phase.name.lower(), float(columns["time_s"][-1])
        return "interrupted", AbortCause("recording-ends", phase, said, time_s)
    return "aborted", abort


def _warnings(cycle: RecordedCycle) -> list[str]:
    found = []
    if cycle.flaw is not None:
        found.append(f"The file is not whole: {cycle.flaw}.")
    if cycle.missing:
        found.append(f"{cycle.missing} ticks are missing in the recording.")
    if cycle.is_cut:
        found.append(f"{CUT[:1].upper()}{CUT[1:]}.")
    return found


def _recorded(cycle: RecordedCycle) -> RecordedPart:
    return RecordedPart(
        basis=RECORDED,
        has_truth=cycle.has_truth,
        began_utc=cycle.heading.began_utc,
        contact=_contact(cycle),
        gap_mm=gap_mm(cycle),
        missing_ticks=cycle.missing,
        flaw=cycle.flaw,
        damaged=cycle.is_damaged,
    )


def summary(cycle: RecordedCycle) -> CycleResult:
    """Everything that is known of a recorded cycle; of the truth what the twin wrote beside it."""
    columns, limits = cycle.columns, cycle.settings.limits
    ended, abort = _ending(cycle)
    vitals = _vitals(cycle)
    removed, force = columns.get("truth.secretion_removed_ml"), columns.get("truth.contact_n")
    removed_ml = None if removed is None else float(removed[-1] - removed[0])
    found = CycleResult(
        outcome=ended,
        version=one_line(cycle.heading.software_version),
        arithmetic_fingerprint=one_line(cycle.heading.fingerprint),
        in_silico="notice" in cycle.heading.about,
        machine=_asked(cycle, "machine"),
        protocol=_asked(cycle, "protocol"),
        approach=_asked(cycle, "approach"),
        compensation=_asked(cycle, "compensation"),
        patient=_asked(cycle, "patient"),
        catheter=_asked(cycle, "catheter"),
        seed=_asked(cycle, "seed"),
        phases=cycle_summary.phases(columns),
        tip=_tip(cycle),
        timing=_timing(cycle),
        vacuum=_vacuum(cycle),
        carina_force_peak_n=None if force is None else float(force.max()),
        secretion=SecretionResult(removed_ml=removed_ml, removed_percent=None),
        spo2_nadir_percent=_lowest(vitals and vitals.spo2_percent),
        lung_volume_loss_ml=None,
        airway_pressure_least_cmh2o=_lowest(vitals and vitals.airway_pressure_cmh2o),
        vitals=vitals,
        preoxygenation=resolution.on_record(columns),
        check=cycle_summary.check(columns, cycle.dt_s),
        abort=abort,
        trips=cycle_summary.trips(outcome.trip_times(columns)),
        alarms=cycle_summary.alarms(alarm_log.list_episodes(outcome.log(columns))),
        harm=None,
        warnings=tuple(_warnings(cycle)),
        anatomy=Anatomy(
            tube_end_mm=0.0,
            patient_boundary_mm=limits.outside_mm,
            carina_mm=None,
            cap_mm=limits.cap_mm,
        ),
        recorded=_recorded(cycle),
    )
    return measured(found)
