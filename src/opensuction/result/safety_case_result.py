"""Result of a safety case: hazards with their runs, searches for harm, details for a page.

Times are in ms from the instant of the fault. None stands where nothing was measured or came.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.result.cycle_result import LeftInsideCount

Series = npt.NDArray[np.float32]
"""A series of a strip chart."""


class WorstExposure(NamedTuple):
    """Each measure of the patient's exposure, of the run of a hazard in which it was worst."""

    end_mm: float | None
    """Tip below the tube's lower end."""
    piece_mm: float | None
    """Length of the piece of the catheter that lies in the airway."""
    in_airway_s: float | None
    suction_s: float | None
    """With vacuum at the tip, in the airway."""
    vacuum_peak_mmhg: float | None
    """At the tip, in the airway."""
    advance_mm: float | None
    """Insertion under vacuum, all stretches together."""
    deepest_mm: float | None
    past_carina_mm: float | None
    force_peak_n: float | None
    """On the carina."""
    contact_s: float | None
    pressure_unsafe_s: float | None
    airway_pressure_least_cmh2o: float | None
    lung_volume_loss_ml: float | None
    spo2_least_percent: float | None


class HazardRun(NamedTuple):
    """A run of the hazard table."""

    fault: str
    phase: str | None
    """In which the fault came; None where it was there before the start or had no phase."""
    after_s: float | None
    """How long into the phase the fault came, or into the run where it had none; None where the
    cycle was refused before."""
    strength: float | None
    """None for a fault that has none."""
    approach: str
    patient: str
    seed: int
    alarm: str | None
    """The expected condition that people were told of first."""
    by: str | None
    """Who raised it: controller, drives or power."""
    detected_ms: float | None
    """Until people were told."""
    detected_bound_ms: float
    safe_ms: float | None
    """Until the safe state that lasts."""
    safe_bound_ms: float
    harm: tuple[str, ...]
    """Bounds of the patient that were broken, for whatever cause."""
    left_inside: bool
    within_limits: bool
    """No bound of the patient was broken and the safe state reached."""
    ok: bool
    problem: str | None
    """What is broken, in words."""


class HarmSearchRun(NamedTuple):
    """A run of a search for harm, with the bound of the patient that it came nearest to."""

    fault: str
    after_s: float | None
    """Into the run; None for a fault that was there before the start."""
    strength: float | None
    """None for a fault that has none."""
    approach: str
    patient: str
    seed: int
    spread: float
    """How many times as far from the nominal ones as usual machine and patient were drawn."""
    bound: str
    worst: float | None
    """Value that is held against the bound."""
    limit: float | None
    """The bound, with what the fault makes unavoidable added."""
    unit: str
    """Of both."""
    share: float | None
    """How much of the way from the same cycle without a fault to the bound it went; None where a
    bound was broken."""
    told: bool
    """People were told of anything from the fault on."""
    broken: tuple[str, ...]
    """Bounds of the patient and of the commands that were broken."""
    unavoidable: tuple[str, ...]
    """Bounds of time that were broken and that no withdrawal could have kept."""


class HarmSearchResult(NamedTuple):
    """Result of a hazard's search for harm."""

    runs: int
    broken: int
    """Of them."""
    worst: HarmSearchRun | None
    """None where no run was possible or none was asked for."""
    problems: tuple[HarmSearchRun, ...]
    """Runs that broke a bound."""
    unavoidable: tuple[HarmSearchRun, ...]
    """Runs that broke a bound of time which no withdrawal could have kept."""


