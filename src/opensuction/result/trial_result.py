"""Result of a trial: counts of its cycles with their bounds, what was broken, and the endpoints.

Names and units of the fields are those of its JSON object (docs/reference/results.md).
"""

from collections.abc import Mapping
from typing import Annotated, Generic, Literal, NamedTuple, TypeVar

from opensuction.result.cycle_result import CycleResult, LeftInsideCount
from opensuction.result.plain import FLAT, IF_KNOWN

Value = TypeVar("Value")
FaultCount = Literal["none", "single", "double"]
"""How many faults come to a cycle."""


class Trial(NamedTuple):
    """Choice of a trial's cycles: a number stands for the same cycle, however many there are."""

    faults: FaultCount = "single"
    cohort: str = "presets"
    """Set of patients, by name."""
    seed: int = 1
    compensation: str = "preview"
    preoxygenation: str = "confirmed"
    """Where guidelines ask for it."""


class ByFaults(NamedTuple, Generic[Value]):
    """One value for the cycles without a fault, one for those with one, one for those with two.

    Faults count that came when they could matter.
    """

    none: Value
    single: Value
    double: Value


class ShareBound(NamedTuple):
    """Share of cycles that broke something, with its upper 95 % confidence bound."""

    cycles: int
    broken: int
    upper_percent: float


class TrialBounds(NamedTuple):
    """Share of cycles that broke something, by what they are held against."""

    commands: ShareBound
    """Invariants of what the controller sends, all cycles."""
    patient: Annotated[ByFaults[ShareBound], FLAT]
    """Bounds of the patient."""
    false_alarms: ShareBound
    """Cycles without a fault of which something was said that was not so."""


class LateFaults(NamedTuple):
    """Faults that came when the first of their cycle had already had the catheter drawn out."""

    faults: int
    by_fault: Mapping[str, int]
    """Of each of them, by name."""


class Violation(NamedTuple):
    """A bound that a cycle broke."""

    number: int
    """Of the cycle."""
    patient: str
    approach: str
    faults: tuple[str, ...]
    """Those that counted, by name."""
    counted: int
    bound: str
    is_command: bool
    """What was commanded, not what happened to the patient."""
    worst: float | None
    """None where it was no number."""
    limit: float
    play: str
    """The command line that plays the cycle again."""


class CatheterLeftInside(NamedTuple):
    """A catheter that was still in the airway when nobody watched any longer."""

    unavoidable: str
    """The argument; empty where something could have brought it out."""
    person: str
    """What a person must do."""
    told_s: float | None
    """How long after the first fault people were told with high priority; None for never."""
    in_time: bool
    """Whether that was within its bound."""


class LeftInsideReason(NamedTuple):
    """Catheters that were left inside for one reason."""

    unavoidable: str
    """The argument; empty where something could have brought it out."""
    person: str
    """What a person must do."""
    count: int  # type: ignore[assignment] # over tuple's method: the key in JSON
    faults: Mapping[str, int]
    """Cycles by the faults that came, the most frequent first."""


class LeftInsideCycles(NamedTuple):
    """Catheters left inside: how many, by how many faults, and for which reasons."""

    total: Annotated[LeftInsideCount, FLAT]
    by_faults: ByFaults[LeftInsideCount]
    slowest_told_s: float | None
    """Of those told in time; None where there is none."""
    because: tuple[LeftInsideReason, ...]
    """The most frequent reason first."""


class SaidCycle(NamedTuple):
    """A cycle without a fault of which something was said."""

    number: int
    patient: str
    approach: str
    seed: int
    """Of its machine and patient."""
    completed: bool
    false: tuple[str, ...]
    """What was not so, by name of the condition."""
    true: tuple[str, ...]
    play: str
    """The command line that plays it again."""


class Unnoticed(NamedTuple):
    """Cycles to which a fault came alone, and those of them in which nobody was told anything."""

    cycles: int
    unnoticed: int


