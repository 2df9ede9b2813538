"""Details of a hazard for the page of a safety case, beyond the JSON object, as plain data."""

import math

from opensuction.evidence.healthy_cycle import AIRWAY
from opensuction.evidence.safety_case.hazard_claim import SAFE_STATES, SET_UP, Response
from opensuction.evidence.safety_case.hazard_result import HazardResult
from opensuction.evidence.safety_case.safety_case import HazardVerdict, entry
from opensuction.result.plain import Json
from opensuction.safety.condition import Condition
from opensuction.twin.fault.fault_table import ROWS

SPAN_WORDS = {SET_UP: "before the start", AIRWAY: "in the airway"}


def detail(verdict: HazardVerdict) -> Json:
    """The entry of the JSON object, the words of the table, every fault, the worst run's strip."""
    row, worst = verdict.hazard.row, verdict.worst
    claim = worst.case.claim
    condition = Condition[worst.alarm].row if worst.alarm else None
    return entry(verdict) | {
        "cause": row.cause,
        "effect": row.effect,
        "detection": row.detection,
        "control": row.control,
        "safe_state_words": SAFE_STATES[claim.safe_state].words,
        "because": list(dict.fromkeys(claim.because for claim in verdict.hazard.claims)),
        "sentence": condition and f"{condition.sentence}. {condition.remedy}",
        "refusal": claim.response == Response.REFUSAL or worst.refused,
        "faults": _faults(verdict),
        "strip": worst.strip,
        "marks": _marks(worst),
    }


def _marks(result: HazardResult) -> list[Json]:
    """Instants of a run: the fault, the alarm and the safe state that came."""
    after_ms = {"fault": 0.0, "alarm": result.detected_ms, "safe": result.safe_ms}
    return [
        {"name": name, "time_s": result.at_s + ms / 1000.0}
        for name, ms in after_ms.items()
        if math.isfinite(ms)
    ]


def _faults(verdict: HazardVerdict) -> list[Json]:
    """Every fault of a hazard: its worst run over strengths, phases and seeds."""
    groups: dict[tuple[str, str], list[HazardResult]] = {}
    for result in verdict.results:
        case = result.case
        groups.setdefault((case.claim.name, SPAN_WORDS.get(case.span, case.span)), []).append(
            result
        )
    listed = []
    for (fault, phase), results in groups.items():
        group = HazardVerdict(verdict.hazard, tuple(results))
        known, strengths = ROWS[group.worst.case.claim.fault].strength, ""
        if known is not None:
            listed_strengths = sorted({result.case.strength for result in results})
            strengths = ", ".join(f"{one:g}" for one in listed_strengths)
            strengths += "" if known.unit == "1" else f" {known.unit}"
        finding = group.worst.problem or "within bounds"
        shown = {"fault": fault, "phase": phase, "strengths": strengths, "finding": finding}
        listed.append(entry(group) | shown)
    return listed
