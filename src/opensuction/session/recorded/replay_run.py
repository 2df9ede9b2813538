"""A recording replayed, from its file to plain data."""

from pathlib import Path

from opensuction import __version__
from opensuction.controller import configuration
from opensuction.kernel import arithmetic_fingerprint
from opensuction.recording.cycle_file.heading import Heading
from opensuction.recording.cycle_file.reader import RecordingReader
from opensuction.result.plain import Json, without_nan
from opensuction.runtime import replay as replays
from opensuction.runtime.replay import Difference, Replay
from opensuction.simulation.closed_loop import DT_S


def describe(heading: Heading) -> Json:
    """What a recording says of itself, but for its settings."""
    return {
        "software_version": heading.software_version,
        "settings_hash": heading.settings_hash,
        "fingerprint": heading.fingerprint,
        "began_utc": heading.began_utc,
        **heading.about,
    }


def _notes(heading: Heading) -> list[str]:
    """What is not as it was when the recording was made."""
    notes = []
    if heading.software_version != __version__:
        notes.append(
            f"it was recorded by opensuction {heading.software_version}, this is {__version__}"
        )
    here = arithmetic_fingerprint.fingerprint()
    if heading.fingerprint != here:
        notes.append(
            f"its arithmetic was another ({heading.fingerprint}, here {here}): functions such as "
            "exp may differ in their last bit"
        )
    found = configuration.hash_of(configuration.from_json(heading.settings))
    if heading.settings_hash != found:
        notes.append(
            f"its settings have another hash here ({heading.settings_hash[:16]} as recorded, "
            f"{found[:16]} here): this version reads them otherwise"
        )
    return notes


def _difference(first: Difference | None) -> Json | None:
    if first is None:
        return None
    return {"time_s": first.tick * DT_S, **first._asdict()}


def run(path: Path) -> Json:
    """Replay a recording. Raises InputError for what cannot be."""
    reader = RecordingReader(path)
    heading = reader.heading
    found: Replay = replays.replay(reader)
    data: Json = {
        "file": str(path),
        "ticks": found.ticks,
        "identical": found.identical,
        "equivalent": found.equivalent,
        "differing_ticks": found.differing_ticks,
        "first_difference": _difference(found.first),
        "starts": found.starts,
        "gaps": found.gaps,
        "whole": reader.flaw is None,
        "damaged": reader.is_damaged,
        "flaw": reader.flaw,
        "recorded": describe(heading),
        "here": {
            "software_version": __version__,
            "fingerprint": arithmetic_fingerprint.fingerprint(),
        },
        "notes": _notes(heading),
    }
    return without_nan(data)


def is_good(data: Json) -> bool:
    """Whether it came out as it was recorded, as far as the arithmetic lets it."""
    other = data["recorded"]["fingerprint"] != data["here"]["fingerprint"]
    return not data["damaged"] and (data["identical"] or (other and data["equivalent"]))
