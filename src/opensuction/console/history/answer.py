"""Response bodies of the history's routes, as the interface describes them."""

from datetime import date, datetime
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field

from opensuction.console.history.archive import Day
from opensuction.console.live import hub
from opensuction.records.history import PastAction, PastAlarm, PastCycle

Stage = Literal["none", "running", "done", "failed"]
"""Of work that takes a while."""


class Cycle(BaseModel):
    """A cycle on record."""

    id: str
    number: int
    machine: str
    catheter: str
    patient: str | None
    protocol: str
    approach: str
    requested_by: str
    software: str
    started_at: datetime
    ended_at: datetime | None
    outcome: Literal["completed", "aborted", "interrupted"] | None
    """None: it has not ended, or nobody has said so."""
    detail: str
    why: str
    """The same in words."""
    inside_at_end: bool | None
    has_recording: bool
    """Its recording lies here, and is finished."""
    recording_bytes: int | None
    recording_parts: int
    recording_bound: bool
    """A hash of it is on record."""
    recording_fault: str | None
    """How it is not what was put on record; in a list by its presence and length alone."""

    @classmethod
    def of(
        cls, cycle: PastCycle, parts_bytes: tuple[int, int] | None, bound: bool, fault: str | None
    ) -> Self:
        """parts_bytes: how many parts its recording has, and their size; None: it is not here."""
        kept = {name: value for name, value in cycle._asdict().items() if name in cls.model_fields}
        kept["outcome"] = None if cycle.outcome is None else str(cycle.outcome)
        parts, size = parts_bytes or (0, None)
        return cls(
            **kept,
            why=hub.say(cycle.detail),
            has_recording=parts_bytes is not None and cycle.outcome is not None,
            recording_bytes=size,
            recording_parts=parts,
            recording_bound=bound,
            recording_fault=fault,
        )


class Alarm(BaseModel):
    """An alarm on record."""

    id: str
    number: int
    machine: str
    cycle_id: str | None
    condition: str
    priority: str
    detail: str
    raised_at: datetime

    @classmethod
    def of(cls, alarm: PastAlarm) -> Self:
        """Of one on record."""
        return cls(**alarm._asdict())


class Action(BaseModel):
    """Action of a person."""

    id: str
    number: int
    done_by: str
    what: str
    detail: str
    machine: str | None
    cycle_id: str | None
    done_at: datetime

    @classmethod
    def of(cls, action: PastAction) -> Self:
        """Of one on record."""
        return cls(**action._asdict())


class Cycles(BaseModel):
    """A page of cycles, the newest first."""

    cycles: list[Cycle]
    next: int | None
    """``before`` of the next page; None: this is the last."""


class Alarms(BaseModel):
    """A page of alarms, the newest first."""

    alarms: list[Alarm]
    next: int | None


class Actions(BaseModel):
    """A page of actions, the newest first."""

    actions: list[Action]
    next: int | None


class Difference(BaseModel):
    """First difference between a replay and its recording."""

    time_s: float
    tick: int
    field: str
    recorded: float | None
    """None: no finite number."""
    replayed: float | None


class ReplayVerdict(BaseModel):
    """Result of the replay of a recording through the controller."""

    is_good: bool
    identical: bool
    equivalent: bool
    ticks: int
    differing_ticks: int
    gaps: int
    whole: bool
    damaged: bool
    first_difference: Difference | None
    notes: list[str]


class Replay(BaseModel):
    """State of the replay of a cycle's recording, and its result."""

    state: Stage
    verdict: ReplayVerdict | None
    failure: str | None


class AuditVerdict(BaseModel):
    """Result of an audit of the whole trail."""

    is_whole: bool
    entries: int
    last_hash: str
    broken: str | None
    broken_at: int | None
    expected: str | None
    recordings: int
    """That were held against their hashes."""
    faults: list[str]
    """What is wrong with them."""
    unbound: int
    """Cycles whose recording has no hash on record."""
    unbound_since: list[str]
    """Which of them came after the first that has one."""


class Audit(BaseModel):
    """The trail of the records."""

    state: Stage
    entries: int
    head: str
    checked_at: datetime | None
    verdict: AuditVerdict | None
    failure: str | None


class AuditRequest(BaseModel):
    """To read the whole trail."""

    model_config = ConfigDict(extra="forbid", strict=True)

    expected: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")] | None = None
    """Hash of a head that was noted before: a trail that was cut off since is found."""


class Spread(BaseModel):
    """A quantity over a day's cycles."""

    cycles: int
    lowest: float
    median: float
    highest: float
    total: float


class TrendDay(BaseModel):
    """One day."""

    day: date
    outcomes: dict[str, int]
    quantities: dict[str, Spread | None]

    @classmethod
    def of(cls, day: Day) -> Self:
        """Of one that was worked out."""
        quantities: dict[str, Any] = {
            name: None if found is None else found._asdict()
            for name, found in day.quantities.items()
        }
        return cls(day=day.day, outcomes=day.outcomes, quantities=quantities)


class Trends(BaseModel):
    """Trends over days."""

    days: list[TrendDay]
    cycles: int
    pending: int
    """Recordings whose figures are being worked out: ask again."""
    without_recording: int
    """Cycles whose recording is not here, is not finished, or cannot be read."""
    cut: bool
    """There are more cycles than are looked at: the oldest are left out."""
