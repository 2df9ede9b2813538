"""The report of a recording: what the machine knew, and nothing that only the twin knows."""

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from opensuction.kernel.errors import InputError
from opensuction.recording.cycle_file.reader import RecordingReader, Rows
from opensuction.recording.cycle_file.row_schema import TABLES, TICK_COLUMNS, TICKS
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.report import series
from opensuction.result.plain import to_json
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.recorded import recorded_cycle, report_run
from opensuction.session.recorded.report_run import Report
from tests.report.page_data import payload
from tests.session.recorded import played
from tests.session.recorded.played import Played

PHASE = [column.name for column in TICK_COLUMNS].index("outputs.phase")
AFTERMATH_S = 20.0
"""For which the patient is followed: a monitor shows saturation some seconds late."""


@pytest.fixture(scope="module")
def cycle(tmp_path_factory: pytest.TempPathFactory) -> Played:
    """A cycle with a patient, whose twin wrote the truth beside it."""
    choice = CycleChoice(rig=RigChoice(patient="neonate"), compensation="none")
    return played.play(tmp_path_factory.mktemp("cycle") / "a.mcap", choice, AFTERMATH_S)


@pytest.fixture(scope="module")
def real(cycle: Played, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return played.without_truth(cycle.path, tmp_path_factory.mktemp("real") / "b.mcap")


@pytest.fixture(scope="module")
def report(real: Path) -> Report:
    return report_run.run([real])


@pytest.fixture(scope="module")
def summary(report: Report) -> dict[str, Any]:
    return to_json(report.result)


def test_what_only_the_twin_knows_is_not_known(summary: dict[str, Any]) -> None:
    assert summary["basis"] == "recorded"
    assert summary["has_truth"] is False
    assert summary["secretion"] == {"removed_ml": None, "removed_percent": None}
    assert summary["harm"] is None
    assert summary["carina_force_peak_n"] is None
    assert summary["lung_volume_loss_ml"] is None
    assert summary["anatomy"]["carina_mm"] is None
    assert summary["vacuum"]["tip_peak_mmhg"] is None


def test_the_estimate_is_near_the_truth_and_below_what_is_possible(
    cycle: Played, summary: dict[str, Any]
) -> None:
    columns = cycle.ran.columns
    # Without compensation the tip stops short by half the gap: the estimate is of the same tip.
    truth_mm = float(columns["truth.tip_mm"].max())
    assert summary["tip"]["deepest_mm"] == pytest.approx(truth_mm, abs=2.0)
    assert summary["tip"]["deepest_possible_mm"] >= truth_mm
    assert summary["tip"]["inside_at_end"] is False


def test_times_and_outcome_are_those_of_the_cycle(cycle: Played, summary: dict[str, Any]) -> None:
    columns = cycle.ran.columns
    assert summary["outcome"] == "completed"
    inside = columns["truth.tip_mm"] > cycle.prepared.rig.site.boundary_mm
    # The machine counts for as long as the tip may be inside: never less than it is.
    assert summary["timing"]["in_airway_s"] >= float(np.count_nonzero(inside)) * 1e-3 - 0.1
    assert summary["timing"]["in_airway_s"] < float(np.count_nonzero(inside)) * 1e-3 + 3.0
    assert [phase["name"] for phase in summary["phases"]][:3] == [
        "checking",
        "preloading",
        "inserting",
    ]
    lowest = float(columns["truth.spo2_percent"].min())
    assert summary["spo2_nadir_percent"] == pytest.approx(lowest, abs=1.0)


def test_the_page_says_whose_word_it_is(report: Report) -> None:
    html = report.html
    text = html.split("<script")[0]
    assert "By the truth of the twin" not in text
    assert "by the controller&#39;s estimate" in text
    assert "Not known from the recording" in text
    assert "not simulated" not in text
    series = payload(html)["series"]
    assert "estimated" in series
    assert not {"tip", "removed", "contact", "tip_vacuum", "error"} & set(series)
    assert set(payload(html)["patient"]) == {"time", "airway_pressure", "spo2", "heart_rate"}


def test_what_the_twin_wrote_beside_it_is_shown(cycle: Played) -> None:
    report = report_run.run([cycle.path])
    assert to_json(report.result)["has_truth"] is True
    removed = cycle.ran.columns["truth.secretion_removed_ml"]
    assert report.result.secretion.removed_ml == pytest.approx(
        float(removed[-1] - removed[0]), abs=0.01
    )
    assert {"tip", "estimated", "removed"} <= set(payload(report.html)["series"])


def test_every_reading_that_is_drawn_is_one_of_a_recording(real: Path) -> None:
    every = (*series.MACHINE, *series.PATIENT)
    drawn = {entry.measured for entry in every if entry.measured} | {"estimate.tip_mm"}
    assert drawn <= set(recorded_cycle.read([real]).columns)


def test_equal_recordings_give_equal_pages(real: Path, report: Report) -> None:
    assert report_run.run([real]) == report


@pytest.mark.sweep
def test_missing_ticks_are_told_and_times_stay(cycle: Played, tmp_path: Path) -> None:
    path = played.without_truth(cycle.path, tmp_path / "c.mcap", slice(5000, 5400))
    found = recorded_cycle.read([path])
    assert found.missing == 400
    whole = recorded_cycle.read([cycle.path])
    assert found.columns["time_s"][-1] == whole.columns["time_s"][-1]
    report = report_run.run([path])
    assert "400 ticks are missing" in report.html


@pytest.mark.sweep
def test_parts_of_one_recording_are_one_report(real: Path, tmp_path: Path) -> None:
    reader = RecordingReader(real)
    rows = [one for one in reader.contents() if isinstance(one, Rows) and one.topic == TICKS]
    times = np.concatenate([one.times_ns for one in rows])
    table = np.concatenate([one.table for one in rows])
    parts = [tmp_path / "d.mcap", tmp_path / "d-2.mcap"]
    for path, some in zip(parts, (slice(0, 9000), slice(8000, None)), strict=True):
        with RecordingWriter(path, reader.heading, TABLES) as file:
            file.add_rows(TICKS, times[some], table[some])
    joined, whole = recorded_cycle.read(parts), recorded_cycle.read([real])
    for name, values in whole.columns.items():
        assert np.array_equal(joined.columns[name], values, equal_nan=True), name


@pytest.mark.parametrize("held", ["no byte", "a heading"])
def test_a_part_of_a_recorder_that_died_as_it_began_keeps_no_other_from_its_report(
    real: Path, tmp_path: Path, held: str
) -> None:
    first, second = tmp_path / "h.mcap", tmp_path / "h-2.mcap"
    second.write_bytes(real.read_bytes())
    heading = played.without_rows(real)
    first.write_bytes(heading if held == "a heading" else b"")
    report = report_run.run([first, second])
    assert report.result.outcome == report_run.run([real]).result.outcome
    assert str(first) in (report.flaw or "")
    assert report.is_damaged is False
    with pytest.raises(InputError, match=r"h\.mcap: "):
        report_run.run([first])
    # What was written over is told of, whatever lies beside it.
    first.write_bytes(heading[:-200] + bytes(200))
    with pytest.raises(InputError, match="damaged"):
        report_run.run([first, second])


def test_a_recording_that_stops_inside_is_not_completed(real: Path, tmp_path: Path) -> None:
    reader = RecordingReader(real)
    rows = [one for one in reader.contents() if isinstance(one, Rows) and one.topic == TICKS]
    table = np.concatenate([one.table for one in rows])
    times = np.concatenate([one.times_ns for one in rows])
    until = int(np.argmax(table[:, PHASE] == 6.0)) + 5  # suctioning
    path = tmp_path / "e.mcap"
    with RecordingWriter(path, reader.heading, TABLES) as file:
        file.add_rows(TICKS, times[:until], table[:until])
    report = report_run.run([path])
    assert report.result.outcome == "interrupted"
    assert "CATHETER STILL IN THE AIRWAY AS THE RECORDING ENDS" in report.html
    assert '<p class="outcome bad"' in report.html


def test_a_recording_without_a_cycle_is_refused(real: Path, tmp_path: Path) -> None:
    reader = RecordingReader(real)
    rows = [one for one in reader.contents() if isinstance(one, Rows) and one.topic == TICKS]
    table, times = rows[0].table.copy(), rows[0].times_ns
    table[:, PHASE] = 11.0
    path = tmp_path / "f.mcap"
    with RecordingWriter(path, reader.heading, TABLES) as file:
        file.add_rows(TICKS, times, table)
    with pytest.raises(InputError, match=r"there is no cycle in it \(the machine was teaching\)"):
        report_run.run([path])


@pytest.mark.sweep
def test_damaged_and_cut_files_end_in_a_page_or_one_line(real: Path, tmp_path: Path) -> None:
    drawn, whole = random.Random(1), real.read_bytes()
    path = tmp_path / "g.mcap"
    pages = 0
    for _ in range(12):
        data = bytearray(whole[: drawn.randrange(1, len(whole))])
        if drawn.random() < 0.5:
            data[drawn.randrange(len(data))] ^= 0xFF
        path.write_bytes(data)
        try:
            report = report_run.run([path])
        except InputError as refused:
            assert "\n" not in str(refused)
        else:
            pages += 1
            assert report.flaw is not None
            assert "The file is not whole" in report.html
    assert pages > 0


@pytest.mark.sweep
def test_text_from_a_recording_is_never_markup(real: Path, report: Report, tmp_path: Path) -> None:
    attack = "</script><script>alert(1)</script>"
    reader = RecordingReader(real)
    about = {**reader.heading.about, "patient": attack, "machine": attack, attack: attack}
    rows = [one for one in reader.contents() if isinstance(one, Rows) and one.topic == TICKS]
    path = tmp_path / "h.mcap"
    with RecordingWriter(path, reader.heading._replace(about=about), TABLES) as file:
        for one in rows:
            file.add_rows(TICKS, one.times_ns, one.table)
    html = report_run.run([path]).html
    assert attack not in html
    assert html.count("<script") == report.html.count("<script")
