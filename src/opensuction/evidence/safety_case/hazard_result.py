"""What a run of a hazard came to, from the fault on: alarm, safe state, what the patient bore.

What is safe is judged by the truth of the twin, not by what the controller believes.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.evidence.safety_case.hazard import SAFE_STATES, HazardClaim, Raiser, Response
from opensuction.kernel.phase import Phase
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import safe_state
from opensuction.simulation.injection.injection import Detector, Injected
from opensuction.simulation.injection.safe_state import Holds, SafeBounds
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault_table import ROWS

VENTED_MMHG = 10.0
"""[assumed] Vacuum that draws nothing: a tenth of what suctioning needs."""
TOUCH_N = 0.01
"""[assumed] Force that is no contact: an eighth of what closes the switch."""
FORCE_N = 0.3
"""Peak force at the tip: a third of what punctures [design-force]."""
VACUUM_SHARE = 4.0 / 3.0
"""Highest line vacuum over the governor's limit: 200 mmHg for an adult [AARC-2022]."""
OUT_S = 10.0
"""What a withdrawal may add to the limit of time in the airway: 8 s at 30 mm/s, and friction."""
STRIP_ROWS = 400
"""Points of a strip chart: fewer than pixels."""
BEFORE_S = 3.0
AFTER_S = 5.0
LEAST_S = 15.0
"""What a strip chart shows: before the fault, after the last mark, after the fault at least."""


class HazardCase(NamedTuple):
    """One run of a hazard."""

    hazard: str
    """Its identifier."""
    claim: HazardClaim
    strength: float
    phase: Phase | None
    """None: the fault is there before the start."""
    after_s: float
    seed: int

    @property
    def title(self) -> str:
        """Fault, instant, strength and seed, as the command line writes them."""
        at = "" if self.phase is None else f"@{self.phase.name.lower()}+{self.after_s:g}"
        known = ROWS[self.claim.fault].strength
        strength = "" if known is None else f"={self.strength:g}"
        contact = "" if self.claim.approach == "travel" else f" by {self.claim.approach}"
        return f"{self.claim.name}{at}{strength}{contact}, seed {self.seed}"


class Exposure(NamedTuple):
    """What the patient had to bear from the fault on."""

    contact_n: float
    beyond_cap_mm: float
    """Tip beyond the cap; negative: it stayed above."""
    vacuum_mmhg: float
    suction_s: float
    """With vacuum at the tip inside the patient, the whole run."""
    in_airway_s: float


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
Strip = dict[str, npt.NDArray[np.float32]]
"""A run thinned for a strip chart; arrays of one length."""


class HazardResult(NamedTuple):
    """What a run came to."""

    case: HazardCase
    alarm: str
    """The condition that told a person; empty where none of the expected did."""
    priority: str
    at_s: float
    """When the fault came."""
    detected_ms: float
    """From the fault to the alarm; nan without one."""
    safe_ms: float
    """From the fault to the safe state that lasts; nan where it is not reached."""
    within_limits: bool
    """Whether the cycle stayed within every limit as if nothing were wrong."""
    exposure: Exposure
    problem: str
    """What is broken, in words; empty where nothing is."""
    strip: Strip | None

    @property
    def ok(self) -> bool:
        """Whether every bound held."""
        return not self.problem

    @property
    def answered(self) -> bool:
        """Whether alarm and safe state came within their bounds, as far as they were owed."""
        claim = self.case.claim
        return self.detected_ms <= claim.detected_ms and self.safe_ms <= claim.safe_ms


NO_EXPOSURE = Exposure(0.0, -math.inf, 0.0, 0.0, 0.0)


def refused(case: HazardCase, message: str) -> HazardResult:
    """HazardResult of a case whose cycle was refused before anything moved."""
    expected = case.claim.response == Response.REFUSAL
    problem = "" if expected else f"the cycle cannot be planned: {message}"
    return HazardResult(case, "", "none", 0.0, 0.0, 0.0, True, NO_EXPOSURE, problem, None)


def _signalled(columns: Columns, at_s: float) -> dict[str, float]:
    """Conditions that are signalled from an instant on and were not before: name and instant."""
    first = round(at_s / DT_S)
    present, latched = (columns[f"signals.{name}"] for name in ("present", "latched"))
    shown = present.astype(np.int64) | latched.astype(np.int64)
    new = shown[first:] & ~(int(shown[first - 1]) if first > 0 else 0)
    found: dict[str, float] = {}
    for bit in condition_mask.decode(int(np.bitwise_or.reduce(new))):
        tick = first + int(np.argmax(new >> bit & 1))
        name = Condition(bit).name if bit in set(Condition) else str(bit)
        found[name] = float(columns["time_s"][tick])
    return found


def _alarm(case: HazardCase, signalled: dict[str, float], found: Injected) -> tuple[str, float]:
    """Which of the expected conditions was signalled first, and when; nan for none."""
    claim = case.claim
    if claim.raised_by == Raiser.DRIVES:
        notice = found.notice
        if notice is None or notice.detector != Detector.DRIVE:
            return "", math.nan
        return claim.alarm[0], notice.time_s
    expected = [name for name in claim.alarm if name in signalled]
    if not expected:
        return "", math.nan
    first = min(expected, key=lambda name: signalled[name])
    return first, signalled[first]


