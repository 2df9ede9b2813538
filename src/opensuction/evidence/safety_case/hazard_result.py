"""Result of one run of a hazard: alarm, safe state, harm to the patient, catheter left inside.

It is judged by the oracle, from the twin's truth; an alarm counts from the instant at which
somebody at the bedside was told of it.
"""

import math
from typing import NamedTuple

import numpy as np

from opensuction.evidence.campaign import played_cycle
from opensuction.evidence.campaign.played_cycle import Played
from opensuction.evidence.campaign.sound_machine import HealthyCycle, find_wait_s
from opensuction.evidence.safety_case.hazard_claim import (
    NEEDS_NO_ALARM,
    REFUSES,
    SAFE_STATES,
    SET_UP,
    HazardClaim,
    Raiser,
    Response,
)
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.oracle.exposure import BOUNDS, PatientExposure
from opensuction.oracle.harm import LEFT_INSIDE, NAMES, Harm
from opensuction.result.safety_case_result import StripChart
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import invariant, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant
from opensuction.simulation.injection.injection import SIGNS
from opensuction.simulation.injection.invariant import SafeBounds
from opensuction.simulation.injection.run_judgement import Judgement, LeftInside
from opensuction.simulation.outcome import CONTROLLER, Annunciation
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault_table import ROWS

VENTED_MMHG = 10.0
"""[assumed] Vacuum that draws nothing: a tenth of what suctioning needs."""
TOUCH_N = 0.01
"""[assumed] Force that is no contact: an eighth of what closes the switch."""
SENSOR_MS = 1000.0
"""An alarm that is owed sooner waits for sensors and ticks: no age hastens it."""
STRIP_ROWS = 300
"""Points of a strip chart: fewer than pixels."""
BEFORE_S = 3.0
AFTER_S = 5.0
LEAST_S = 15.0
"""What a strip chart shows: before the fault, after the last mark, after the fault at least."""
STRIP = {
    "time_s": ("time_s", 1.0),
    "head_mm": ("truth.head_mm", 1.0),
    "tip_mm": ("truth.tip_mm", 1.0),
    "vacuum_mmhg": ("truth.line_vacuum_mmhg", 1.0),
    "valve_percent": ("truth.valve_open_ratio", 100.0),
    "reaction": ("verdict.reaction", 1.0),
    "priority": ("signals.priority", 1.0),
}
"""Series of a strip chart by name: column of the trace, and its factor."""
COLUMNS = tuple(
    dict.fromkeys((*SIGNS, *played_cycle.PLAYED, *(column for column, _ in STRIP.values())))
)
"""Columns that are looked at."""


class HazardCase(NamedTuple):
    """One run of a hazard."""

    hazard: str
    """Its identifier."""
    claim: HazardClaim
    strength: float
    span: str
    """Phase, or span, that the fault comes in."""
    at: FaultInstant
    """When in it; before it is placed nan s, for a share of the span."""
    share: float
    """Of the span, 0 to 1."""
    patient: str
    approach: str
    seed: int

    @property
    def title(self) -> str:
        """Fault, instant, strength, patient and seed, as the command line writes them."""
        at = "" if self.span == SET_UP else self.at.title
        known = ROWS[self.claim.fault].strength
        strength = "" if known is None else f"={self.strength:g}"
        fault = f"{self.claim.name}{at}{strength}"
        return f"{fault}, {self.patient} by {self.approach}, seed {self.seed}"


class HazardResult(NamedTuple):
    """Result of a run."""

    case: HazardCase
    alarm: str
    """The expected condition that people were told of first; empty where they were of none."""
    by: str
    """Who raised it: controller, drives or power."""
    priority: str
    at_s: float
    """When the fault came."""
    detected_ms: float
    """From the fault until people were told; nan where they were not."""
    detected_bound_ms: float
    """By the patient's age, and by when the fault had a chance to show."""
    safe_ms: float
    """From the fault to the safe state that lasts; nan where it is not reached."""
    safe_bound_ms: float
    within_limits: bool
    """Whether no bound of the patient was broken and the safe state reached."""
    exposure: PatientExposure | None
    """None where nothing ran."""
    harm: tuple[Harm, ...]
    """Bounds of the patient that were broken, whosoever's doing it was."""
    left_inside: LeftInside | None
    """None where the tip is out."""
    problem: str
    """What is broken, in words; empty where nothing is."""
    strip: StripChart | None

    @property
    def ok(self) -> bool:
        """True if every bound held."""
        return not self.problem

    @property
    def refused(self) -> bool:
        """True if nothing ran: the cycle was refused, as the claim has it."""
        return self.ok and self.exposure is None

    @property
    def answered(self) -> bool:
        """True if alarm and safe state came within their bounds, as far as they were owed."""
        told = self.detected_ms <= self.detected_bound_ms
        return told and self.safe_ms <= self.safe_bound_ms


def refused(case: HazardCase, message: str) -> HazardResult:
    """HazardResult of a case whose cycle was refused before anything moved."""
    expected = case.claim.response in REFUSES
    problem = "" if expected else f"the cycle cannot be planned: {message}"
    return HazardResult(
        case=case,
        alarm="",
        by="",
        priority="none",
        at_s=0.0,
        detected_ms=0.0,
        detected_bound_ms=case.claim.detected_ms,
        safe_ms=0.0,
        safe_bound_ms=case.claim.safe_ms,
        within_limits=True,
        exposure=None,
        harm=(),
        left_inside=None,
        problem=problem,
        strip=None,
    )


