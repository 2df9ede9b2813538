"""The ``identify`` command as its users meet it, and what it refuses as ``compare`` does."""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from opensuction.hysteresis.modified_dahl import PUBLISHED, simulate
from opensuction.session.identification import identification_run
from tests.cli.command import opensuction, unrecorded
from tests.cli.test_cycle import assert_refused

MEASURED = Path(__file__).parents[2].parent / "shared" / "data" / "mrd"
"""Real recordings, beside the project where there are any."""
EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "bench-recording.csv"

KEYS = {
    "model",
    "method",
    "parameters",
    "rmse",
    "rmse_percent_of_range",
    "holdout_rmse_percent_of_range",
    "well_posed",
    "warnings",
    "samples",
    "fit_seconds",
    "inverse",
}
"""docs/reference/results.md; ``seconds`` is of the whole run."""
COLUMNS = ("--input", "head_mm", "--output", "tip_mm")


def motion() -> tuple[np.ndarray[Any, np.dtype[np.float64]], ...]:
    """Time, head and tip of the paper's published model, without noise."""
    time_s = 0.05 * np.arange(800.0)
    head = 50.0 - 50.0 * np.cos(2.0 * np.pi * time_s / 20.0)
    return time_s, head, simulate(PUBLISHED, head, 0.0)


def recording(folder: Path, name: str = "bench.csv") -> Path:
    file = folder / name
    rows = [f"{t!r},{x!r},{y!r}" for t, x, y in np.column_stack(motion()).tolist()]
    file.write_text("\n".join(["time_s,head_mm,tip_mm", *rows]) + "\n")
    return file


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path, str]:
    folder = tmp_path_factory.mktemp("identify")
    recording(folder)
    arguments = ("identify", "bench.csv", *COLUMNS, "--time", "time_s", "--holdout", "0.25")
    ran = opensuction(*arguments, "--json", "--out", "found", cwd=folder)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout), folder / "found", ran.stderr


def test_the_model_that_made_the_recording_is_found(
    finished: tuple[dict[str, Any], Path, str],
) -> None:
    data, _, progress = finished
    assert data.keys() >= KEYS | {"seconds"}
    values = {name: entry["value"] for name, entry in data["parameters"].items()}
    assert values["slope"] == pytest.approx(PUBLISHED.slope, rel=1e-6)
    assert values["velocity_gain"] == pytest.approx(PUBLISHED.velocity_gain, rel=1e-6)
    assert values["decay"] == pytest.approx(PUBLISHED.decay_per_mm, rel=1e-6)
    assert data["parameters"]["decay"]["unit"] == "1/mm"
    assert data["holdout_rmse_percent_of_range"] < 1e-6
    assert (data["samples"], data["fitted_samples"]) == (800, 600)
    assert data["well_posed"] is False  # c is not above 2 beta
    assert 0.0 < data["fit_seconds"] < data["seconds"]
    assert "bench.csv" in progress


def test_files_hold_the_same_figures_and_say_where_they_are_from(
    finished: tuple[dict[str, Any], Path, str],
) -> None:
    data, folder, _ = finished
    names = sorted(file.name for file in folder.iterdir())
    assert names == ["identification.json", "identification.toml", "report.html"]
    assert json.loads((folder / "identification.json").read_text()) == data
    sha256 = hashlib.sha256((folder.parent / "bench.csv").read_bytes()).hexdigest()
    assert data["recording"]["sha256"] == sha256
    assert sha256 in (folder / "identification.toml").read_text()
    assert sha256 in (folder / "report.html").read_text()


def test_cycle_takes_the_parameter_file(tmp_path: Path) -> None:
    ran = opensuction(
        "identify", str(EXAMPLE), *COLUMNS, "--time", "time_s", "--out", "bench", cwd=tmp_path
    )
    assert ran.returncode == 0, ran.stderr
    ran = unrecorded(
        *("cycle", "--protocol", "paper", "--compensation", "bench/identification.toml"),
        *("--json", "--out", "run"),
        cwd=tmp_path,
    )
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert "Identifying" not in ran.stderr
    assert data["outcome"] == "completed"
    # Uncompensated it is 16 mm, and 1 mm by a PD alone; by the motor's nominal voltage .6.
    assert data["tip"]["rmse_mm"] < 0.75
    assert data["identification"]["file"] == "bench/identification.toml"
    assert data["identification"]["recording"] == "bench-recording.csv"
    assert any("no servo feedforward" in warning for warning in data["warnings"])


