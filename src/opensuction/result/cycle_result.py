"""Result of one cycle, simulated or recorded: records that every report reads.

None: not simulated, not measured, or never reached. Field names are the keys of the JSON object,
with their units (docs/reference/results.md).
"""

from typing import Annotated, Literal, NamedTuple

from opensuction.result.identification_result import TransmissionModel
from opensuction.result.plain import FLAT, IF_KNOWN

RECORDED: Literal["recorded"] = "recorded"
"""`RecordedPart.basis`: by what the machine measured and estimated."""
USUAL_SPREAD = 1.0


class Teaching(NamedTuple):
    """Source of the taught depth, and its error against the truth."""

    source: Literal["hand", "given"]
    error_mm: float


class PhaseTime(NamedTuple):
    """A phase with its beginning and end."""

    name: str
    start_s: float
    end_s: float


class TipResult(NamedTuple):
    """Positions of the tip, mm below the tube's lower end."""

    target_mm: float | None
    reached_mm: float | None
    stop_error_mm: float | None
    """Reached minus target."""
    rmse_mm: float | None
    peak_error_mm: float | None
    deepest_mm: float | None
    past_carina_mm: float | None
    end_mm: float | None
    """At the end of the record."""
    inside_at_end: bool
    deepest_possible_mm: Annotated[float | None, IF_KNOWN] = None
    """By the governor's bounds: of a recording, which has no truth."""


class TimingResult(NamedTuple):
    """Durations with the limits that held."""

    cycle_s: float | None
    in_airway_s: float | None
    in_airway_budget_s: float | None
    negative_pressure_s: float | None
    negative_pressure_budget_s: float | None
    guideline_s: float | None
    """For negative pressure."""
    in_airway_guideline_s: float | None
    """Insertion to removal by hand, adults only."""
    followed_s: float | None
    """Length of the record."""
    dwell_s: float | None
    dwell_ended_by: str | None
    nothing_comes_s: float | None


class VacuumResult(NamedTuple):
    """Vacuum in the line and at the tip."""

    setpoint_mmhg: float | None
    peak_mmhg: float | None
    """In the line, without the pre-use test's."""
    delivered_mmhg: float | None
    """At the tip, the mean under suction."""
    tip_peak_mmhg: float | None
    guideline_mmhg: float | None
    limit_mmhg: Annotated[float | None, IF_KNOWN] = None
    """The governor's: of a recording."""


class SecretionResult(NamedTuple):
    """Secretions that suction took."""

    removed_ml: float | None
    removed_percent: float | None
    """Of what lay there and came meanwhile."""


class SignCourse(NamedTuple):
    """Course of one vital sign, its usual range and the monitor's limits."""

    before: float | None
    lowest: float
    highest: float | None
    at_end: float | None
    is_back: bool | None
    """Within its tolerance of what it was; None where that is not known."""
    recovered_s: float | None
    """Since when, on the run's clock; None: it never left, or is not back."""
    usual_least: float | None = None
    usual_most: float | None = None
    limit_least: float | None = None
    limit_most: float | None = None
    relaxed_lowest: Annotated[float | None, IF_KNOWN] = None
    """Of the same lung without the patient's own muscles."""
    relaxed_highest: Annotated[float | None, IF_KNOWN] = None


class VitalSigns(NamedTuple):
    """Vital signs that were simulated, or shown by the monitor."""

    spo2_percent: Annotated[SignCourse | None, IF_KNOWN] = None
    heart_rate_per_min: Annotated[SignCourse | None, IF_KNOWN] = None
    airway_pressure_cmh2o: Annotated[SignCourse | None, IF_KNOWN] = None
    lung_volume_loss_ml: Annotated[SignCourse | None, IF_KNOWN] = None


class OxygenRecord(NamedTuple):
    """Pre-oxygenation as it is on record."""

    required: bool
    state: str


class TestedItem(NamedTuple):
    """An item of the pre-use test."""

    name: str
    meaning: str
    passed: bool | None
    """None where it was not tested."""
    seconds: float


class PreUseTest(NamedTuple):
    """Pre-use test of sensors, motor, valve, pump and line."""

    passed: bool
    failed_item: str | None
    sentence: str | None
    items: tuple[TestedItem, ...]


class AbortCause(NamedTuple):
    """Cause of a broken-off cycle."""

    event: str
    phase: str
    sentence: str
    time_s: float


class TripRecord(NamedTuple):
    """A safety limit that tripped, at its first time."""

    name: str
    sentence: str
    time_s: float


class AlarmRecord(NamedTuple):
    """An alarm of the controller."""

    condition: str
    priority: str
    sentence: str
    remedy: str
    started_s: float | None
    ended_s: float | None
    """None where it was still raised at the end."""
    latched: bool
    acknowledged_s: float | None


class Announcement(NamedTuple):
    """A notice that the annunciator at the bedside showed."""

    what: str
    at_s: float
    by: str
    """``controller``, ``drives`` or ``power``."""
    priority: str
    sentence: str
    remedy: str


class BrokenBound(NamedTuple):
    """A bound for the patient that was broken, by the oracle."""

    name: str
    worst: float | None
    limit: float | None
    unit: str
    """Of both."""


class PlannedCheck(NamedTuple):
    """A requirement of the guidelines held against the plan."""

    name: str
    value: float
    limit: float
    unit: str
    strict: bool
    """The value must stay below the limit; otherwise it may reach it."""
    source: str
    ok: bool


