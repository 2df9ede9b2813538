"""Result of a day of cycles: a row a cycle, what gathered meanwhile, what self-calibration found.

Field names are the keys of the JSON object, with their units (docs/reference/results.md).
"""

from typing import Annotated, Literal, NamedTuple

from opensuction.kernel.record import Array
from opensuction.result.cycle_result import AlarmRecord, Announcement, CycleResult
from opensuction.result.plain import FLAT, IF_KNOWN


class GapResult(NamedTuple):
    """Width of the gap and depth of the tip by one cycle, and what the next goes by."""

    used_scale: float
    """Scales: width as a multiple of the identified one."""
    contact_scale: float | None
    mouth_scale: float | None
    next_scale: float
    least_scale: float
    most_scale: float
    used_offset_mm: float
    """Offsets: by how much the tip lies deeper than identified."""
    mouth_offset_mm: float | None
    next_offset_mm: float
    usual_scale: float
    finding: str
    contact_spoilt: str | None
    """Sentence: why the contact told nothing."""
    mouth_missed: str | None
    """Sentence: why the light barrier told nothing."""
    in_range: bool


class CycleNews(NamedTuple):
    """First thing to know of a cycle, and its page."""

    headline: str
    verdict: str
    """``good``, ``notice`` or ``bad``."""
    report: str | None
    """Name of the page's file."""


class DayCycleResult(NamedTuple):
    """One cycle of a day."""

    number: int
    start_min: float
    outcome: Literal["completed", "aborted"]
    rmse_mm: float | None
    secretion_before_ml: float
    removed_ml: float
    removed_percent: float | None
    bore_ml: float
    """Mucus that stays in the catheter."""
    negative_pressure_s: float
    in_airway_s: float
    inside_at_end: bool
    end_mm: float
    harm: tuple[str, ...]
    told: tuple[Announcement, ...]
    spo2_nadir_percent: float | None
    lung_volume_loss_ml: float | None
    trips: tuple[str, ...]
    alarms: tuple[AlarmRecord, ...]
    catheter_age_h: float
    catheter_changed: bool
    assessed: bool
    """A person looked at the patient just before it."""
    preoxygenation: str
    gap: GapResult | None
    """None without self-calibration, or after a broken cycle."""
    news: Annotated[CycleNews | None, FLAT] = None
    """None where no report was made."""

    @property
    def is_completed(self) -> bool:
        """True if it ran to its planned end."""
        return self.outcome == "completed"

    @property
    def is_good(self) -> bool:
        """True if it ran to its planned end, the catheter is out, and no bound was broken."""
        return self.is_completed and not self.inside_at_end and not self.harm


class DaySamples(NamedTuple):
    """The patient over the day, arrays of one length."""

    time_s: Array
    secretion_ml: Array
    spo2_percent: Array
    lung_volume_loss_ml: Array


class DayResult(NamedTuple):
    """A day of cycles, or what was done of it."""

    repeat: int
    every_min: float
    cycles: tuple[DayCycleResult, ...]
    produced_ml: float
    removed_ml: float
    left_ml: float
    coughed_ml: float
    canister_ml: float
    spo2_nadir_percent: float | None
    catheter_changes: int
    assessments: int
    refusal: str | None
    """Why self-calibration let no further cycle begin."""
    notes: tuple[str, ...]

    @property
    def is_good(self) -> bool:
        """True if every cycle was good, and nothing was refused."""
        return self.refusal is None and all(cycle.is_good for cycle in self.cycles)


class CycleAndDay(NamedTuple):
    """One cycle, or the last one of a day and the day."""

    cycle: Annotated[CycleResult, FLAT]
    day: Annotated[DayResult | None, IF_KNOWN]