def test_cycle_refuses_a_parameter_file_that_is_not_of_its_machine(tmp_path: Path) -> None:
    opensuction("identify", str(EXAMPLE), *COLUMNS, "--out", "bench", cwd=tmp_path)
    file = tmp_path / "bench" / "identification.toml"
    arguments = ("cycle", "--compensation", "bench/identification.toml", "--json", "--out", "run")
    original = file.read_text()
    for before, after, words in (
        ("format_version = 3", "format_version = 7", "format version 7"),
        ('_mm"\nunit = "mm"', '_mm"\nunit = "inch"', "inch"),
        ("[parameters.slope]", "[parameters.slop]", "did you mean 'slope'"),
    ):
        assert before in original
        file.write_text(original.replace(before, after, 1))
        assert_refused(opensuction(*arguments, cwd=tmp_path), words, tmp_path, left=1)


def test_parquet_and_csv_give_the_same(
    finished: tuple[dict[str, Any], Path, str], tmp_path: Path
) -> None:
    time_s, head, tip = motion()
    pq.write_table(
        pa.table({"time_s": time_s, "head_mm": head, "tip_mm": tip}), tmp_path / "bench.parquet"
    )
    arguments = ("identify", "bench.parquet", *COLUMNS, "--time", "time_s", "--holdout", "0.25")
    ran = opensuction(*arguments, "--json", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout)["parameters"] == finished[0]["parameters"]