class HazardSummary(NamedTuple):
    """A hazard over all of its runs; alarm, times and safe state are those of its worst run."""

    id: str
    hazard: str
    severity: str
    """Of the harm: negligible, minor, serious or critical."""
    fault: str
    """With instant, strength, patient and seed, as the command line writes them."""
    alarm: str | None
    by: str | None
    priority: str
    """Of the alarm: none, low, medium or high."""
    detected_ms: float | None
    detected_bound_ms: float
    safe_state: str
    """Name of the one that was claimed."""
    safe_ms: float | None
    safe_bound_ms: float
    refused: bool
    """The cycle was refused before anything moved, as the table has it."""
    within_limits: bool
    """Neither alarm nor safe state was needed."""
    left_inside: LeftInsideCount
    unavoidable: tuple[str, ...]
    """Why a catheter could not have come out."""
    person: tuple[str, ...]
    """What a person must do about a catheter that stays inside."""
    ok: bool
    runs: int
    broken: int
    """Of them."""
    harm: tuple[str, ...]
    """Bounds of the patient that were broken in some run, the most urgent first."""
    exposure: WorstExposure
    requirements: tuple[str, ...]
    only_because: tuple[str, ...]
    """Why some of its faults are not run on every patient or approach."""
    worst: HazardRun
    searched: HarmSearchResult
    problems: tuple[HazardRun, ...]
    """Runs that broke a bound."""


class SearchedDayRun(NamedTuple):
    """A day of cycles without a fault, by the bound that it broke or came nearest to."""

    command: str
    """The day as the command line writes it."""
    patient: str
    approach: str
    self_calibrates: bool
    seed: int
    spread: float
    cycles: int
    aborted: int
    """Cycles that were broken off."""
    cycle: int
    """In which the bound was broken or come nearest to, from 1."""
    bound: str
    worst: float
    limit: float
    unit: str
    """Of both."""
    share: float | None
    """Worst value over its limit; None where a bound was broken."""
    told: bool
    """People were told of anything in that cycle."""
    broken: tuple[str, ...]
    """Bounds that were broken in some cycle."""


class DaySearchResult(NamedTuple):
    """Result of the search for harm over days without a fault."""

    days: int
    cycles: int
    aborted: int
    """Of them: broken off without a fault."""
    refused: int
    """Days whose machine cannot do the protocol: no cycle begins."""
    broken: int
    """Days in which a bound was broken."""
    untold: int
    """Of them: days in which it was broken in a cycle of which people were told nothing."""
    worst: SearchedDayRun | None
    """None where no day was asked for."""
    problems: tuple[SearchedDayRun, ...]
    """Days in which a bound was broken."""


class SafetyCaseResult(NamedTuple):
    """Result of every hazard that was asked for."""

    version: str
    in_silico: bool
    seeds: tuple[int, ...]
    runs: int
    """Of all hazards, without those of the searches."""
    broken: int
    """Of them."""
    left_inside: LeftInsideCount
    ok: bool
    hazards: tuple[HazardSummary, ...]
    days: DaySearchResult
    wall_s: float


class StripChart(NamedTuple):
    """A run thinned for a strip chart; series of one length."""

    time_s: Series
    head_mm: Series
    tip_mm: Series
    vacuum_mmhg: Series
    valve_percent: Series
    reaction: Series
    """Of the governor."""
    priority: Series
    """Of the alarm."""


class StripMark(NamedTuple):
    """An instant on a strip chart."""

    name: str
    time_s: float


class FaultSummary(NamedTuple):
    """A fault of a hazard in one phase, by its worst run over strengths, patients and seeds."""

    fault: str
    phase: str
    """In words."""
    strengths: str
    """With their unit; empty for a fault that has none."""
    runs: int
    alarm: str | None
    detected_ms: float | None
    detected_bound_ms: float
    safe_ms: float | None
    safe_bound_ms: float
    finding: str
    """What is broken, or that nothing is."""
    ok: bool


class HazardDetail(NamedTuple):
    """A hazard as a page shows it: its summary, the words of its table, every fault, a chart."""

    summary: HazardSummary
    cause: str
    effect: str
    detection: str
    control: str
    safe_state: str
    """In words."""
    because: tuple[str, ...]
    """Arguments for the bounds."""
    sentence: str | None
    """What a person reads at the worst run's alarm."""
    refusal: bool
    """The worst run was refused, or should have been."""
    faults: tuple[FaultSummary, ...]
    strip: StripChart | None
    """Of the worst run; None where nothing ran."""
    marks: tuple[StripMark, ...]
    """On it."""
