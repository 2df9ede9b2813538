"""One run of a hazard: the fault comes at its instant, and the clock runs to alarm and safe state.

What is safe is judged by the truth of the twin, not by what the controller believes.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.evidence.safety_case import hazard
from opensuction.evidence.safety_case.hazard import (
    EITHER,
    SAFE_STATES,
    Claim,
    Hazard,
    Raiser,
    Response,
)
from opensuction.kernel.age_group import AgeGroup
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.session.cycle import cycle_run
from opensuction.session.cycle.cycle_choice import Choice
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection, safe_state
from opensuction.simulation.injection.fault_instant import AT_START, Injection, Instant
from opensuction.simulation.injection.injection import Detector, Injected
from opensuction.simulation.injection.safe_state import Holds, SafeBounds
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault_row import Part
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.patient import patient_kind

COMPENSATION = "exact-inverse"
"""The command's own."""
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
MONITORED_S = 30.0
"""How long a patient at fault is followed: a saturation is shown 10 to 30 s late."""
STRIP_ROWS = 400
"""Points of a strip chart: fewer than pixels."""
BEFORE_S = 3.0
AFTER_S = 5.0
LEAST_S = 15.0
"""What a strip chart shows: before the fault, after the last mark, after the fault at least."""


class Case(NamedTuple):
    """One run of a hazard."""

    hazard: str
    """Its identifier."""
    claim: Claim
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


class Harm(NamedTuple):
    """What the patient had to bear from the fault on."""

    contact_n: float
    beyond_cap_mm: float
    """Tip beyond the cap; negative: it stayed above."""
    vacuum_mmhg: float
    suction_s: float
    """With vacuum at the tip inside the patient, the whole run."""
    in_airway_s: float


class Strip(NamedTuple):
    """A run thinned for a strip chart; arrays of one length."""

    time_s: npt.NDArray[np.float32]
    head_mm: npt.NDArray[np.float32]
    tip_mm: npt.NDArray[np.float32]
    vacuum_mmhg: npt.NDArray[np.float32]
    valve_percent: npt.NDArray[np.float32]
    reaction: npt.NDArray[np.float32]
    priority: npt.NDArray[np.float32]


class Result(NamedTuple):
    """What a run came to."""

    case: Case
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
    harm: Harm
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


NO_HARM = Harm(0.0, -math.inf, 0.0, 0.0, 0.0)


def cases(one: Hazard, seeds: tuple[int, ...]) -> list[Case]:
    """Every run of a hazard."""
    found = []
    for claim in one.claims:
        strengths = claim.strengths or [ROWS[claim.fault].default_strength]
        for phase in hazard.phases_of(claim):
            after = [0.0] if phase is None else claim.after_s
            found += [
                Case(one.row.id, claim, strength, phase, after_s, seed)
                for strength in strengths
                for after_s in after
                for seed in seeds
            ]
    return found


def _injection(case: Case) -> Injection:
    at = AT_START if case.phase is None else Instant(case.phase, case.after_s)
    return Injection(case.claim.fault, at, case.strength)


@lru_cache(maxsize=4)
def _prepared(approach: str, patient: str, seed: int, set_up: tuple[Injection, ...]) -> Prepared:
    """A cycle ready to run; raises InputError where it is refused."""
    adult = patient_kind.of_preset(patient).age == AgeGroup.ADULT
    protocol = "adult" if adult else "paediatric"
    choice = Choice(None, protocol, approach, COMPENSATION, seed, patient=patient, faults=set_up)
    return cycle_run.prepare(choice)


def run(case: Case) -> Result:
    """Run a case and hold it against its claim."""
    one, claim = _injection(case), case.claim
    planned = (one,) if ROWS[claim.fault].is_planned else ()
    try:
        prepared = _prepared(claim.approach, claim.patient, case.seed, planned)
    except InputError as refusal:
        return _refused(case, str(refusal))
    later = () if planned else (one,)
    patient = ROWS[claim.fault].part == Part.PATIENT
    after_s = MONITORED_S if patient else injection.AFTERMATH_S
    done = injection.run(prepared.loop, prepared.start, later, after_s=after_s, seed=case.seed)
    found = done.faults[0] if later else Injected(one, 0.0, None)
    return _judged(case, prepared, done.columns, found)


