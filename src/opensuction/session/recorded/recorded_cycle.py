"""The cycle in a recording, as columns: what its controller was given, decided and estimated.

The names are those of a simulated run's trace, so that whatever reads one reads the other. What
only the twin knows is there only where the twin wrote it beside the ticks.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller import configuration
from opensuction.controller.record import Settings
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.recording.cycle_file.frame import Heading
from opensuction.recording.cycle_file.reader import NothingRecordedError, RecordingReader, Rows
from opensuction.recording.cycle_file.row_schema import TICKS, Table
from opensuction.session.recorded.cycle_recording import TWIN
from opensuction.simulation.trace import Columns

MOST_S = 900.0
"""Of a cycle: whatever comes later is left out, for memory's sake; no cycle lasts longer."""
TICK = "inputs.tick"
STEP = "inputs.dt_s"
WATCH = "state.core.governor.watch"
MEASURED = {
    "readings.head_mm": "head_valid",
    "readings.cam_rad": "cam_valid",
    "readings.line_vacuum_mmhg": "vacuum_valid",
    "readings.monitor.spo2_percent": "monitor.spo2_valid",
    "readings.monitor.heart_rate_per_min": "monitor.heart_rate_valid",
    "readings.monitor.airway_pressure_cmh2o": "monitor.airway_pressure_valid",
}
"""Readings with what says of each whether it is one."""
OUTPUTS = (
    "phase",
    "cause",
    "check_item",
    "check_failed",
    "counters.preoxygenation",
    "demand.reference_mm",
    "demand.valve_open",
    "verdict.trips",
    "verdict.deepest_mm",
    *(
        f"signals.{name}"
        for name in (
            "priority",
            "audible",
            "first",
            "present",
            "latched",
            "acknowledged",
            "escalated",
            "pause_left_s",
            "reminder",
        )
    ),
)
STATES = {
    f"{WATCH}.tip.foremost_mm": "tip.foremost_mm",
    f"{WATCH}.tip.rearmost_mm": "tip.rearmost_mm",
    f"{WATCH}.durations.sucking_s": "durations.sucking_s",
    f"{WATCH}.durations.inside_s": "durations.inside_s",
    f"{WATCH}.durations.contact_s": "durations.contact_s",
    "state.core.procedure.touched_mm": "procedure.touched_mm",
}
"""Of the controller's state, with their names here."""
TRUTH = "truth."


class RecordedCycle(NamedTuple):
    """A cycle as it was recorded."""

    heading: Heading
    settings: Settings
    columns: Columns
    """From the tick on in which the pre-use test begins; ``time_s`` counts from there."""
    dt_s: float
    missing: int
    """Ticks that are not in the recording although those around them are."""
    flaw: str | None
    """What is wrong with the file, in one line."""
    is_damaged: bool
    """That is more than an end that is missing."""
    is_cut: bool
    """It goes on for longer than what was read."""

    @property
    def has_truth(self) -> bool:
        """True if the recording holds the twin's truth, too."""
        return any(name.startswith(TRUTH) for name in self.columns)


def _wanted() -> dict[str, str]:
    """Columns of a tick that are kept, with the names they get."""
    readings = ["readings.contact_closed", *MEASURED]
    readings += [f"readings.{valid}" for valid in MEASURED.values()]
    return {
        TICK: TICK,
        STEP: STEP,
        **{f"inputs.{name}": name for name in readings},
        **{f"outputs.{name}": name for name in OUTPUTS},
        **STATES,
    }


class _Topic:
    """Some columns of a topic, gathered."""

    def __init__(self, names: list[str], wanted: dict[str, str]) -> None:
        self._index = [names.index(name) for name in wanted]
        self._names = list(wanted.values())
        self._tables: list[Table] = []
        self._times: list[npt.NDArray[np.uint64]] = []
        self.rows = 0

    def add(self, one: Rows) -> None:
        self._tables.append(one.table[:, self._index])
        self._times.append(one.times_ns)
        self.rows += len(one.table)

    def columns(self) -> tuple[npt.NDArray[np.int64], Columns]:
        """Times in ns, and the columns."""
        table = np.concatenate(self._tables)
        times = np.concatenate(self._times).astype(np.int64)
        return times, {
            name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(self._names)
        }


class _Gathered(NamedTuple):
    heading: Heading
    times_ns: npt.NDArray[np.int64]
    columns: Columns
    truth: tuple[npt.NDArray[np.int64], Columns] | None
    flaw: str | None
    is_damaged: bool


