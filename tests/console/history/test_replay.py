"""Recordings that are played again over the interface."""

from pathlib import Path

import numpy as np
import pytest

from opensuction.recording.cycle_file.reader import RecordingReader, Rows
from opensuction.recording.cycle_file.row_schema import TABLES, TICK_COLUMNS, TICKS
from opensuction.recording.cycle_file.writer import RecordingWriter
from tests.console.history.past import RECORDING, join, remember
from tests.console.served import Served
from tests.session.recorded import played

V1 = "/api/v1"


def test_a_replay_is_begun_once_and_its_verdict_kept(console: Served, recording: Path) -> None:
    past = remember(console, recording)
    client, path = console.client("observer"), f"{V1}/cycles/{past.completed}/replay"
    assert client.get(path).json() == {"state": "none", "verdict": None, "failure": None}
    answer = client.post(path)
    assert (answer.status_code, answer.json()["state"]) == (202, "running")
    join("_replay")
    found = client.get(path).json()
    assert found["state"] == "done"
    assert found["verdict"]["identical"] is True
    assert found["verdict"]["is_good"] is True
    assert found["verdict"]["first_difference"] is None
    assert client.post(path).json() == found, "nothing is played twice"
    refused = console.client("observer")
    refused.headers.pop("X-CSRF-Token")
    assert refused.post(path).status_code == 403


@pytest.mark.usefixtures("here")
def test_a_first_part_without_a_row_keeps_no_recording_from_its_replay(
    console: Served, recording: Path
) -> None:
    past = remember(console, recording)
    first = console.site.recordings / RECORDING
    first.rename(first.with_name(f"{first.stem}-2.mcap"))
    first.write_bytes(played.without_rows(recording))
    client, path = console.client("observer"), f"{V1}/cycles/{past.completed}/replay"
    assert client.post(path).status_code == 202
    join("_replay")
    verdict = client.get(path).json()["verdict"]
    assert (verdict["is_good"], verdict["identical"], verdict["whole"]) == (True, True, False)
    assert verdict["ticks"] > 0


@pytest.mark.usefixtures("here")
def test_a_replay_that_differs_says_where(console: Served, recording: Path, tmp_path: Path) -> None:
    reader = RecordingReader(recording)
    rows = [one for one in reader.contents() if isinstance(one, Rows)]
    column = [one.name for one in TICK_COLUMNS].index("outputs.commands.head_mm")
    changed = tmp_path / "changed.mcap"
    with RecordingWriter(changed, reader.heading, TABLES) as file:
        for topic in TABLES:
            table = np.concatenate([one.table for one in rows if one.topic == topic])
            times = np.concatenate([one.times_ns for one in rows if one.topic == topic])
            if topic == TICKS:
                table[100, column] += 0.5
            file.add_rows(topic, times, table)
    past = remember(console, changed)
    client, path = console.client("observer"), f"{V1}/cycles/{past.completed}/replay"
    client.post(path)
    join("_replay")
    found = client.get(path).json()
    first = found["verdict"]["first_difference"]
    assert (first["tick"], first["field"]) == (100, "outputs.commands.head_mm")
    assert first["recorded"] == pytest.approx(first["replayed"] + 0.5)
    assert found["verdict"]["is_good"] is False
