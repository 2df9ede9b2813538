"""Notes of a replay on differences from the time of the recording, and its verdict."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from opensuction.kernel.arithmetic_fingerprint import fingerprint
from opensuction.recording.cycle_file.chunk_content import Rows
from opensuction.recording.cycle_file.reader import RecordingReader
from opensuction.recording.cycle_file.tick_table import STARTS, TABLES, TICK_COLUMNS, TICKS
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.recorded import replay_run
from tests.session.recorded import played

COMMANDED = [column.name for column in TICK_COLUMNS].index("outputs.commands.head_mm")


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    choice = CycleChoice(rig=RigChoice(machine="bench"), compensation="none")
    return played.play(tmp_path_factory.mktemp("original") / "a.mcap", choice).path


def rewritten(
    original: Path, path: Path, off_mm: float = 0.0, heading: dict[str, Any] | None = None
) -> dict[str, Any]:
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
    data = rewritten(original, tmp_path / "a")
    assert (data["identical"], data["notes"]) == (True, [])
    assert replay_run.is_good(data)


def test_another_version_arithmetic_and_hash_are_each_noted(original: Path, tmp_path: Path) -> None:
    other = {"software_version": "9.9", "fingerprint": "f" * 16, "settings_hash": "a" * 64}
    version, arithmetic, settings = rewritten(original, tmp_path / "a", heading=other)["notes"]
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
    data = rewritten(original, tmp_path / "a", off_mm, heading)
    assert not data["identical"]
    assert data["equivalent"] == (off_mm < 1e-9)
    assert data["first_difference"]["time_s"] == 0.1
    assert replay_run.is_good(data) is is_good