class LeftInsideCount(NamedTuple):
    """Runs that ended with the catheter or a part of it in the airway."""

    count: int  # type: ignore[assignment] # over tuple's method: the key in JSON
    unavoidable: int
    """Of them: nothing could have brought it out."""
    told: int
    """Of them: people were told with high priority within the bound."""


class Anatomy(NamedTuple):
    """Places that depths refer to, mm below the tube's lower end."""

    tube_end_mm: float
    patient_boundary_mm: float | None
    carina_mm: float | None
    cap_mm: float | None


class FaultNotice(NamedTuple):
    """First sign of a fault."""

    by: str
    name: str
    sentence: str
    time_s: float
    after_s: float
    cycle: Annotated[int | None, IF_KNOWN] = None
    """Of a day."""


class FaultRecord(NamedTuple):
    """A fault that was injected."""

    name: str
    meaning: str
    instant: str
    at_s: float | None
    """None where its instant never came."""
    strength: float | None
    strength_unit: str | None
    noticed: FaultNotice | None
    cycle: Annotated[int | None, IF_KNOWN] = None
    """Of a day: in which it came."""


class ContactRecord(NamedTuple):
    """Closures of the contact switch."""

    closed_s: float
    touched_mm: float | None
    """Tip by the controller's estimate when it met the carina."""


class CycleFiles(NamedTuple):
    """Files that a command wrote of a cycle."""

    trace: str | None
    """Every tick as a table."""
    recording: str | None


class SimulatedPart(NamedTuple):
    """Facts that only a simulated cycle has."""

    conduit: str
    spread: float
    gap_scale: float
    tip_shift_mm: float
    taught_mm: float | None
    teaching: Teaching | None
    told: tuple[Announcement, ...]
    broken_bounds: tuple[BrokenBound, ...]
    checks: tuple[PlannedCheck, ...]
    identification: TransmissionModel | None
    wall_s: float | None
    realtime_factor: float | None
    faults: tuple[FaultRecord, ...]
    files: Annotated[CycleFiles | None, FLAT] = None
    """None where no command wrote any."""


class RecordedPart(NamedTuple):
    """Facts that only a recorded cycle has."""

    basis: str
    has_truth: bool
    began_utc: str
    contact: ContactRecord
    gap_mm: float | None
    missing_ticks: int
    flaw: str | None
    damaged: bool


class CycleResult(NamedTuple):
    """One cycle: what was asked, what came of it, what the patient bore, who noticed what."""

    outcome: Literal["completed", "aborted", "interrupted"]
    version: str
    arithmetic_fingerprint: str
    in_silico: bool
    machine: str | None
    protocol: str | None
    approach: str | None
    compensation: str | None
    patient: str | None
    catheter: str | None
    seed: int | str | None
    """As text in a recording."""
    phases: tuple[PhaseTime, ...]
    tip: TipResult
    timing: TimingResult
    vacuum: VacuumResult
    carina_force_peak_n: float | None
    secretion: SecretionResult
    spo2_nadir_percent: float | None
    lung_volume_loss_ml: float | None
    airway_pressure_least_cmh2o: float | None
    vitals: VitalSigns | None
    preoxygenation: OxygenRecord
    check: PreUseTest
    abort: AbortCause | None
    trips: tuple[TripRecord, ...]
    alarms: tuple[AlarmRecord, ...]
    harm: tuple[str, ...] | None
    """Names of the bounds for the patient that were broken; None without the truth."""
    warnings: tuple[str, ...]
    anatomy: Anatomy
    simulated: Annotated[SimulatedPart | None, FLAT] = None
    recorded: Annotated[RecordedPart | None, FLAT] = None

    @property
    def is_recorded(self) -> bool:
        """True for a result of measured and estimated values, not of a twin's truth."""
        return self.recorded is not None

    @property
    def is_completed(self) -> bool:
        """True if the cycle ran to its planned end."""
        return self.outcome == "completed"

    @property
    def is_inside(self) -> bool:
        """True if the catheter was left in the airway, whatever the outcome."""
        return self.tip.inside_at_end

    @property
    def is_good(self) -> bool:
        """True if it ran to its planned end, the catheter is out, and no bound was broken."""
        return self.is_completed and not self.is_inside and not self.harm

    @property
    def harms(self) -> tuple[str, ...]:
        """Names of the bounds for the patient that were broken; empty without the truth."""
        return self.harm or ()

    @property
    def signs(self) -> VitalSigns:
        """Vital signs; without any of them where there is no patient."""
        return self.vitals or VitalSigns()

    @property
    def faults(self) -> tuple[FaultRecord, ...]:
        """Faults that were injected; none in a recording."""
        return () if self.simulated is None else self.simulated.faults

    @property
    def told(self) -> tuple[Announcement, ...] | None:
        """Alarms that the annunciator showed; None where they are not known."""
        return None if self.simulated is None else self.simulated.told

    @property
    def drawn_by(self) -> str | None:
        """Seed of machine and patient, with the spread where that was not the usual one."""
        if self.seed is None or self.simulated is None or self.simulated.spread == USUAL_SPREAD:
            return None if self.seed is None else str(self.seed)
        return f"{self.seed}, spread x {self.simulated.spread:g}"
