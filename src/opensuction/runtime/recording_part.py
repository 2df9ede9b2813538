"""Names of a recording and of its parts, and the last tick that they hold.

A recording is named by its run and by the tick in which the machine left its rest. A recorder that
goes on with one after another's death makes another part of it, a file of its own.
"""

from contextlib import closing, suppress
from pathlib import Path

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file.reader import RecordingReader, Rows
from opensuction.recording.cycle_file.row_schema import TICKS

PARTS = 1000
"""Files of one recording, at most."""
NEVER = -1
SUFFIX = ".mcap"


def name_of(run: str, left_rest: float) -> str:
    """The recording of what goes on since a tick in which the machine left its rest."""
    return f"{run}-{int(left_rest):09d}{SUFFIX}"


def is_after(recording: str | None, run: str, tick: float) -> bool:
    """True where a recording is of a cycle of this run that began after a tick."""
    head, _, number = (recording or "").removesuffix(SUFFIX).rpartition("-")
    return head == run and number.isdecimal() and int(number) > tick


def file_of(recording: str, part: int) -> str:
    """File of a part of a recording, from 1 on: the first has its name."""
    return recording if part == 1 else f"{recording.removesuffix(SUFFIX)}-{part}{SUFFIX}"


def last_tick(folder: Path, recording: str) -> float:
    """Last tick that the parts of a recording hold, whole or cut off; `NEVER` of none."""
    found = folder.glob(f"{recording.removesuffix(SUFFIX)}*{SUFFIX}")
    return max(map(_last_tick, found), default=NEVER)


def _last_tick(path: Path) -> float:
    """Of a file; `NEVER` where it holds none."""
    last = float(NEVER)
    with suppress(InputError), closing(RecordingReader(path)) as reader:
        for content in reader.contents():
            if isinstance(content, Rows) and content.topic == TICKS and len(content.table):
                last = float(content.table[-1, 0])
    return last
