"""Replay finds what is not as it was recorded, and says so; what is missing it steps over."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file import row_schema
from opensuction.recording.cycle_file.frame import Heading
from opensuction.recording.cycle_file.reader import RecordingReader
from opensuction.recording.cycle_file.row_schema import (
    STARTS,
    TABLES,
    TICK_COLUMNS,
    TICKS,
    SchemaColumn,
    Table,
)
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.runtime import replay as replays
from opensuction.runtime.replay import Difference, replay
from opensuction.session.choice import CycleChoice, RigChoice
from tests.session.recorded import played

NAMES = [column.name for column in TICK_COLUMNS]
HEAD, PHASE = NAMES.index("outputs.commands.head_mm"), NAMES.index("outputs.phase")
TICKS_KEPT = 6000
"""Of the recorded run: the pre-use test and the begin of the way in."""


class Original:
    """A recording's heading and tables, to be written again with a change."""

    def __init__(self, path: Path) -> None:
        reader = RecordingReader(path)
        self.heading: Heading = reader.heading
        reader.close()
        contents = played.read(path)
        self.start = contents.tables[STARTS][:1]
        self.ticks = contents.tables[TICKS][:TICKS_KEPT]

    def write(
        self,
        path: Path,
        ticks: Table,
        start: bool = True,
        heading: Heading | None = None,
        columns: Sequence[SchemaColumn] = TICK_COLUMNS,
    ) -> RecordingReader:
        tables = {**TABLES, TICKS: columns}
        began = self.heading.began_ns
        with RecordingWriter(path, heading or self.heading, tables) as file:
            if start:
                file.add_rows(STARTS, np.array([began], np.uint64), self.start)
            times = (began + ticks[:, 0] * 1e6).astype(np.uint64)
            file.add_rows(TICKS, times, ticks)
        return RecordingReader(path)


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Original:
    choice = CycleChoice(rig=RigChoice(machine="bench"), compensation="none")
    return Original(played.play(tmp_path_factory.mktemp("original") / "a.mcap", choice).path)


Change = Callable[[Table], None]


def changed(original: Original, row: int, column: int, by: float) -> Table:
    ticks = original.ticks.copy()
    ticks[row, column] += by
    return ticks


def test_what_was_recorded_comes_out_again(original: Original, tmp_path: Path) -> None:
    found = replay(original.write(tmp_path / "a", original.ticks))
    assert (found.ticks, found.identical, found.equivalent) == (TICKS_KEPT, True, True)
    assert (found.first, found.differing_ticks, found.gaps) == (None, 0, 0)


def test_an_output_that_differs_is_found_with_both_values(
    original: Original, tmp_path: Path
) -> None:
    found = replay(original.write(tmp_path / "a", changed(original, 4321, HEAD, 0.5)))
    was = float(original.ticks[4321, HEAD])
    assert found.first == Difference(4321, "outputs.commands.head_mm", was + 0.5, was)
    assert (found.identical, found.equivalent, found.differing_ticks) == (False, False, 1)


def test_one_bit_of_the_state_is_not_identical_and_equivalent(
    original: Original, tmp_path: Path
) -> None:
    column = NAMES.index("state.core.upkeep.catheter_age_s")
    ticks = original.ticks.copy()
    ticks[70, column] = np.nextafter(ticks[70, column], np.inf)
    found = replay(original.write(tmp_path / "a", ticks))
    assert found.first is not None
    assert found.first.field == "state.core.upkeep.catheter_age_s"
    assert (found.identical, found.equivalent) == (False, True)


@pytest.mark.parametrize(("by", "equivalent"), [(0.9e-9, True), (1.2e-9, False)])
def test_what_is_equivalent_has_a_bound(
    original: Original, tmp_path: Path, by: float, equivalent: bool
) -> None:
    column = NAMES.index("outputs.commands.insertion_v")
    row = int(np.flatnonzero(original.ticks[:, column] == 0.0)[0])
    found = replay(original.write(tmp_path / "a", changed(original, row, column, by)))
    assert (found.identical, found.equivalent) == (False, equivalent)


def test_another_phase_is_never_equivalent(original: Original, tmp_path: Path) -> None:
    assert not replay(original.write(tmp_path / "a", changed(original, 9, PHASE, 1.0))).equivalent


def test_another_input_is_noticed_by_what_comes_of_it(original: Original, tmp_path: Path) -> None:
    ticks = original.ticks.copy()
    ticks[5500:, NAMES.index("inputs.readings.head_mm")] += 0.01
    found = replay(original.write(tmp_path / "a", ticks))
    assert found.first is not None
    assert found.first.tick == 5500
    assert not found.equivalent


def test_missing_rows_are_a_gap_and_it_goes_on_after_them(
    original: Original, tmp_path: Path
) -> None:
    # While the head moves, so that nothing comes of the state before the gap.
    ticks = np.delete(original.ticks, slice(5200, 5260), axis=0)
    found = replay(original.write(tmp_path / "a", ticks))
    assert (found.gaps, found.identical) == (1, True)
    assert found.ticks == TICKS_KEPT - 60 - 1


def test_a_tick_that_was_missed_by_its_controller_is_no_gap(
    original: Original, tmp_path: Path
) -> None:
    ticks = original.ticks[:400].copy()
    ticks[300:, NAMES.index("inputs.tick")] += 5.0
    found = replay(original.write(tmp_path / "a", ticks))
    assert (found.gaps, found.identical, found.ticks) == (0, True, 400)


def test_without_the_first_state_it_goes_on_from_the_first_row(
    original: Original, tmp_path: Path
) -> None:
    found = replay(original.write(tmp_path / "a", original.ticks[:200], start=False))
    assert (found.gaps, found.starts, found.ticks, found.identical) == (1, 0, 199, True)


def test_a_recording_without_a_tick_is_refused(original: Original, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no tick that could be replayed"):
        replay(original.write(tmp_path / "a", original.ticks[:0]))


def test_a_controller_with_other_fields_is_refused_by_name(
    original: Original, tmp_path: Path
) -> None:
    columns = [*TICK_COLUMNS[:-1], SchemaColumn("state.alarms.of_tomorrow", float)]
    heading = original.heading._replace(software_version="9.9.9")
    reader = original.write(tmp_path / "a", original.ticks, heading=heading, columns=columns)
    with pytest.raises(InputError, match=r"opensuction '9\.9\.9', .* with 'state\.alarms\.of_tom"):
        replay(reader)


def test_settings_that_are_none_are_refused(original: Original, tmp_path: Path) -> None:
    heading = original.heading._replace(settings="{}")
    reader = original.write(tmp_path / "a", original.ticks, heading=heading)
    with pytest.raises(InputError, match="controller settings"):
        replay(reader)


def test_rows_have_every_input_output_and_state() -> None:
    prefixes = [name.partition(".")[0] for name in NAMES]
    assert prefixes == sorted(prefixes, key=("inputs", "outputs", "state").index)
    assert row_schema.STATE_PART.stop == len(NAMES) == len(set(NAMES))
    assert {"inputs.host.conditions", "outputs.verdict.trips", "state.core.tripped"} < set(NAMES)
    assert replays.TOLERANCE == 1e-9
