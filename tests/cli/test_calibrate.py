"""The ``calibrate`` command as its users meet it."""

import hashlib
import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from tests.cli.command import opensuction, unrecorded

KEYS = {
    "accepted",
    "reasons",
    "machine",
    "seed",
    "parameters",
    "plays",
    "servo",
    "rmse_mm",
    "validation_rmse_mm",
    "validation",
    "samples",
    "seconds",
}
NOISY = """\
preset = "bench"
catheter = "12fr"
conduit = "standard"
[twin]
laser_noise_mm = 1.0
"""


class Ran:
    """One run of the command for all tests of this file."""

    def __init__(self, folder: Path) -> None:
        arguments = ("--machine", "bench", "--seed", "3", "--out", "b3", "--json")
        done = opensuction("calibrate", *arguments, cwd=folder)
        assert done.returncode == 0, done.stderr
        self.data: dict[str, Any] = json.loads(done.stdout)
        self.cwd = folder
        self.folder = folder / "b3"


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return Ran(tmp_path_factory.mktemp("calibrate"))


def test_json_has_the_promised_keys_and_the_files_are_there(ran: Ran) -> None:
    assert ran.data.keys() >= KEYS
    assert ran.data["accepted"]
    assert json.loads((ran.folder / "calibrate.json").read_text()) == ran.data
    assert {file.name for file in ran.folder.iterdir()} == {
        "calibration.toml",
        "recording.csv",
        "report.html",
        "calibrate.json",
    }
    html = (ran.folder / "report.html").read_text()
    for check in ran.data["checks"]:
        assert check["ok"]
        assert check["name"].split("'")[0] in html


def test_the_parameter_file_names_the_recording_beside_it(ran: Ran) -> None:
    digest = hashlib.sha256((ran.folder / "recording.csv").read_bytes()).hexdigest()
    assert ran.data["recording_sha256"] == digest
    assert digest in (ran.folder / "calibration.toml").read_text()


def test_a_cycle_tracks_as_well_as_one_that_identifies_in_place(ran: Ran) -> None:
    rmse = {}
    for name in ("preview", "b3/calibration.toml"):
        arguments = ("--protocol", "paper", "--seed", "3", "--compensation", name, "--json")
        done = unrecorded("cycle", *arguments, "--out", "run", "--force", cwd=ran.cwd)
        assert done.returncode == 0, done.stderr
        rmse[name] = json.loads(done.stdout)["tip"]["rmse_mm"]
    assert rmse["b3/calibration.toml"] == pytest.approx(rmse["preview"], abs=0.03)
    assert rmse["b3/calibration.toml"] < 0.15  # some .1 mm, where exact-inverse leaves .5


def test_another_kind_of_machine_does_not_take_the_file(ran: Ran) -> None:
    file = "b3/calibration.toml"
    done = opensuction("cycle", "--compensation", file, "--out", "other", cwd=ran.cwd)
    assert (done.returncode, done.stdout) == (2, "")
    assert "calibrated on a bench machine, and this one is clinical" in done.stderr


def test_the_command_that_it_names_can_be_pasted(ran: Ran) -> None:
    machine = ran.cwd / "my bench.toml"
    machine.write_text('preset = "bench"\ncatheter = "12fr"\nconduit = "standard"\n')
    arguments = ("--machine", machine.name, "--seed", "3", "--out", "it's b4")
    done = opensuction("calibrate", *arguments, cwd=ran.cwd)
    (line,) = (one for one in done.stdout.splitlines() if one.startswith("Use it: "))
    command, *words = shlex.split(line.removeprefix("Use it: "))
    assert command == "opensuction"
    done = unrecorded(*words, "--out", "run", "--force", cwd=ran.cwd)
    assert done.returncode == 0, done.stderr


def test_the_recording_can_be_identified_again(ran: Ran) -> None:
    columns = ("--input", "head_mm", "--output", "tip_mm", "--time", "time_s")
    # Models of the whole range are fitted to the excitation, not to the shorter strokes after it.
    span = ("--to", "39.99")
    done = opensuction("identify", "b3/recording.csv", *columns, *span, "--json", cwd=ran.cwd)
    assert done.returncode == 0, done.stderr
    again = json.loads(done.stdout)["parameters"]
    for name in ("slope", "velocity_gain", "decay", "offset"):
        # A tenth of the samples, with a tenth of the laser's readings.
        assert again[name]["value"] == pytest.approx(
            ran.data["parameters"][name]["value"], rel=2e-3
        )


def test_a_poor_fit_is_refused_in_words_and_leaves_no_parameter_file(tmp_path: Path) -> None:
    (tmp_path / "noisy.toml").write_text(NOISY)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "calibration.toml").write_text("of an earlier run")
    arguments = ("--machine", "noisy.toml", "--out", "run", "--force")
    done = opensuction("calibrate", *arguments, "--json", cwd=tmp_path)
    assert done.returncode == 1
    data = json.loads(done.stdout)
    assert not data["accepted"]
    assert data["parameter_file"] is None
    assert any("look for a loose laser" in reason for reason in data["reasons"])
    assert not (tmp_path / "run" / "calibration.toml").exists()
    html = (tmp_path / "run" / "report.html").read_text()
    assert "Refused" in html


BAD = [
    (("--machine", "brench"), "bench"),
    (("--machine", "missing.toml"), "no such file"),
    (("--machine", "bench", "--patient", "neonate"), "no patient"),
    (("--compensation", "none"), "preview"),
    (("--compensation", "b3/calibration.toml"), "preview"),
    (("--catheter", "13fr"), "12fr"),
    (("--conduit", "bent"), "looped"),
    (("--seed", "-1"), "seed"),
]


@pytest.mark.parametrize(("arguments", "words"), BAD, ids=[" ".join(given) for given, _ in BAD])
def test_bad_input_is_one_line_and_nothing_is_written(
    tmp_path: Path, arguments: tuple[str, ...], words: str
) -> None:
    done = opensuction("calibrate", *arguments, "--out", "run", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert len(done.stderr.splitlines()) == 1
    assert words in done.stderr
    assert list(tmp_path.iterdir()) == []