class Endpoints(NamedTuple):
    """Endpoints of a cycle, by the truth: what trials of devices compare."""

    removed_ml: float
    removed_percent: float | None
    """Of the secretions that lay there, and came meanwhile; None where there were none."""
    spo2_least_percent: float
    lung_volume_loss_ml: float
    in_airway_s: float
    suction_s: float
    force_peak_n: float


class EndpointSpread(NamedTuple):
    """An endpoint over cycles."""

    median: float
    p5: float
    p95: float


class PatientEndpoints(NamedTuple):
    """Cycles of one patient, and their `Endpoints`; None for one without a number in any cycle."""

    cycles: int
    completed: int
    removed_ml: Annotated[EndpointSpread | None, IF_KNOWN] = None
    removed_percent: Annotated[EndpointSpread | None, IF_KNOWN] = None
    spo2_least_percent: Annotated[EndpointSpread | None, IF_KNOWN] = None
    lung_volume_loss_ml: Annotated[EndpointSpread | None, IF_KNOWN] = None
    in_airway_s: Annotated[EndpointSpread | None, IF_KNOWN] = None
    suction_s: Annotated[EndpointSpread | None, IF_KNOWN] = None
    force_peak_n: Annotated[EndpointSpread | None, IF_KNOWN] = None


class WatchedTime(NamedTuple):
    """For how long machine and patient were watched together once the machine was at rest."""

    mean: float
    whole: int
    """Cycles that were watched for the longest time."""
    most: float
    """The longest time."""


class TrialResult(NamedTuple):
    """Result of a trial, complete or not."""

    version: str
    """Of the software."""
    sources: str
    """Hash of all that decides what a cycle is."""
    in_silico: bool
    date_utc: str
    trial: Trial
    cycles: int
    """That are there."""
    asked: int
    """That were wanted."""
    complete: bool
    machines: int
    refused: tuple[str, ...]
    """Why machines that were drawn are of no use: a line each."""
    counted: ByFaults[int]
    """Cycles."""
    not_counted: LateFaults
    bounds: TrialBounds
    command_breaches: int
    """Cycles in which an invariant of what the controller sends was broken."""
    violations: tuple[Violation, ...]
    left_inside: LeftInsideCycles
    too_slow: int
    """Cycles with one fault that broke a bound of time which no withdrawal with the drive's whole
    voltage could have kept; people were told in time."""
    false_alarms: int
    """Cycles without a fault that tripped, were broken off or told something that was not so."""
    false_before_fault: int
    """Cycles with faults in which that was so before the first of them."""
    true_alarms: int
    """Cycles without a fault that told something of the patient that was so."""
    broken_off: int
    """Cycles without a fault that were not completed."""
    said: tuple[SaidCycle, ...]
    untold: Mapping[str, Unnoticed]
    """By the name of the fault."""
    endpoints: Mapping[str, PatientEndpoints]
    """By the name of the patient."""
    watched_s: WatchedTime
    workers: int
    """Processes."""
    wall_s: float
    """Time of playing."""
    cycles_per_s: float | None
    """In that time; None where nothing was left to play."""


class TrialCycle(NamedTuple):
    """Result of one cycle of a trial."""

    number: int
    play: str
    """The command line that plays it again."""
    counted: int
    """Faults that came and could matter."""
    told: bool
    """Whether people were told of anything from the first fault on."""
    false_alarms: tuple[str, ...]
    """What was said before any fault, or without one, and was not so."""
    true_alarms: tuple[str, ...]
    """And what was."""
    left_inside: CatheterLeftInside | None
    """None where the tip is out."""
    violations: tuple[Violation, ...]
    endpoints: Endpoints
    watched_s: float


class PlayedCycle(NamedTuple):
    """A cycle of a trial that was played again, and what the trial says of it."""

    cycle: Annotated[CycleResult, FLAT]
    trial: TrialCycle
