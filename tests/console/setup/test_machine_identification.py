"""Result of ``calibrate``, run in a process of its own, as the console reads it from its file."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from opensuction.console.setup import machine_identification
from opensuction.console.setup.machine_identification import IdentificationJob


@pytest.fixture(scope="module")
def ended() -> subprocess.Popen[bytes]:
    """A process that is over."""
    process = subprocess.Popen([sys.executable, "-S", "-c", ""])
    process.wait()
    return process


def job(folder: Path, ended: subprocess.Popen[bytes], text: str | None) -> IdentificationJob:
    folder = folder / "run"
    folder.mkdir()
    if text is not None:
        (folder / machine_identification.RESULT).write_text(text, encoding="utf-8")
    return IdentificationJob("run", "engineer", folder, ended, 0.0, ("calibrate",))


def written(**changes: Any) -> str:
    complete = {
        "accepted": True,
        "reasons": [],
        "machine": "bedside",
        "gap_mm": 21.5,
        "gap_ratio": 0.97,
        "checks": [{"name": "gap", "ok": True}],
        "seconds": 3.0,
    }
    return json.dumps(complete | changes)


def test_what_was_found_is_shown_with_the_figures_of_the_page(
    tmp_path: Path, ended: subprocess.Popen[bytes]
) -> None:
    told = machine_identification.shown(job(tmp_path, ended, written()))
    assert (told["state"], told["detail"]) == ("found", "")
    assert list(told["result"]) == list(machine_identification.FIGURES)
    assert told["result"]["gap_ratio"] == 0.97
    assert told["result"]["checks"] == [{"name": "gap", "ok": True}]
    assert told["result"]["servo"] is None
    assert "seconds" not in told["result"]


def test_a_refusal_is_told_with_its_reasons(tmp_path: Path, ended: subprocess.Popen[bytes]) -> None:
    text = written(accepted=False, reasons=["Too short.", "Repeat it."], gap_mm=None)
    run = job(tmp_path, ended, text)
    told = machine_identification.shown(run)
    assert (told["state"], told["detail"]) == ("refused", "Too short. Repeat it.")
    found = machine_identification.result_of(run)
    assert found is not None
    assert (found.accepted, found.gap_mm) == (False, None)


@pytest.mark.parametrize(
    "text",
    [
        None,
        "",
        '{"accepted": tr',
        "[]",
        '{"reasons": [], "gap_mm": 1.0}',
        written(accepted="yes"),
        written(gap_mm="21 mm"),
        written(reasons="none"),
        written(gap_mm=None),
    ],
)
def test_a_file_that_is_no_result_is_told_as_a_failure(
    text: str | None, tmp_path: Path, ended: subprocess.Popen[bytes]
) -> None:
    run = job(tmp_path, ended, text)
    assert machine_identification.result_of(run) is None
    told = machine_identification.shown(run)
    assert (told["state"], told["result"]) == ("failed", None)
    assert told["detail"] == "it ended with status 0"