def _gather(path: Path) -> _Gathered:
    """Read the columns of one file that a report needs. Raises InputError."""
    reader = RecordingReader(path)
    try:
        names = {topic: [one.name for one in table] for topic, table in reader.tables.items()}
        topics = {TICKS: _Topic(names.get(TICKS, []), _wanted())}
        if TWIN in names:
            kept = {name: name for name in names[TWIN] if name.startswith(TRUTH)}
            topics[TWIN] = _Topic(names[TWIN], kept)
        most = round(2.0 * MOST_S / 1e-3)
        for one in reader.contents():
            if isinstance(one, Rows) and one.topic in topics and topics[TICKS].rows < most:
                topics[one.topic].add(one)
    except ValueError:
        raise InputError(f"{path}: its ticks lack a column that a report needs") from None
    finally:
        reader.close()
    if not topics[TICKS].rows:
        reader.refuse_empty("there is no tick in it: nothing to report")
    twin = topics.get(TWIN)
    truth = twin.columns() if twin is not None and twin.rows else None
    return _Gathered(
        reader.heading, *topics[TICKS].columns(), truth, reader.flaw, reader.is_damaged
    )


def _gather_parts(paths: list[Path]) -> tuple[list[_Gathered], list[str]]:
    """Of the parts of a recording those that hold ticks, and what is wrong with the others.

    A recorder that died as it began has left a part without any. Raises InputError for other parts
    that cannot be read, and where no part holds a tick.
    """
    parts, flaws = [], []
    for path in paths:
        try:
            parts.append(_gather(path))
        except NothingRecordedError as refused:
            flaws.append(str(refused))
    if not parts:
        raise NothingRecordedError(flaws[0])
    return parts, flaws


def _join(parts: list[_Gathered], flaws: list[str]) -> _Gathered:
    """Parts of one recording, which recorders that died have left, in the order of their ticks.

    flaws: what is wrong with parts that are not among them.
    """
    first = parts[0]
    if len(parts) == 1 and not flaws:
        return first
    same = [part for part in parts if part.heading.settings_hash == first.heading.settings_hash]
    times = np.concatenate([part.times_ns for part in same])
    columns = {
        name: np.concatenate([part.columns[name] for part in same]) for name in first.columns
    }
    _, kept = np.unique(columns[TICK], return_index=True)
    flaws = [*flaws, *(part.flaw for part in same if part.flaw is not None)]
    return _Gathered(
        first.heading,
        times[kept],
        {name: values[kept] for name, values in columns.items()},
        None,
        flaws[0] if flaws else None,
        any(part.is_damaged for part in same),
    )


def _begin(where: str, phase: npt.NDArray[np.float64]) -> int:
    """Row in which the last pre-use test of a recording begins. Raises InputError: there is none.

    A recording begins with the second before, in which a cycle before this one may end.
    """
    testing = phase == Phase.CHECKING
    starts = np.flatnonzero(testing & ~np.concatenate(([False], testing[:-1])))
    if not starts.size:
        found = dict.fromkeys(name_of(Phase(int(one))) for one in phase)
        raise InputError(
            f"{where}: there is no cycle in it (the machine was {', '.join(found)}): a report is "
            "of a cycle"
        )
    return int(starts[-1])


def _measure(columns: Columns) -> None:
    """Readings that were none become nan."""
    for name, valid in MEASURED.items():
        flags = columns.pop(f"readings.{valid}")
        columns[name] = np.where(flags > 0.0, columns[name], np.nan)


def _estimate(columns: Columns, settings: Settings) -> None:
    """Add the controller's estimates: there is no sensor at the tip, and none at the valve."""
    bounds, valve = settings.limits.tip, settings.valve_motion
    middle_mm = 0.5 * (columns["tip.foremost_mm"] + columns["tip.rearmost_mm"])
    columns["estimate.tip_mm"] = bounds.gain * middle_mm + bounds.offset_mm
    columns["measured.valve_open_ratio"] = np.clip(
        columns["readings.cam_rad"] / valve.open_rad, 0.0, 1.0
    )


def read(paths: list[Path]) -> RecordedCycle:
    """The cycle in a recording.

    paths: its file, or the parts of it. Raises InputError for what is no recording, holds no cycle,
    or cannot be read so far.
    """
    found = _join(*_gather_parts(paths))
    settings = configuration.from_json(found.heading.settings).settings
    begin = _begin(found.flaw or str(paths[0]), found.columns["phase"])
    tick = found.columns[TICK][begin:]
    dt_s = float(found.columns[STEP][begin])
    within = (tick - tick[0]) * dt_s < MOST_S
    end = begin + int(np.count_nonzero(within))
    columns = {name: values[begin:end] for name, values in found.columns.items()}
    tick = columns.pop(TICK)
    columns.pop(STEP)
    columns["time_s"] = (tick - tick[0]) * dt_s
    _measure(columns)
    _estimate(columns, settings)
    if found.truth is not None:
        at = np.searchsorted(found.truth[0], found.times_ns[begin:end], side="right") - 1
        columns |= {name: values[np.maximum(at, 0)] for name, values in found.truth[1].items()}
    return RecordedCycle(
        heading=found.heading,
        settings=settings,
        columns=columns,
        dt_s=dt_s,
        missing=int(tick[-1] - tick[0]) + 1 - tick.size,
        flaw=found.flaw,
        is_damaged=found.is_damaged,
        is_cut=end < begin + within.size,
    )