def test_default_folder_is_under_runs_and_named_by_the_command(tmp_path: Path) -> None:
    recording(tmp_path)
    ran = opensuction("identify", "bench.csv", *COLUMNS, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    (run,) = (tmp_path / "runs").iterdir()
    assert run.name.endswith("Z-identify")
    words = " ".join(ran.stdout.split())
    for expected in ("velocity_gain", "report.html", "not a medical device"):
        assert expected in words
    assert ran.stderr.startswith("Identifying modified-dahl on bench.csv: head_mm to tip_mm\n")


def test_units_are_those_of_the_columns_or_given(tmp_path: Path) -> None:
    file = recording(tmp_path)
    file.write_text(file.read_text().replace("head_mm", "x").replace("tip_mm", "Tip [deg]"))
    arguments = ("identify", "bench.csv", "--input", "x", "--output", "Tip [deg]", "--json")
    ran = opensuction(*arguments, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout)["parameters"]["slope"]["unit"] == "deg/input"
    ran = opensuction(*arguments, "--input-unit", "counts", cwd=tmp_path)
    assert json.loads(ran.stdout)["parameters"]["decay"]["unit"] == "1/counts"


@pytest.mark.skipif(not MEASURED.is_dir(), reason="no recordings beside the project")
@pytest.mark.parametrize(("run", "error"), [("00", 0.35), ("25", 0.3), ("45", 0.3)])
def test_real_recordings_are_identified_as_they_are(tmp_path: Path, run: str, error: float) -> None:
    ran = opensuction(
        *("identify", str(MEASURED / f"tool4_L4_{run}.csv"), "--time", "t_s", "--from", "0.5"),
        *("--input", "spindle_deg", "--output", "jaw_deg", "--negate-output"),
        *("--holdout", "0.5", "--json"),
        cwd=tmp_path,
    )
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    # A straight line leaves 2 to 3 % of the range, a good identification .23 to .28.
    assert data["rmse_percent_of_range"] < error
    assert data["line_rmse_percent_of_range"] > 1.9
    assert data["recording"]["from_s"] >= 0.5


BAD_OPTIONS = [
    (("identify",), "FILE"),
    (
        ("identify", "bench.csv"),
        "bench.csv: name what drives by --input and what follows by --output; its columns: "
        "time_s, head_mm, tip_mm",
    ),
    (
        ("compare", "bench.csv", "--input", "head_mm"),
        "bench.csv: name what follows by --output; its columns: time_s, head_mm, tip_mm",
    ),
    (("identify", "bench.csv", "--output", "tip_mm"), "name what drives by --input; its columns"),
    (("identify", "none.csv"), "no such file"),
    (("identify", "none.csv", *COLUMNS), "no such file"),
    (("identify", ".", *COLUMNS), "is a folder"),
    (
        ("identify", "bench.csv", "--input", "hed_mm", "--output", "tip_mm"),
        "did you mean 'head_mm'",
    ),
    (("identify", "bench.csv", "--input", "head", "--output", "y"), "time_s, head_mm, tip_mm"),
    (("identify", "bench.csv", "--input", "tip_mm", "--output", "tip_mm"), "both 'tip_mm'"),
    (("identify", "bench.csv", *COLUMNS, "--time", "t"), "time_s"),
    (("identify", "bench.csv", *COLUMNS, "--model", "dahl-ish"), "modified-dahl"),
    (("identify", "bench.csv", *COLUMNS, "--method", "magic"), "variable-projection"),
    (("identify", "bench.csv", *COLUMNS, "--holdout", "1.5"), "--holdout"),
    (("identify", "bench.csv", *COLUMNS, "--holdout", "nan"), "--holdout"),
    (("identify", "bench.csv", *COLUMNS, "--from", "3"), "--time"),
    (("identify", "bench.csv", *COLUMNS, "--time", "time_s", "--from", "99"), "99"),
    (("identify", "bench.csv", *COLUMNS, "--negate-output"), "leave out --negate-output"),
    (("compare", "bench.csv", *COLUMNS, "--model", "modified-dahl"), "--model"),
    (("compare", "none.csv", *COLUMNS), "no such file"),
]


@pytest.mark.parametrize(
    ("arguments", "named"), BAD_OPTIONS, ids=[" ".join(a)[:70] for a, _ in BAD_OPTIONS]
)
def test_bad_option_is_one_plain_line(
    arguments: tuple[str, ...], named: str, tmp_path: Path
) -> None:
    recording(tmp_path)
    assert_refused(opensuction(*arguments, "--json", cwd=tmp_path), named, tmp_path, left=1)


def test_an_output_that_does_not_follow_is_not_said_to_fall(tmp_path: Path) -> None:
    """Noise whose slope is below 0 by chance: its columns are the question, not its sign."""
    random = np.random.default_rng(0)
    head_mm = 50.0 - 50.0 * np.cos(np.linspace(0.0, 12.0, 1000))
    noise_mm = random.normal(size=1000) - 1e-4 * head_mm
    rows = "".join(f"{x},{y}\n" for x, y in zip(head_mm, noise_mm, strict=True))
    (tmp_path / "noise.csv").write_text("head_mm,tip_mm\n" + rows)
    done = opensuction("identify", "noise.csv", *COLUMNS, cwd=tmp_path)
    assert done.returncode == 2
    assert "'tip_mm' does not follow 'head_mm' (correlation -0.0" in done.stderr


ROWS = [f"{0.1 * i:.1f},{abs(i % 20 - 10)},{abs((i + 3) % 20 - 10)}" for i in range(60)]

BAD_RECORDINGS = {
    "constant input": ([r.split(",")[0] + ",5,1" for r in ROWS], "'head_mm' is constant at 5"),
    "constant output": ([",".join(r.split(",")[:2]) + ",1" for r in ROWS], "'tip_mm' is constant"),
    "one sample": (ROWS[:1], "1 sample, at least 12"),
    "unsorted time": ([*ROWS[10:20], *ROWS[:10]], "time should rise"),
    "duplicate time": ([*ROWS[:15], ROWS[14], *ROWS[15:]], "the same as the sample above"),
    "text in numbers": ([*ROWS[:15], "1.5,four,2", *ROWS[16:]], "line 17, column 'head_mm'"),
    "NaN": ([*ROWS[:15], "1.5,4,NaN", *ROWS[16:]], "line 17, column 'tip_mm'"),
    "no reversal": ([f"{i},{i},{i * i}" for i in range(60)], "revers"),
}


@pytest.mark.parametrize("case", BAD_RECORDINGS)
def test_bad_recording_is_one_plain_line(case: str, tmp_path: Path) -> None:
    rows, named = BAD_RECORDINGS[case]
    (tmp_path / "bad.csv").write_text("\n".join(["time_s,head_mm,tip_mm", *rows]))
    ran = opensuction("identify", "bad.csv", *COLUMNS, "--time", "time_s", "--json", cwd=tmp_path)
    assert_refused(ran, named, tmp_path, left=1)
    assert "bad.csv" in ran.stderr.splitlines()[-1]


def rows_of_bench(folder: Path) -> list[str]:
    """Rows of the recording of the published model, without their header."""
    return recording(folder).read_text().splitlines()[1:]


def test_rows_with_a_missing_number_are_left_out_if_asked(tmp_path: Path) -> None:
    rows = rows_of_bench(tmp_path)
    for place in (0, 7, 500):
        time_s, head, _ = rows[place].split(",")
        rows[place] = f"{time_s},{head},"
    (tmp_path / "gaps.csv").write_text("\n".join(["time_s,head_mm,tip_mm", *rows]))
    arguments = ("identify", "gaps.csv", *COLUMNS, "--time", "time_s", "--json")
    refused = opensuction(*arguments, cwd=tmp_path)
    assert_refused(refused, "(in 3 of 800 rows)", tmp_path, left=2)
    assert "line 2, column 'tip_mm': an empty cell" in refused.stderr
    assert "--skip-missing" in refused.stderr
    ran = opensuction(*arguments, "--skip-missing", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert "gaps.csv: rows left out, for a number is missing: 3" in ran.stderr
    data = json.loads(ran.stdout)
    assert (data["samples"], data["recording"]["skipped_rows"]) == (797, 3)
    assert data["parameters"]["slope"]["value"] == pytest.approx(PUBLISHED.slope, rel=1e-3)


def test_units_of_a_row_below_the_header_are_used(tmp_path: Path) -> None:
    """Time in ms: were it taken for seconds, --from would cut nothing off."""
    rows = [row.split(",") for row in rows_of_bench(tmp_path)]
    lines = [f"{1e3 * float(time_s)!r},{head},{tip}" for time_s, head, tip in rows]
    (tmp_path / "units.csv").write_text("\n".join(["Time,Head,Tip", "ms,mm,deg", *lines]))
    arguments = ("identify", "units.csv", "--input", "Head", "--output", "Tip (deg)", "--json")
    ran = opensuction(*arguments, "--time", "Time", "--from", "10", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data["parameters"]["slope"]["unit"] == "deg/mm"
    assert data["recording"]["from_s"] == pytest.approx(10.0)
    assert data["recording"]["input"]["column"] == "Head (mm)"


def test_columns_without_a_header_are_taken_by_number(tmp_path: Path) -> None:
    (tmp_path / "bare.csv").write_text("\n".join(rows_of_bench(tmp_path)))
    ran = opensuction("identify", "bare.csv", cwd=tmp_path)
    assert_refused(ran, "called by their number, 1 to 3): 1, 2, 3", tmp_path, left=2)
    ran = opensuction("identify", "bare.csv", *COLUMNS, cwd=tmp_path)
    assert_refused(ran, "no header, so its columns are called by their number", tmp_path, left=2)
    arguments = ("--input", "2", "--output", "3", "--time", "1", "--json")
    ran = opensuction("identify", "bare.csv", *arguments, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert "bare.csv: no header" in ran.stderr
    assert json.loads(ran.stdout)["samples"] == 800


STRANGERS = MEASURED.parent / "strangers"
FIRST_TRIES = {
    "boucwen.csv": ((), "its columns: x, v, a, E, f"),
    "column_spc1.csv": ((), "Lead Actuator Force (kN), Lead Actuator Displacment (mm)"),
    "friction_damper.csv": (
        ("--input", "displacement", "--output", "friction_force"),
        "add --negate-output",
    ),
    "mr_ensaio1.mat": (("--input", "x_F", "--output", "f"), "did you mean 'x_F(:,1)'"),
    "servo_comp2.csv": (
        ("--input", "target pos (1)", "--output", "pos (1)"),
        "(in 1 of 402 rows); fill it in, or leave such rows out with --skip-missing",
    ),
    "servo_single.csv": (("--input", "target pos (5)"), "name what follows by --output"),
    "wall_ts1.csv": ((), "no header, so its columns are called by their number, 1 to 2): 1, 2"),
}


@pytest.mark.skipif(not STRANGERS.is_dir(), reason="no recordings beside the project")
@pytest.mark.parametrize("name", FIRST_TRIES)
def test_a_first_try_on_files_of_others_leads_on(name: str, tmp_path: Path) -> None:
    arguments, words = FIRST_TRIES[name]
    ran = opensuction("identify", str(STRANGERS / name), *arguments, cwd=tmp_path)
    assert_refused(ran, words, tmp_path)


def test_folder_with_something_in_it_needs_force(tmp_path: Path) -> None:
    recording(tmp_path)
    arguments = ("identify", "bench.csv", *COLUMNS, "--out", ".", "--json")
    assert_refused(opensuction(*arguments, cwd=tmp_path), "--force", tmp_path, left=1)


BOTH = ("identify", "bent.csv", *COLUMNS, "--input", "bend_deg", "--json")


def bent(folder: Path, tip: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    """A recording of a tip that follows another input, too."""
    time_s, head, _ = motion()
    bend = 9.0 * np.sin(1.3 * time_s)
    rows = np.column_stack([time_s, head, bend, tip + 0.2 * bend]).tolist()
    lines = ["time_s,head_mm,bend_deg,tip_mm", *(",".join(map(repr, row)) for row in rows)]
    (folder / "bent.csv").write_text("\n".join(lines) + "\n")


def test_a_second_input_is_asked_for(tmp_path: Path) -> None:
    bent(tmp_path, motion()[2])
    ran = opensuction("identify", "bent.csv", *COLUMNS, "--time", "time_s", "--json", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert any("add --input bend_deg" in said for said in json.loads(ran.stdout)["warnings"])
    assert_refused(opensuction(*BOTH, cwd=tmp_path), "add --model play-readout", tmp_path, left=2)


@pytest.mark.sweep
def test_a_second_input_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(identification_run, "TIMED_S", -1.0)  # no second fit to measure its time
    bent(tmp_path, motion()[1])
    ran = opensuction(*BOTH, "--model", "play-readout", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data["rmse_percent_of_range"] < 0.5
    assert data["recording"]["other_inputs"] == ["bend_deg"]
    assert data["coupling_percent_of_range"].keys() == {"head_mm", "bend_deg"}