def _find_told(
    claim: HazardClaim, told: tuple[Annunciation, ...], at_s: float
) -> Annunciation | None:
    """The first of the expected conditions that people were told of from the fault on."""
    by_controller = claim.raised_by == Raiser.CONTROLLER
    for one in told:
        expected = one.condition.name in claim.alarm and (one.by == CONTROLLER) == by_controller
        if expected and one.at_s >= at_s - 0.5 * DT_S:
            return one
    return None


def _bounds_ms(
    claim: HazardClaim, prepared: Prepared, healthy: HealthyCycle, at_s: float
) -> tuple[float, float]:
    """Bounds of alarm and safe state of a run.

    Bounds are argued for adults. A smaller patient has as much less time as there is until a
    saturation of 90 %, and the way out is shorter by more.
    """
    age = AgeGroup(prepared.rig.machine.patient.age_group)
    share = BOUNDS[age].in_airway_s / BOUNDS[AgeGroup.ADULT].in_airway_s if claim.by_age else 1.0
    detected_ms, safe_ms = claim.detected_ms, claim.safe_ms * share
    if detected_ms > SENSOR_MS and claim.safe_state != "not-inserted":
        detected_ms = max(detected_ms * share, SENSOR_MS)
    wait_ms = 1000.0 * find_wait_s(healthy, claim.shows, at_s, detected_ms / 1000.0)
    return detected_ms + wait_ms, safe_ms + wait_ms


def judge(
    case: HazardCase,
    played: Played,
    healthy: HealthyCycle,
) -> HazardResult:
    """Hold the trace of a run with one fault against the claim of its hazard."""
    prepared, columns, (found,) = played.prepared, played.run.columns, played.run.faults
    claim, limits = case.claim, prepared.loop.controller.limits
    never = math.isnan(found.at_s)
    at_s = 0.0 if never else found.at_s
    detected_bound_ms, safe_bound_ms = _bounds_ms(claim, prepared, healthy, at_s)
    judged = run_judgement.judge(
        prepared.rig.machine,
        limits.cap_mm,
        columns,
        (found,),
        told_within_s=detected_bound_ms / 1000.0,
        strictly=set(NAMES) - set(claim.allowed),
    )
    told = _find_told(claim, judged.told, at_s)
    bounds = SafeBounds(judged.borne.outside_mm, VENTED_MMHG, limits.vacuum_mmhg, TOUCH_N)
    safe = invariant.holds(columns, SAFE_STATES[claim.safe_state].predicates, bounds)
    safe_s = invariant.safe_s(columns, safe, at_s)
    result = HazardResult(
        case=case,
        alarm="" if told is None else told.condition.name,
        by="" if told is None else told.by,
        priority="none" if told is None else told.condition.row.handling.priority.name.lower(),
        at_s=at_s,
        detected_ms=math.nan if told is None else 1000.0 * (told.at_s - at_s),
        detected_bound_ms=detected_bound_ms,
        safe_ms=1000.0 * (safe_s - at_s),
        safe_bound_ms=safe_bound_ms,
        within_limits=not judged.breaches and not math.isnan(safe_s),
        exposure=judged.borne,
        harm=judged.harm,
        left_inside=judged.left_inside,
        problem="",
        strip=_strip(columns, at_s, max(_or_0(safe_s), at_s if told is None else told.at_s)),
    )
    problem = "the fault's instant never came" if never else _problem(result, judged, at_s)
    return result._replace(problem=problem)


def _or_0(value: float) -> float:
    return 0.0 if math.isnan(value) else value


def _describe(found: Harm, left: LeftInside | None) -> str:
    """A breach in words."""
    if found.name != LEFT_INSIDE or left is None:
        return f"{found.name} {found.worst:.3g} {found.unit}, bound {found.limit:.3g}"
    depth_mm = found.worst - found.limit
    words = f"left inside, {depth_mm:.0f} mm below the tube's upper end"
    if found.limit == 0.0:
        words = f"left inside, a piece of {depth_mm:.0f} mm"
    if left.unavoidable:
        return f"{words}: unavoidable, but not told high in time"
    return f"{words}, though something could have moved it"


def _problem(result: HazardResult, judged: Judgement, at_s: float) -> str:
    """Parts of the claim that do not hold, in words."""
    claim, left = result.case.claim, judged.left_inside
    if claim.response == Response.REFUSAL:
        return "the cycle was not refused"
    found = [_describe(one, left) for one in judged.breaches]
    if claim.response == Response.NOT_MEASURED:
        return "; ".join(["not measured: nothing in the twin tells it", *found])
    if claim.response in NEEDS_NO_ALARM and result.within_limits:
        return ""
    if math.isnan(result.detected_ms):
        others = {one.condition.name.lower() for one in judged.told if one.at_s >= at_s}
        listed = ", ".join(sorted(others))
        found.append(f"no expected alarm, but {listed}" if others else "no alarm")
    elif result.detected_ms > result.detected_bound_ms:
        found.append(f"alarm after {result.detected_ms:.0f} ms, bound {result.detected_bound_ms:g}")
    if math.isnan(result.safe_ms):
        if left is None or not left.unavoidable:
            found.append("safe state not reached")
    elif result.safe_ms > result.safe_bound_ms:
        found.append(f"safe after {result.safe_ms:.0f} ms, bound {result.safe_bound_ms:g}")
    return "; ".join(found)


def _strip(columns: Columns, at_s: float, last_s: float) -> StripChart:
    first = max(0, round((at_s - BEFORE_S) / DT_S))
    last = min(columns["time_s"].size, round((max(last_s, at_s + LEAST_S) + AFTER_S) / DT_S))
    rows = np.linspace(first, last - 1, min(STRIP_ROWS, last - first)).round().astype(np.int64)
    return StripChart(
        **{
            name: (factor * columns[column][rows]).astype(np.float32)
            for name, (column, factor) in STRIP.items()
        }
    )
