"""Notes of a replay on differences from the time of the recording, and its verdict."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from opensuction.kernel.arithmetic_fingerprint import fingerprint
from opensuction.recording.cycle_file.reader import NothingRecordedError, RecordingReader, Rows
from opensuction.recording.cycle_file.row_schema import STARTS, TABLES, TICK_COLUMNS, TICKS
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.result.plain import to_json
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.recorded import replay_run
from opensuction.session.recorded.replay_run import ReplayResult
from tests.session.recorded import played

COMMANDED = [column.name for column in TICK_COLUMNS].index("outputs.commands.head_mm")


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    choice = CycleChoice(rig=RigChoice(machine="bench"), compensation="none")
    return played.play(tmp_path_factory.mktemp("original") / "a.mcap", choice).path


def rewritten(
    original: Path, path: Path, off_mm: float = 0.0, heading: dict[str, Any] | None = None
) -> ReplayResult:
    """The replay of the first rows, a command off by so much and with another heading."""
    reader = RecordingReader(original)
    parts = [one for one in reader.contents() if isinstance(one, Rows)][:12]
    with RecordingWriter(path, reader.heading._replace(**heading or {}), TABLES) as file:
        for topic in (STARTS, TICKS):
            rows = [one for one in parts if one.topic == topic]
            table = np.concatenate([one.table for one in rows])
            if topic == TICKS:
                table[100, COMMANDED] += off_mm
            file.add_rows(topic, np.concatenate([one.times_ns for one in rows]), table)
    return replay_run.run(path)


def test_nothing_is_noted_of_what_is_as_it_was(original: Path, tmp_path: Path) -> None:
    found = rewritten(original, tmp_path / "a")
    assert (found.identical, found.notes) == (True, ())
    assert found.is_good


def test_another_version_arithmetic_and_hash_are_each_noted(original: Path, tmp_path: Path) -> None:
    other = {"software_version": "9.9", "fingerprint": "f" * 16, "settings_hash": "a" * 64}
    version, arithmetic, settings = rewritten(original, tmp_path / "a", heading=other).notes
    assert "recorded by opensuction 9.9" in version
    assert f"({'f' * 16}, here {fingerprint()})" in arithmetic
    assert "aaaaaaaaaaaaaaaa as recorded" in settings


@pytest.mark.parametrize(
    ("off_mm", "other_arithmetic", "is_good"),
    [(1e-12, False, False), (1e-12, True, True), (1e-3, False, False), (1e-3, True, False)],
)
def test_what_is_equivalent_passes_only_under_another_arithmetic(
    original: Path, tmp_path: Path, off_mm: float, other_arithmetic: bool, is_good: bool
) -> None:
    heading = {"fingerprint": "0" * 16} if other_arithmetic else {}
    found = rewritten(original, tmp_path / "a", off_mm, heading)
    assert not found.identical
    assert found.equivalent == (off_mm < 1e-9)
    assert found.first_difference is not None
    assert found.first_difference.time_s == 0.1
    assert found.is_good is is_good


def test_a_number_that_is_not_finite_is_null_in_the_json(original: Path, tmp_path: Path) -> None:
    data = to_json(rewritten(original, tmp_path / "a", np.nan))
    assert data["first_difference"] == {
        "time_s": 0.1,
        "tick": 100,
        "field": "outputs.commands.head_mm",
        "recorded": None,
        "replayed": data["first_difference"]["replayed"],
    }
    assert data["first_difference"]["replayed"] is not None


def test_what_the_heading_says_stands_beside_who_recorded_it(
    original: Path, tmp_path: Path
) -> None:
    about = {"patient": "neonate", "seed": "7"}
    data = to_json(rewritten(original, tmp_path / "a", heading={"about": about}))
    assert list(data["recorded"]) == [
        *("software_version", "settings_hash", "fingerprint", "began_utc", "patient", "seed")
    ]
    assert data["recorded"]["seed"] == "7"
    assert data["here"] == {key: data["recorded"][key] for key in data["here"]}


@pytest.mark.parametrize("kind", ["empty first", "differing first", "differing last"])
def test_parts_are_one_recording_up_to_the_first_that_differs(
    original: Path, tmp_path: Path, kind: str
) -> None:
    whole, other, empty = tmp_path / "whole", tmp_path / "other", tmp_path / "empty"
    ticks = rewritten(original, whole).ticks
    rewritten(original, other, 1e-3)
    empty.touch()
    parts = {
        "empty first": ([empty, whole], True, False, ticks),
        "differing first": ([other, whole], False, True, ticks),
        "differing last": ([whole, other, whole], False, True, 2 * ticks),
    }
    paths, is_good, is_whole, played = parts[kind]
    found = replay_run.run_parts(paths)
    assert (found.is_good, found.whole, found.ticks) == (is_good, is_whole, played)
    assert (found.first_difference is None) is is_good


def test_parts_that_all_hold_nothing_are_refused(tmp_path: Path) -> None:
    empty = tmp_path / "empty.mcap"
    empty.touch()
    with pytest.raises(NothingRecordedError, match="is empty"):
        replay_run.run_parts([empty, empty])
