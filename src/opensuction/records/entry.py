"""Entries of the records, as a caller hands them over."""

from datetime import datetime
from enum import StrEnum
from typing import NamedTuple

from opensuction.records.trail.chain import to_hash


class Machine(NamedTuple):
    """A machine."""

    serial: str
    kind: str
    """Such as ``clinical``."""
    is_twin: bool
    """Simulated: nothing that it did happened to anybody."""


class Catheter(NamedTuple):
    """A catheter; its life begins with its first cycle."""

    label: str
    size_fr: int
    life_s: int


class SettingsFile(NamedTuple):
    """A protocol or a parameter file, known by what it holds."""

    name: str
    content: str

    @property
    def sha256(self) -> str:
        """Of the content in UTF-8."""
        return to_hash(self.content)


class CycleStart(NamedTuple):
    """Start of a cycle, with what is known before."""

    machine: Machine
    catheter: Catheter
    protocol: SettingsFile
    approach: str
    requested_by: str
    """The person who asked, by the name that the site uses, or the schedule."""
    software: str
    """With its version."""
    patient: str | None = None
    """Pseudonym; None on a bench."""
    parameter_file: SettingsFile | None = None
    settings_sha256: str | None = None
    recording: str | None = None
    """Where its recording will lie."""


class Outcome(StrEnum):
    """Outcome of a cycle."""

    COMPLETED = "completed"
    ABORTED = "aborted"
    INTERRUPTED = "interrupted"
    """Found without an end: whatever controlled it died."""


class CycleEnd(NamedTuple):
    """End of a cycle."""

    outcome: Outcome
    detail: str = ""
    inside_at_end: bool | None = None
    """Whether the catheter was still in the airway; None: not known."""


class Alarm(NamedTuple):
    """An alarm that was raised."""

    condition: str
    """By name, such as ``LINE_CLOGGED``."""
    priority: str
    detail: str = ""


class Action(NamedTuple):
    """Action of a person."""

    done_by: str
    what: str
    """Such as ``reset`` or ``set-protocol``."""
    detail: str = ""
    machine: str | None = None
    """Serial of a machine on record."""
    cycle_id: str | None = None


class BoundFile(NamedTuple):
    """A file of a recording, and what it held when its recorder had done with it."""

    name: str
    cycle_recording: str
    """Name of its first part, as the cycle has it; its own where it is that."""
    part: int
    """From 1 on; each recorder that begins anew makes one."""
    folder: str
    """Where it was written."""
    size_bytes: int
    sha256: str
    is_closed: bool
    """Its recorder finished it; otherwise it died, and the file ends where it stopped."""


class Unfinished(NamedTuple):
    """A cycle on record that has no end."""

    id: str
    machine: str
    """Serial."""
    catheter: str
    """Label."""
    patient: str | None
    started_at: datetime
    recording: str | None