def _refused(case: Case, message: str) -> Result:
    expected = case.claim.response == Response.REFUSAL
    problem = "" if expected else f"the cycle cannot be planned: {message}"
    return Result(case, "", "none", 0.0, 0.0, 0.0, True, NO_HARM, problem, None)


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


def _alarm(case: Case, signalled: dict[str, float], found: Injected) -> tuple[str, float]:
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


def _safe(claim: Claim, columns: Columns, bounds: SafeBounds) -> Holds:
    if claim.safe_state == EITHER:
        out = safe_state.holds(columns, ("tip-outside",), bounds)
        still = safe_state.holds(columns, ("standing",), bounds)
        return (out | still) & safe_state.holds(columns, ("no-suction",), bounds)
    return safe_state.holds(columns, SAFE_STATES[claim.safe_state], bounds)


def _harm(columns: Columns, first: int, cap_mm: float, bounds: SafeBounds) -> Harm:
    inside = columns["truth.tip_mm"] > bounds.boundary_mm
    sucking = inside & (columns["truth.tip_vacuum_mmhg"] > bounds.vented_mmhg)
    return Harm(
        contact_n=float(np.max(columns["truth.contact_n"][first:])),
        beyond_cap_mm=float(np.max(columns["truth.tip_mm"][first:])) - cap_mm,
        vacuum_mmhg=float(np.max(columns["truth.line_vacuum_mmhg"][first:])),
        suction_s=float(np.count_nonzero(sucking)) * DT_S,
        in_airway_s=float(np.count_nonzero(inside)) * DT_S,
    )


def _judged(case: Case, prepared: Prepared, columns: Columns, found: Injected) -> Result:
    claim, limits = case.claim, prepared.loop.controller.limits
    bounds = SafeBounds(
        boundary_mm=prepared.rig.site.boundary_mm,
        vented_mmhg=VENTED_MMHG,
        vacuum_mmhg=VACUUM_SHARE * limits.vacuum_mmhg,
        contact_n=TOUCH_N,
    )
    if math.isnan(found.at_s):
        problem = "the fault's instant never came"
        return Result(case, "", "none", 0.0, math.nan, math.nan, False, NO_HARM, problem, None)
    harm = _harm(columns, round(found.at_s / DT_S), limits.cap_mm, bounds)
    signalled = _signalled(columns, found.at_s)
    alarm, alarm_s = _alarm(case, signalled, found)
    safe_s = safe_state.safe_s(columns, _safe(claim, columns, bounds), found.at_s)
    harmful = [
        words
        for words, broken in (
            (f"force {harm.contact_n:.2f} N, limit {FORCE_N:g}", harm.contact_n > FORCE_N),
            (f"tip {harm.beyond_cap_mm:.1f} mm beyond its cap", harm.beyond_cap_mm > 0.0),
            (
                f"vacuum {harm.vacuum_mmhg:.0f} mmHg, limit {bounds.vacuum_mmhg:.0f}",
                harm.vacuum_mmhg > bounds.vacuum_mmhg,
            ),
        )
        if broken
    ]
    within = (
        not harmful
        and not math.isnan(safe_s)
        and harm.suction_s <= limits.negative_pressure_s
        and harm.in_airway_s <= limits.in_airway_s + OUT_S
    )
    detected_ms, safe_ms = 1000.0 * (alarm_s - found.at_s), 1000.0 * (safe_s - found.at_s)
    others = [name.lower() for name in signalled if name not in claim.alarm]
    problem = _problem(claim, detected_ms, safe_ms, harmful, within, others)
    priority = Condition[alarm].row.handling.priority.name.lower() if alarm else "none"
    strip = _strip(columns, found.at_s, max(_or_0(safe_s), _or_0(alarm_s)))
    return Result(
        case, alarm, priority, found.at_s, detected_ms, safe_ms, within, harm, problem, strip
    )


def _or_0(value: float) -> float:
    return 0.0 if math.isnan(value) else value


def _problem(
    claim: Claim,
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

    def thinned(name: str, factor: float = 1.0) -> npt.NDArray[np.float32]:
        return (factor * columns[name][rows]).astype(np.float32)

    return Strip(
        time_s=thinned("time_s"),
        head_mm=thinned("truth.head_mm"),
        tip_mm=thinned("truth.tip_mm"),
        vacuum_mmhg=thinned("truth.line_vacuum_mmhg"),
        valve_percent=thinned("truth.valve_open_ratio", 100.0),
        reaction=thinned("verdict.reaction"),
        priority=thinned("signals.priority"),
    )
