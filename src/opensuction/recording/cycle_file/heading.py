"""Heading of a recording, ahead of its rows: its origin, and the data that a replay needs."""

import hashlib
import json
from datetime import UTC, datetime
from typing import NamedTuple

from opensuction.kernel.errors import InputError

PROFILE = "opensuction"
"""In the header of the file: by it a recording is told from other MCAP files."""
FORMAT = 1
"""Of what this version writes; a change that older versions would misread takes the next number."""
ABOUT, SETTINGS = "opensuction", "settings"
"""Names of the two metadata records."""
NOTICE = (
    "In-silico: recorded on a digital twin. Research software, not a medical device, not for use "
    "on people or animals."
)
_FIXED = ("format", "software_version", "settings_hash", "fingerprint", "began_utc", "checksum")


class Heading(NamedTuple):
    """The description of a recording."""

    software_version: str
    settings: str
    """Of the controller, as JSON."""
    settings_hash: str
    fingerprint: str
    """Of the arithmetic that the controller ran with; see `kernel.arithmetic_fingerprint`."""
    began_ns: int
    """UTC at tick 0, in nanoseconds since 1970."""
    about: dict[str, str]
    """Whatever else is known, by name: patient, protocol, seed, notice."""

    @property
    def began_utc(self) -> str:
        """The beginning as people read it."""
        return datetime.fromtimestamp(self.began_ns / 1e9, tz=UTC).isoformat()


Metadata = dict[str, dict[str, str]]
"""Metadata records of an MCAP file, by name."""


def _checksum(about: dict[str, str], settings: str) -> str:
    """Of everything else, for MCAP gives metadata none."""
    rest = {name: value for name, value in about.items() if name != "checksum"}
    content = json.dumps([rest, settings], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()


def to_metadata(heading: Heading) -> Metadata:
    """The metadata records of a heading. Raises ValueError for a name that it has itself."""
    if taken := set(_FIXED) & set(heading.about):
        raise ValueError(f"a recording's heading has {', '.join(sorted(taken))} of its own")
    about = {
        "format": str(FORMAT),
        "software_version": heading.software_version,
        "settings_hash": heading.settings_hash,
        "fingerprint": heading.fingerprint,
        "began_utc": f"{heading.began_utc} ({heading.began_ns} ns)",
        # The name of a file may hold bytes that are no UTF-8.
        **{
            name: value.encode("utf-8", "backslashreplace").decode()
            for name, value in heading.about.items()
        },
    }
    about["checksum"] = _checksum(about, heading.settings)
    return {ABOUT: about, SETTINGS: {"json": heading.settings}}


def from_metadata(name: str, metadata: Metadata) -> Heading:
    """The heading of these records.

    name: of the file, for messages. Raises InputError for records of a newer version, and for
    damaged ones.
    """
    about = metadata.get(ABOUT, {})
    written = about.get("format", "")
    if written.isdecimal() and int(written) > FORMAT:
        raise InputError(
            f"{name}: is a recording of format {written}, written by opensuction "
            f"{about.get('software_version', '(unknown)')!r}; this version reads up to {FORMAT}: "
            "take a newer one"
        )
    settings = metadata.get(SETTINGS, {}).get("json", "")
    if about.get("checksum") != _checksum(about, settings):
        raise InputError(f"{name}: its heading is damaged, nothing of it can be relied upon")
    began = about["began_utc"].rpartition("(")[2].partition(" ")[0]
    return Heading(
        software_version=about["software_version"],
        settings=settings,
        settings_hash=about["settings_hash"],
        fingerprint=about["fingerprint"],
        began_ns=int(began),
        about={key: value for key, value in about.items() if key not in _FIXED},
    )
