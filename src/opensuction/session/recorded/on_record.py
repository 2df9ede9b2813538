"""A recording held against the records: whether it is what was put on record under its name."""

from pathlib import Path
from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import extent
from opensuction.records import audit, recording_check
from opensuction.records.database import address
from opensuction.records.database.failure import RecordsError
from opensuction.records.history import History
from opensuction.records.recording_check import WRITTEN, BoundRecording, Fault, Kind

BOUND, UNBOUND, UNKNOWN = "bound", "unbound", "unknown"


class OnRecord(NamedTuple):
    """State of a file by the records."""

    state: str
    """Bound, unbound, unknown where there are no records, or the kind of its fault."""
    sentence: str

    @property
    def is_faulty(self) -> bool:
        """True if it is not what was put on record."""
        return self.state not in (BOUND, UNBOUND, UNKNOWN)


def find(path: Path, database: str | None) -> OnRecord:
    """State of a recording by the records.

    database: see `Records.open`; None: the default one, where there is one. Raises InputError for
    a file that is the recording of something else, and where a database that was named cannot be
    read.
    """
    misnamed = recording_check.find_misnaming(path)
    if misnamed is not None:
        raise InputError(misnamed.sentence)
    place = address.parse(database)
    if database is None and place.file is not None and not place.file.exists():
        return OnRecord(UNKNOWN, "no records are here to hold it against")
    try:
        opened = audit.open_for_audit(database)
        try:
            with opened.reading() as connection:
                audit.require_newest(connection, opened.address.shown)
            return _look_up(path, History(opened))
        finally:
            opened.engine.dispose()
    except RecordsError as error:
        if database is not None:
            raise
        return OnRecord(UNKNOWN, f"it was not held against the records: {error}")


def _look_up(path: Path, history: History) -> OnRecord:
    """By its name, by what it holds, and by the name that it gives itself."""

    def find_owner(sha256: str) -> BoundRecording | None:
        return history.find_recording(sha256=sha256)

    known = history.find_recording(name=path.name)
    if known is None:
        known = _find_by_content(path, history)
    if known is None:
        return OnRecord(UNBOUND, "unbound: no hash of it is on record")
    fault = recording_check.check(known, path, find_owner)
    if fault is None and known.file.name != path.name and WRITTEN.fullmatch(path.name):
        fault = Fault(Kind.SWAPPED, f"{path.name} is not what it is called: it is {known.said}")
    if fault is None:
        return OnRecord(BOUND, f"{known.said}, as its recorder left it")
    if fault.kind in (Kind.SWAPPED, Kind.MISSING, Kind.UNREADABLE):
        raise InputError(fault.sentence)
    return OnRecord(fault.kind, fault.sentence)


def _find_by_content(path: Path, history: History) -> BoundRecording | None:
    try:
        (found,) = extent.measure(path)
    except OSError:
        return None  # whoever reads it says why
    own = recording_check.find_own_name(path)
    by_hash = history.find_recording(sha256=found.sha256)
    return by_hash or (None if own is None else history.find_recording(name=own))
