"""The ``predict`` command as its users meet it."""

import json
from pathlib import Path

import pytest

from tests.cli.command import opensuction
from tests.cli.test_cycle import assert_refused
from tests.cli.test_identify import EXAMPLE, recording

COLUMNS = ("--input", "head_mm", "--output", "tip_mm")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With a recording, and the model that was fitted to it."""
    made = tmp_path_factory.mktemp("predict")
    recording(made)
    ran = opensuction("identify", "bench.csv", *COLUMNS, "--out", "fit", cwd=made)
    assert ran.returncode == 0, ran.stderr
    return made


def test_the_recording_that_was_fitted_is_predicted(folder: Path) -> None:
    arguments = ("predict", "bench.csv", "--model", "fit/identification.toml", "--with-interval")
    ran = opensuction(*arguments, "--json", "--out", "told", cwd=folder)
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data == json.loads((folder / "told" / "prediction.json").read_text())
    assert data["prediction_file"] == "told/prediction.csv"
    assert (data["samples"], data["output"], data["beyond_range"]) == (800, "tip_mm", 0)
    assert data["error"]["rmse"] < 1e-6
    lines = (folder / "told" / "prediction.csv").read_text().splitlines()
    assert lines[0] == "head_mm,tip_mm,predicted,lower_95,upper_95"
    assert len(lines) == 801


def test_a_person_is_told_how_far_off_it_is_and_where_it_lies(folder: Path) -> None:
    model = ("--model", "fit/identification.toml", "--out", "read")
    ran = opensuction("predict", str(EXAMPLE), *model, *COLUMNS, cwd=folder)
    assert ran.returncode == 0, ran.stderr
    words = " ".join(ran.stdout.split())
    assert "samples predicted" in words
    assert "From the measured tip_mm it is" in words
    assert "Warning: The error is" in words  # another machine's recording
    assert "Written: read/prediction.csv" in words
    assert "not a medical device" in words


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("bench.csv",), "Missing option '--model'"),
        (("bench.csv", "--model", "bench.csv"), "bench.csv"),
        (("none.csv", "--model", "fit/identification.toml"), "none.csv"),
        (
            ("bench.csv", "--model", "fit/identification.toml", "--input", "time_s"),
            "'time_s' is in s, and the model of fit/identification.toml was fitted in mm",
        ),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(
    folder: Path, arguments: tuple[str, ...], expected: str
) -> None:
    before = len(list(folder.iterdir()))
    ran = opensuction("predict", *arguments, "--out", "nothing", cwd=folder)
    assert_refused(ran, expected, folder, before)
