"""A cycle as a script runs it: the command's object, and every tick as columns."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

import opensuction as osn
from tests.cli.command import opensuction, unrecorded
from tests.library.test_fit import refusal


@pytest.fixture(scope="module")
def run() -> osn.Run:
    return osn.cycle(protocol="paper", seed=3)


def test_the_summary_is_the_commands(run: osn.Run, tmp_path: Path) -> None:
    trace = tmp_path / "ticks.csv"
    options = ("--protocol", "paper", "--seed", "3", "--trace", str(trace), "--json")
    ran = unrecorded("cycle", *options, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    command = json.loads(ran.stdout)
    of_the_run = {"wall_s", "realtime_factor", "recording", "trace"}
    assert command.keys() == run.summary.keys()
    for key in command.keys() - of_the_run:
        assert run.summary[key] == command[key], key
    assert command["trace"] == str(trace)
    written = osn.read(trace, "time_s", "truth.tip_mm", "phase")
    for name, values in written.items():
        assert np.array_equal(values, run.trace[name]), name
    assert run.is_good


def test_the_trace_is_taken_by_numpy_pandas_and_polars(run: osn.Run) -> None:
    ticks = run.trace["time_s"].size
    assert all(values.shape == (ticks,) for values in run.trace.values())
    assert np.diff(run.trace["time_s"]) == pytest.approx(0.001)
    for frame in (pd.DataFrame(run.trace), pl.DataFrame(run.trace)):
        assert frame.shape == (ticks, len(run.trace))
        assert np.array_equal(np.asarray(frame["truth.tip_mm"]), run.trace["truth.tip_mm"])
    assert np.array_equal(dict(run.trace)["time_s"], run.trace["time_s"])


def test_the_trace_is_written_and_read_again(run: osn.Run, tmp_path: Path) -> None:
    file = tmp_path / "ticks.parquet"
    run.save_trace(file)
    frame = pd.read_parquet(file)
    assert list(frame.columns) == list(run.trace)
    assert np.array_equal(frame["truth.tip_mm"].to_numpy(), run.trace["truth.tip_mm"])
    assert frame["phase"].dtype.kind == "i"
    assert "is there already" in refusal(lambda: run.save_trace(file))
    run.save_trace(file, force=True)
    assert [one.name for one in tmp_path.iterdir()] == [file.name]


def test_the_report_is_a_page(run: osn.Run, tmp_path: Path) -> None:
    run.report(tmp_path / "report.html")
    assert "<html" in (tmp_path / "report.html").read_text("utf-8")


def test_it_is_shown_in_a_line(run: osn.Run) -> None:
    assert repr(run).startswith("Run(bench, completed, ")
    assert repr(run).endswith(" s, seed 3)")
    assert repr(run.trace).startswith(f"Trace({run.trace['time_s'].size} ticks of ")


BAD: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "patient": ({"patient": "neonat"}, ("--patient", "neonat")),
    "protocol": ({"protocol": "papr"}, ("--protocol", "papr")),
    "approach": ({"approach": "touch"}, ("--approach", "touch")),
    "compensation": ({"compensation": "no.toml"}, ("--compensation", "no.toml")),
    "fault": ({"faults": "leak"}, ("--fault", "leak")),
    "conduit": ({"conduit": "straight"}, ("--conduit", "straight")),
    "gap": ({"gap_scale": 3.0}, ("--gap-scale", "3.0")),
    "bench": (
        {"machine": "bench", "protocol": "adult"},
        ("--machine", "bench", "--protocol", "adult"),
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_the_command_refuses_is_refused_in_its_words(case: str, tmp_path: Path) -> None:
    keywords, options = BAD[case]
    ran = opensuction("cycle", *options, cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert ran.stderr == f"opensuction: {refusal(lambda: osn.cycle(**keywords))}\n"


def test_an_impossible_seed_is_refused() -> None:
    assert refusal(lambda: osn.cycle(seed=-1)) == "seed -1: should be 0 to 4294967295"
