"""Entries of the records, as a caller hands them over, and their bounds.

Checks of entries before they reach the database, whose own messages are less plain. A process that
only names what is on record, as the controller's, needs no database for it.
"""

import hashlib
import re
from datetime import datetime
from enum import StrEnum
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.settings.wording import show

LONGEST_NAME = 64
LONGEST_TEXT = 4000
HASH_DIGITS = 64
"""Of SHA-256 in hexadecimal."""
LONGEST_FILE = 1_000_000
"""Characters of a settings file, as `settings.toml_file` reads them."""
LONGEST_LIFE_S = 86_400
"""A catheter is never used for longer. Source: [paper] II-A."""
LARGEST_FR = 30
LARGEST_PART = 1000
"""As many files a recorder makes of one recording."""
LARGEST_FILE = 2**62
"""Bytes of a recording."""
OUTCOMES = ("completed", "aborted", "interrupted")
"""Interrupted: found without an end after a crash."""
PRIORITIES = ("low", "medium", "high")
APPROACHES = ("travel", "contact")


def to_hash(content: str) -> str:
    """SHA-256 in hexadecimal."""
    return hashlib.sha256(content.encode("utf-8")).hexdigest()


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


PSEUDONYM = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
HASH = re.compile(rf"[0-9a-f]{{{HASH_DIGITS}}}")


def _check_text(what: str, value: object, longest: int, shortest: int) -> None:
    if not isinstance(value, str):
        raise InputError(f"{what} is {show(value)}, not a text")
    if not shortest <= len(value) <= longest:
        raise InputError(f"{what} has {len(value)} characters; {shortest} to {longest} are taken")
    if "\0" in value or _is_torn(value):
        raise InputError(f"{what} {show(value)} has characters that no text has")


def _is_torn(value: str) -> bool:
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:  # half a character, as a wrongly decoded name has
        return True
    return False


def check_name(what: str, value: object) -> None:
    """Raises InputError for what is no name of 1 to 64 characters."""
    _check_line(what, value, LONGEST_NAME)


def check_reason(what: str, value: object) -> None:
    """Raises InputError for what a person wrote that is no single line of what can be read."""
    _check_line(what, value, LONGEST_TEXT)


def _check_line(what: str, value: object, longest: int) -> None:
    """Check a typed line: lists and logs show it, where it must not look like something else."""
    _check_text(what, value, longest, 1)
    if not str(value).isprintable() or str(value) != str(value).strip():
        raise InputError(f"{what} {show(value)} has spaces around it or invisible characters")


def check_detail(what: str, value: object) -> None:
    """Raises InputError for what is no text of a few lines."""
    _check_text(what, value, LONGEST_TEXT, 0)


def check_search(value: object, longest: int) -> None:
    """Raises InputError for what nothing on record can have in it."""
    _check_text("the text to look for", value, longest, 1)


def check_pseudonym(value: object) -> None:
    """Raises InputError for what may be the name of a person."""
    check_name("the pseudonym", value)
    if not PSEUDONYM.fullmatch(str(value)):
        raise InputError(
            f"the pseudonym {show(value)} is none: letters, digits, '.', '_' and '-' only, such as "
            "'P-0042'; never a name, a date of birth or a hospital's number"
        )


def check_hash(what: str, value: object) -> None:
    """Raises InputError for what is no SHA-256."""
    if not isinstance(value, str) or not HASH.fullmatch(value):
        raise InputError(f"{what} {show(value)} is no SHA-256 of 64 hexadecimal digits")


def check_whole(what: str, value: object, longest: int, unit: str) -> None:
    """Raises InputError for what is no whole number from 1 on."""
    if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= longest:
        raise InputError(
            f"{what} is {show(value)}; whole numbers from 1 to {longest}{unit and ' '}{unit}"
        )


def _check_choice(what: str, value: object, known: tuple[str, ...]) -> None:
    if value not in known:
        raise InputError(f"{what} {show(value)} is none of {', '.join(known)}")


def check_file(what: str, file: SettingsFile) -> None:
    """Raises InputError for what is no settings file."""
    check_name(f"the name of the {what}", file.name)
    _check_text(f"the {what}", file.content, LONGEST_FILE, 0)


def check_machine(machine: Machine) -> None:
    """Raises InputError for what is no machine."""
    check_name("the machine's serial", machine.serial)
    check_name("the machine's kind", machine.kind)
    if not isinstance(machine.is_twin, bool):
        raise InputError("whether the machine is a twin must be true or false")


def check_start(start: CycleStart) -> None:
    """Raises InputError for what is no cycle."""
    check_machine(start.machine)
    check_name("the catheter's label", start.catheter.label)
    check_whole("the catheter's size", start.catheter.size_fr, LARGEST_FR, "Fr")
    check_whole("the catheter's life", start.catheter.life_s, LONGEST_LIFE_S, "s")
    check_file("protocol", start.protocol)
    _check_choice("the approach", start.approach, APPROACHES)
    check_name("who requested it", start.requested_by)
    check_name("the software", start.software)
    if start.patient is not None:
        check_pseudonym(start.patient)
    if start.parameter_file is not None:
        check_file("parameter file", start.parameter_file)
    if start.settings_sha256 is not None:
        check_hash("the settings' hash", start.settings_sha256)
    if start.recording is not None:
        _check_text("the recording", start.recording, LONGEST_TEXT, 1)


def check_end(end: CycleEnd) -> None:
    """Raises InputError for what is no end of a cycle."""
    _check_choice("the outcome", end.outcome, OUTCOMES)
    check_detail("the detail of the outcome", end.detail)
    if end.inside_at_end is not None and not isinstance(end.inside_at_end, bool):
        raise InputError("whether the catheter was inside must be true, false or not known")


def check_alarm(alarm: Alarm) -> None:
    """Raises InputError for what is no alarm."""
    check_name("the alarm's condition", alarm.condition)
    _check_choice("the alarm's priority", alarm.priority, PRIORITIES)
    check_detail("the alarm's detail", alarm.detail)


def check_action(action: Action) -> None:
    """Raises InputError for what is no action."""
    check_name("who did it", action.done_by)
    check_name("what was done", action.what)
    check_detail("the action's detail", action.detail)
    if action.machine is not None:
        check_name("the machine's serial", action.machine)
    if action.cycle_id is not None:
        check_name("the cycle's id", action.cycle_id)


def check_recording(file: BoundFile) -> None:
    """Raises InputError for what is no file of a recording."""
    for what, name in (("recording", file.name), ("cycle's recording", file.cycle_recording)):
        check_name(f"the name of the {what}", name)
        if "/" in name:
            raise InputError(f"the name of the {what} {show(name)} is no name of a file")
    _check_text("the folder of the recording", file.folder, LONGEST_TEXT, 1)
    check_hash("the recording's hash", file.sha256)
    check_whole("the recording's part", file.part, LARGEST_PART, "")
    check_whole("the recording's size + 1", file.size_bytes + 1, LARGEST_FILE, "bytes")
    if not isinstance(file.is_closed, bool):
        raise InputError("whether the recording was closed must be true or false")
