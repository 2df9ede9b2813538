"""Result of a simulated cycle, from its trace and what was prepared."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from opensuction import __version__
from opensuction.kernel import arithmetic_fingerprint
from opensuction.kernel.vocabulary import AgeGroup, Phase, name_of
from opensuction.procedure.cycle.check import ORDER, CheckItem
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.result.cycle_result import (
    AbortCause,
    AlarmRecord,
    Anatomy,
    Announcement,
    BrokenBound,
    CycleFiles,
    CycleResult,
    FaultRecord,
    PhaseTime,
    PlannedCheck,
    PreUseTest,
    SecretionResult,
    SimulatedPart,
    TestedItem,
    TimingResult,
    TipResult,
    TripRecord,
    VacuumResult,
    VitalSigns,
)
from opensuction.result.plain import measured
from opensuction.safety.alarm.alarm_log import Episode
from opensuction.safety.condition import Condition, row_of
from opensuction.safety.limits import limits_of
from opensuction.session.cycle import cycle_run, resolution, summary_section
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.outcome import Abort, Annunciation, Outcome, TripTime
from opensuction.simulation.trace import Columns

IN_AIRWAY_GUIDELINE_S = {AgeGroup.ADULT: 15.0}
"""From insertion to removal, by hand [ACI-2014]; the guideline is for adults."""
ABORT_SENTENCES = {
    Event.TRIPPED: "a safety limit tripped",
    Event.ABORT_REQUESTED: "a person asked for it",
    Event.PHASE_OVERDUE: "the phase '{phase}' took longer than planned",
    Event.CONTACT_MISPLACED: "the tip touched something before the carina was expected, or "
    "nothing until the search ended",
    Event.CHECK_FAILED: "the pre-use test failed: {failed}",
}
"""Why a cycle is broken off, for every event that can."""


def _tip(result: Outcome) -> TipResult:
    return TipResult(
        target_mm=result.target_mm,
        reached_mm=result.reached_mm,
        stop_error_mm=result.reached_mm - result.target_mm,
        rmse_mm=result.rmse_mm,
        peak_error_mm=result.peak_error_mm,
        deepest_mm=result.exposure.deepest_mm,
        past_carina_mm=result.exposure.past_carina_mm,
        end_mm=result.exposure.end_mm,
        inside_at_end=result.exposure.inside_at_end,
    )


def _timing(prepared: Prepared, result: Outcome, columns: Columns) -> TimingResult:
    age = prepared.rig.site.age
    return TimingResult(
        cycle_s=result.cycle_s,
        in_airway_s=result.exposure.in_airway_s,
        in_airway_budget_s=prepared.protocol.in_airway_budget_s,
        negative_pressure_s=result.negative_pressure_s,
        negative_pressure_budget_s=prepared.protocol.negative_pressure_budget_s,
        guideline_s=GUIDELINES[age].negative_pressure_s,
        in_airway_guideline_s=IN_AIRWAY_GUIDELINE_S.get(age) if _has_patient(prepared) else None,
        followed_s=columns["time_s"].size * DT_S,
        **summary_section.of_cycle(prepared, columns)._asdict(),
    )


def _has_patient(prepared: Prepared) -> bool:
    return prepared.rig.machine.has_patient


def _vacuum(prepared: Prepared, result: Outcome) -> VacuumResult:
    return VacuumResult(
        setpoint_mmhg=prepared.protocol.vacuum_mmhg,
        peak_mmhg=result.peak_vacuum_mmhg,
        delivered_mmhg=result.delivered_vacuum_mmhg,
        tip_peak_mmhg=result.exposure.vacuum_peak_mmhg,
        guideline_mmhg=GUIDELINES[prepared.rig.site.age].vacuum_mmhg,
    )


def _vitals(prepared: Prepared, columns: Columns) -> VitalSigns | None:
    """The patient before, during and after; None where nobody is there."""
    if not _has_patient(prepared):
        return None
    site = prepared.rig.site
    limits = limits_of(site.age, site.peep_cmh2o, site.monitored)
    return summary_section.vital_signs(columns, limits, prepared.rig.machine.patient.weight_kg)


def phases(columns: Columns) -> tuple[PhaseTime, ...]:
    """Phases of a run, each with its beginning and end."""
    return tuple(
        PhaseTime(span.phase.name.lower(), span.start_s, span.end_s)
        for span in trace.phase_spans(columns)
    )


def trips(found: Iterable[TripTime]) -> tuple[TripRecord, ...]:
    """Safety limits that tripped, when each did first."""
    return tuple(TripRecord(name_of(code), code.row.sentence, time_s) for code, time_s in found)


def alarms(found: Iterable[Episode]) -> tuple[AlarmRecord, ...]:
    """Alarms with sentence and remedy; none in a healthy cycle."""
    return tuple(
        AlarmRecord(
            condition=alarm_name(episode.condition),
            priority=name_of(episode.priority),
            sentence=row_of(episode.condition).sentence,
            remedy=row_of(episode.condition).remedy,
            started_s=episode.started_s,
            ended_s=episode.ended_s,
            latched=episode.latched,
            acknowledged_s=episode.acknowledged_s,
        )
        for episode in found
    )


def told(found: Iterable[Annunciation]) -> tuple[Announcement, ...]:
    """Notices that the annunciator at the bedside showed, when, and who raised them."""
    return tuple(
        Announcement(
            what=name_of(one.condition),
            at_s=one.at_s,
            by=one.by,
            priority=name_of(one.condition.row.handling.priority),
            sentence=one.condition.row.sentence,
            remedy=one.condition.row.remedy,
        )
        for one in found
    )


def alarm_name(condition: int) -> str:
    """A condition as the JSON writes it; one without a name has its number."""
    known = condition in set(Condition)
    return name_of(Condition(condition)) if known else f"unknown-{condition}"


def abort(found: Abort | None, columns: Columns) -> AbortCause | None:
    """Cause of a broken-off cycle; the trips say more where there are any."""
    if found is None:
        return None
    event, phase, time_s = found
    if event not in ABORT_SENTENCES:  # the controller stopped: it broke nothing off
        return None
    failed = CheckItem(int(columns["check_failed"][-1])).failure
    return AbortCause(
        event=name_of(event),
        phase=phase.name.lower(),
        sentence=ABORT_SENTENCES[event].format(phase=phase.name.lower(), failed=failed),
        time_s=time_s,
    )


def check(columns: Columns, dt_s: float = DT_S) -> PreUseTest:
    """The pre-use test: whether it was passed, what failed, each item with its time.

    dt_s: length of a tick.
    """
    failed = CheckItem(int(columns["check_failed"][-1]))
    testing = columns["phase"] == Phase.CHECKING
    tested = columns["check_item"][testing]
    ticks = {item: np.count_nonzero(tested == item) for item in ORDER}
    return PreUseTest(
        passed=bool(failed == CheckItem.NONE and all(ticks.values()) and not testing[-1]),
        failed_item=None if failed == CheckItem.NONE else name_of(failed),
        sentence=None if failed == CheckItem.NONE else failed.failure,
        items=tuple(
            TestedItem(
                name=name_of(item),
                meaning=item.title,
                passed=item != failed if ticks[item] else None,
                seconds=ticks[item] * dt_s,
            )
            for item in ORDER
        ),
    )


def _simulated(
    prepared: Prepared, result: Outcome, faults: tuple[FaultRecord, ...]
) -> SimulatedPart:
    """Facts that only the twin and the command know; not yet timed."""
    choice, equipment, kind = (
        prepared.resolved.choice,
        prepared.resolved.equipment,
        prepared.rig.kind,
    )
    return SimulatedPart(
        conduit=summary_section.conduit_name(kind.catheter, kind.conduit),
        spread=equipment.spread,
        gap_scale=choice.gap_scale,
        tip_shift_mm=choice.tip_shift_mm,
        taught_mm=prepared.taught_mm,
        teaching=summary_section.teaching(prepared),
        told=told(result.told),
        broken_bounds=tuple(BrokenBound(*one) for one in result.harm),
        checks=tuple(
            PlannedCheck(**one._asdict(), ok=one.ok) for one in cycle_run.checks(prepared)
        ),
        identification=summary_section.identification(prepared),
        wall_s=None,
        realtime_factor=None,
        faults=faults,
    )


def summary(
    prepared: Prepared, columns: Columns, faults: tuple[FaultRecord, ...] = ()
) -> CycleResult:
    """Everything about one cycle. faults: that were injected, and what noticed them."""
    result = cycle_run.figures(prepared, columns)
    choice, equipment = prepared.resolved.choice, prepared.resolved.equipment
    found = CycleResult(
        outcome="completed" if result.completed else "aborted",
        version=__version__,
        arithmetic_fingerprint=arithmetic_fingerprint.fingerprint(),
        in_silico=True,
        machine=equipment.machine_name,
        protocol=prepared.resolved.protocol_name,
        approach=choice.approach,
        compensation=choice.compensation,
        patient=equipment.patient_name,
        catheter=summary_section.catheter_name(prepared.rig.kind.catheter),
        seed=equipment.seed,
        phases=phases(columns),
        tip=_tip(result),
        timing=_timing(prepared, result, columns),
        vacuum=_vacuum(prepared, result),
        carina_force_peak_n=result.exposure.force_peak_n,
        secretion=SecretionResult(result.removed_ml, result.removed_percent),
        spo2_nadir_percent=result.exposure.spo2_least_percent,
        lung_volume_loss_ml=result.exposure.lung_volume_loss_ml,
        airway_pressure_least_cmh2o=result.exposure.airway_pressure_least_cmh2o,
        vitals=_vitals(prepared, columns),
        preoxygenation=resolution.on_record(columns),
        check=check(columns),
        abort=abort(result.abort, columns),
        trips=trips(result.trips),
        alarms=alarms(result.alarms),
        harm=tuple(one.name for one in result.harm),
        warnings=tuple(summary_section.warnings(prepared, result)),
        anatomy=Anatomy(
            tube_end_mm=0.0,
            patient_boundary_mm=prepared.rig.site.boundary_mm,
            carina_mm=prepared.rig.machine.airway.carina_mm,
            cap_mm=prepared.protocol.cap_mm,
        ),
        simulated=_simulated(prepared, result, faults),
    )
    return measured(found)


def timed(result: CycleResult, wall_s: float, realtime_factor: float = math.nan) -> CycleResult:
    """The same result with the times that its computation took.

    wall_s: of the whole command so far. realtime_factor: simulated time over the time that the
    compiled simulation alone took, trace included; nan: not measured.
    """
    return _with_simulated(result, wall_s=wall_s, realtime_factor=realtime_factor)


def filed(
    result: CycleResult, wall_s: float, trace: str | None, recording: str | None
) -> CycleResult:
    """The same result with its files, and the time of the whole command."""
    return _with_simulated(result, wall_s=wall_s, files=CycleFiles(trace, recording))


def _with_simulated(result: CycleResult, **changes: Any) -> CycleResult:
    if result.simulated is None:
        return result
    return measured(result._replace(simulated=result.simulated._replace(**changes)))
