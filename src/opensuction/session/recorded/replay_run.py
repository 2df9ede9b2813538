"""A recording replayed, from its file to what came of it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

from opensuction import __version__
from opensuction.controller import configuration
from opensuction.kernel import arithmetic_fingerprint
from opensuction.recording.cycle_file.frame import Heading
from opensuction.recording.cycle_file.reader import NothingRecordedError, RecordingReader
from opensuction.result.plain import FLAT, Json, measured, to_json
from opensuction.runtime import replay as replays
from opensuction.runtime.replay import Difference, Replay
from opensuction.simulation.closed_loop import DT_S


class Origin(NamedTuple):
    """Origin of a recording, as its heading has it."""

    software_version: str
    settings_hash: str
    fingerprint: str
    """Of the arithmetic that the controller ran with."""
    began_utc: str
    about: Annotated[Mapping[str, str], FLAT]
    """Whatever else the heading says, by name: machine, patient, protocol, seed, notice."""


class Replayer(NamedTuple):
    """Program that replayed, to hold against the one that recorded."""

    software_version: str
    fingerprint: str


class FirstDifference(NamedTuple):
    """The first number that came out otherwise."""

    time_s: float
    tick: int
    field: str
    recorded: float | None
    """None: no finite number."""
    replayed: float | None
    """None: no finite number."""


class ReplayResult(NamedTuple):
    """Result of the replay of a file."""

    file: str
    ticks: int
    """Compared."""
    identical: bool
    """Every bit is the same."""
    equivalent: bool
    """Every number is within the tolerance of a replay."""
    differing_ticks: int
    first_difference: FirstDifference | None
    starts: int
    """States that were set from outside, and played on from."""
    gaps: int
    """Places where ticks are missing; what they did cannot be compared."""
    whole: bool
    damaged: bool
    flaw: str | None
    """Why the file is not whole; None: it is."""
    recorded: Origin
    here: Replayer
    notes: tuple[str, ...]
    """Differences from the time of the recording, a sentence each."""

    @property
    def is_good(self) -> bool:
        """True if the replay equals the recording, as far as the arithmetic lets it."""
        other = self.recorded.fingerprint != self.here.fingerprint
        return not self.damaged and (self.identical or (other and self.equivalent))


class RefusedReplay(NamedTuple):
    """A file of several that cannot be replayed."""

    file: str
    refused: str
    """Why, in a sentence."""


class SeveralReplays(NamedTuple):
    """Result of the replay of several files, each by itself."""

    recordings: tuple[ReplayResult | RefusedReplay, ...]
    """In the order of the files."""


class PartsResult(NamedTuple):
    """Result of the replay of a recording in parts: of the first that is not good, or the last.

    Without names of files and what their headings say. Fields as those of `ReplayResult`.
    """

    identical: bool
    equivalent: bool
    differing_ticks: int
    whole: bool
    """The part is, and no part is empty."""
    damaged: bool
    first_difference: FirstDifference | None
    notes: tuple[str, ...]
    ticks: int
    """Of all parts that were played."""
    gaps: int
    """Of all parts that were played."""
    is_good: bool


def origin_of(heading: Heading) -> Origin:
    """Origin of the recording of this heading."""
    return Origin(
        software_version=heading.software_version,
        settings_hash=heading.settings_hash,
        fingerprint=heading.fingerprint,
        began_utc=heading.began_utc,
        about=heading.about,
    )


def describe(heading: Heading) -> Json:
    """The same as the rows of a table, by name."""
    return to_json(origin_of(heading))


def _notes(heading: Heading) -> tuple[str, ...]:
    """Differences of software, arithmetic and settings since the recording was made."""
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
    return tuple(notes)


def _difference(first: Difference | None) -> FirstDifference | None:
    return None if first is None else FirstDifference(first.tick * DT_S, *first)


def run(path: Path) -> ReplayResult:
    """Replay a recording. Raises InputError for what cannot be."""
    reader = RecordingReader(path)
    heading = reader.heading
    found: Replay = replays.replay(reader)
    result = ReplayResult(
        file=str(path),
        ticks=found.ticks,
        identical=found.identical,
        equivalent=found.equivalent,
        differing_ticks=found.differing_ticks,
        first_difference=_difference(found.first),
        starts=found.starts,
        gaps=found.gaps,
        whole=reader.flaw is None,
        damaged=reader.is_damaged,
        flaw=reader.flaw,
        recorded=origin_of(heading),
        here=Replayer(__version__, arithmetic_fingerprint.fingerprint()),
        notes=_notes(heading),
    )
    return measured(result)


def run_parts(paths: Sequence[Path]) -> PartsResult:
    """Replay a recording part by part, up to the first part that is not good.

    A part that holds nothing, of a recorder that died as it began, leaves the recording not whole.
    Raises InputError for what cannot be replayed, and where no part holds anything.
    """
    played: list[ReplayResult] = []
    empty: list[NothingRecordedError] = []
    for path in paths:
        try:
            played.append(run(path))
        except NothingRecordedError as refused:
            empty.append(refused)
            continue
        if not played[-1].is_good:
            break
    if not played:
        raise empty[0]
    last = played[-1]
    return PartsResult(
        identical=last.identical,
        equivalent=last.equivalent,
        differing_ticks=last.differing_ticks,
        whole=last.whole and not empty,
        damaged=last.damaged,
        first_difference=last.first_difference,
        notes=last.notes,
        ticks=sum(one.ticks for one in played),
        gaps=sum(one.gaps for one in played),
        is_good=last.is_good,
    )