def _safe(claim: HazardClaim, columns: Columns, bounds: SafeBounds) -> Holds:
    alternatives = SAFE_STATES[claim.safe_state].alternatives
    held = [safe_state.holds(columns, one, bounds) for one in alternatives]
    return np.asarray(np.any(held, axis=0))


def _measure_exposure(columns: Columns, first: int, cap_mm: float, bounds: SafeBounds) -> Exposure:
    inside = columns["truth.tip_mm"] > bounds.boundary_mm
    sucking = inside & (columns["truth.tip_vacuum_mmhg"] > bounds.vented_mmhg)
    return Exposure(
        contact_n=float(np.max(columns["truth.contact_n"][first:])),
        beyond_cap_mm=float(np.max(columns["truth.tip_mm"][first:])) - cap_mm,
        vacuum_mmhg=float(np.max(columns["truth.line_vacuum_mmhg"][first:])),
        suction_s=float(np.count_nonzero(sucking)) * DT_S,
        in_airway_s=float(np.count_nonzero(inside)) * DT_S,
    )


def judge(case: HazardCase, prepared: Prepared, columns: Columns, found: Injected) -> HazardResult:
    """Hold the trace of a run against the claim of its hazard."""
    claim, limits = case.claim, prepared.loop.controller.limits
    bounds = SafeBounds(
        boundary_mm=prepared.rig.site.boundary_mm,
        vented_mmhg=VENTED_MMHG,
        vacuum_mmhg=VACUUM_SHARE * limits.vacuum_mmhg,
        contact_n=TOUCH_N,
    )
    if math.isnan(found.at_s):
        problem = "the fault's instant never came"
        return HazardResult(
            case, "", "none", 0.0, math.nan, math.nan, False, NO_EXPOSURE, problem, None
        )
    exposure = _measure_exposure(columns, round(found.at_s / DT_S), limits.cap_mm, bounds)
    signalled = _signalled(columns, found.at_s)
    alarm, alarm_s = _alarm(case, signalled, found)
    safe_s = safe_state.safe_s(columns, _safe(claim, columns, bounds), found.at_s)
    harmful = [
        words
        for words, broken in (
            (f"force {exposure.contact_n:.2f} N, limit {FORCE_N:g}", exposure.contact_n > FORCE_N),
            (f"tip {exposure.beyond_cap_mm:.1f} mm beyond its cap", exposure.beyond_cap_mm > 0.0),
            (
                f"vacuum {exposure.vacuum_mmhg:.0f} mmHg, limit {bounds.vacuum_mmhg:.0f}",
                exposure.vacuum_mmhg > bounds.vacuum_mmhg,
            ),
        )
        if broken
    ]
    within = (
        not harmful
        and not math.isnan(safe_s)
        and exposure.suction_s <= limits.negative_pressure_s
        and exposure.in_airway_s <= limits.in_airway_s + OUT_S
    )
    detected_ms, safe_ms = 1000.0 * (alarm_s - found.at_s), 1000.0 * (safe_s - found.at_s)
    others = [name.lower() for name in signalled if name not in claim.alarm]
    problem = _problem(claim, detected_ms, safe_ms, harmful, within, others)
    priority = Condition[alarm].row.handling.priority.name.lower() if alarm else "none"
    strip = _strip(columns, found.at_s, max(_or_0(safe_s), _or_0(alarm_s)))
    return HazardResult(
        case, alarm, priority, found.at_s, detected_ms, safe_ms, within, exposure, problem, strip
    )


def _or_0(value: float) -> float:
    return 0.0 if math.isnan(value) else value


def _problem(
    claim: HazardClaim,
    detected_ms: float,
    safe_ms: float,
    harmful: list[str],
    within: bool,
    others: list[str],
) -> str:
    """What of the claim does not hold, in words. others: what else was signalled."""
    found = list(harmful)
    if claim.response == Response.REFUSAL:
        return "the cycle was not refused"
    if claim.response == Response.ALARM_OR_LIMITS and within:
        return ""
    if math.isnan(detected_ms):
        found.append(f"no expected alarm, but {', '.join(others)}" if others else "no alarm")
    elif detected_ms > claim.detected_ms:
        found.append(f"alarm after {detected_ms:.0f} ms, bound {claim.detected_ms:g}")
    if math.isnan(safe_ms):
        found.append("safe state not reached")
    elif safe_ms > claim.safe_ms:
        found.append(f"safe after {safe_ms:.0f} ms, bound {claim.safe_ms:g}")
    return "; ".join(found)


def _strip(columns: Columns, at_s: float, last_s: float) -> Strip:
    first = max(0, round((at_s - BEFORE_S) / DT_S))
    last = min(columns["time_s"].size, round((max(last_s, at_s + LEAST_S) + AFTER_S) / DT_S))
    rows = np.linspace(first, last - 1, min(STRIP_ROWS, last - first)).round().astype(np.int64)
    return {
        name: (factor * columns[column][rows]).astype(np.float32)
        for name, (column, factor) in STRIP.items()
    }
