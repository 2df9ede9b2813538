"""The ``inject`` command as its users meet it, before a twin that plays."""

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.machine.twin import twin_machine
from tests.cli.command import opensuction
from tests.controller.bedside import at_bed

pytestmark = pytest.mark.real_time


@pytest.fixture(scope="module")
def twin() -> Iterator[str]:
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        process = twin_machine.start(Path(folder), *at_bed("neonate"), seed=1)
        yield folder
        process.terminate()
        process.wait(timeout=10.0)


@pytest.fixture
def sound(twin: str, tmp_path: Path) -> str:
    """It is mended before each test."""
    assert opensuction("inject", twin, "--mend", cwd=tmp_path).returncode == 0
    return twin


def test_faults_are_taken_and_said_once_they_have_come(sound: str, tmp_path: Path) -> None:
    asked = ("--fault", "pump-weak=0.5", "--fault", "cough@suctioning+2")
    ran = opensuction("inject", sound, *asked, cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert ran.stdout == "Taken: pump-weak@0=0.5\nTaken: cough@suctioning+2=60\n"
    ran = opensuction("inject", sound, cwd=tmp_path)
    assert ran.stdout.splitlines()[-1].endswith(": pump-weak=0.5")
    ran = opensuction("inject", sound, "--fault", "line-leak", cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert "2 faults are there or to come" in ran.stderr
    ran = opensuction("inject", sound, "--mend", "--fault", "line-leak", "--json", cwd=tmp_path)
    data = json.loads(ran.stdout)
    assert (data["folder"], data["mended"], data["bus"]) == (sound, True, None)
    assert data["injected"] == [{"name": "line-leak", "at": "@0", "strength": 2.0}]
    weak = data["came"][0]
    assert (weak["name"], weak["strength"]) == ("pump-weak", 0.5)
    assert weak["tick"] > 0
    assert list(weak) == ["name", "strength", "tick"]


def test_a_bus_is_put_between(sound: str, tmp_path: Path) -> None:
    asked = ("--latency-ms", "2", "--jitter-ms", "0.5", "--lost-percent", "0.1")
    ran = opensuction("inject", sound, *asked, cwd=tmp_path)
    assert ran.stdout == "Bus: 2 ms +- 0.5 ms, 0.1 % lost\n"
    ran = opensuction("inject", sound, "--latency-ms", "1", "--json", cwd=tmp_path)
    assert json.loads(ran.stdout)["bus"] == {
        "latency_s": 0.001,
        "jitter_s": 0.0,
        "lost_share": 0.0,
    }


@pytest.mark.parametrize(
    ("asked", "what"),
    [
        (("--fault", "pump-waek"), "pump-weak"),
        (("--fault", "pump-weak=7"), "no strength 7"),
        (("--fault", "controller-stopped"), "kill its process"),
        (("--fault", "catheter-too-wide"), "set up already"),
        (("--jitter-ms", "1"), "jitter"),
        (("--lost-percent", "101"), "share of 0 to 1"),
    ],
    ids=str,
)
def test_bad_input_is_one_line(
    sound: str, tmp_path: Path, asked: tuple[str, ...], what: str
) -> None:
    ran = opensuction("inject", sound, *asked, cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert len(ran.stderr.splitlines()) == 1
    assert what in ran.stderr


def test_where_no_twin_plays_that_is_said(tmp_path: Path) -> None:
    for folder, what in (("nowhere", "no machine plays in "), (".", "no ring at")):
        ran = opensuction("inject", folder, "--mend", cwd=tmp_path)
        assert (ran.returncode, ran.stdout) == (2, "")
        assert what in ran.stderr
