"""Details of a hazard for the page of a safety case, beyond its summary."""

import math

from opensuction.evidence.campaign.healthy_cycle import AIRWAY
from opensuction.evidence.safety_case.hazard_claim import SAFE_STATES, SET_UP, Response
from opensuction.evidence.safety_case.hazard_result import HazardResult
from opensuction.evidence.safety_case.safety_case import HazardVerdict, run_record
from opensuction.result.safety_case_result import (
    FaultSummary,
    HazardDetail,
    HazardSummary,
    StripMark,
)
from opensuction.safety.condition import Condition
from opensuction.twin.fault.fault_table import ROWS

SPAN_WORDS = {SET_UP: "before the start", AIRWAY: "in the airway"}


def detail(verdict: HazardVerdict, summary: HazardSummary) -> HazardDetail:
    """A hazard's summary with the words of the table, every fault and the worst run's strip."""
    row, worst = verdict.hazard.row, verdict.worst
    claim = worst.case.claim
    condition = Condition[worst.alarm].row if worst.alarm else None
    return HazardDetail(
        summary=summary,
        cause=row.cause,
        effect=row.effect,
        detection=row.detection,
        control=row.control,
        safe_state=SAFE_STATES[claim.safe_state].words,
        because=tuple(dict.fromkeys(claim.because for claim in verdict.hazard.claims)),
        sentence=condition and f"{condition.sentence}. {condition.remedy}",
        refusal=claim.response == Response.REFUSAL or worst.refused,
        faults=_faults(verdict),
        strip=worst.strip,
        marks=_marks(worst),
    )


def _marks(result: HazardResult) -> tuple[StripMark, ...]:
    """Instants of a run: the fault, the alarm and the safe state that came."""
    after_ms = {"fault": 0.0, "alarm": result.detected_ms, "safe": result.safe_ms}
    return tuple(
        StripMark(name, result.at_s + ms / 1000.0)
        for name, ms in after_ms.items()
        if math.isfinite(ms)
    )


def _faults(verdict: HazardVerdict) -> tuple[FaultSummary, ...]:
    """Every fault of a hazard: its worst run over strengths, phases and seeds."""
    groups: dict[tuple[str, str], list[HazardResult]] = {}
    for result in verdict.results:
        case = result.case
        groups.setdefault((case.claim.name, SPAN_WORDS.get(case.span, case.span)), []).append(
            result
        )
    return tuple(
        _fault(phase, HazardVerdict(verdict.hazard, tuple(results)))
        for (_, phase), results in groups.items()
    )


def _fault(phase: str, group: HazardVerdict) -> FaultSummary:
    """A fault in a phase. group: its runs alone."""
    worst = run_record(group.worst)
    known, strengths = ROWS[group.worst.case.claim.fault].strength, ""
    if known is not None:
        listed = sorted({result.case.strength for result in group.results})
        strengths = ", ".join(f"{one:g}" for one in listed)
        strengths += "" if known.unit == "1" else f" {known.unit}"
    return FaultSummary(
        fault=worst.fault,
        phase=phase,
        strengths=strengths,
        runs=len(group.results),
        alarm=worst.alarm,
        detected_ms=worst.detected_ms,
        detected_bound_ms=worst.detected_bound_ms,
        safe_ms=worst.safe_ms,
        safe_bound_ms=worst.safe_bound_ms,
        finding=worst.problem or "within bounds",
        ok=group.ok,
    )
