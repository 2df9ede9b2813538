"""The ``simulate`` command as its users meet it."""

import json
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction import __version__
from opensuction.evidence import worker_pool
from opensuction.evidence.lives import life, lives, simulated_machine
from opensuction.evidence.lives.life_record import LifeResult
from tests.cli.command import begun, opensuction, spread_here, wait_for

SEED = 1
ID = f"{SEED}@{__version__}"
FEW = ("simulate", "--faults", "stop,impatient", "--seed", "900")


def test_a_life_that_is_played_leaves_its_timeline_and_its_recordings(tmp_path: Path) -> None:
    done = opensuction("simulate", "--play", str(SEED), "--out", "l", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert (data["seed"], data["id"]) == (SEED, ID)
    assert data["play"] == f"opensuction simulate --play {ID}"
    assert {one["kind"] for one in data["events"]} == {"fault", "phase", "process", "told"}
    folder = tmp_path / "l"
    assert json.loads((folder / "life.json").read_text()) == data
    assert data["recordings"]
    assert {one.name for one in folder.iterdir()} == {
        "life.json",
        "report.html",
        *data["recordings"],
    }
    assert ID in (folder / "report.html").read_text()
    replayed = opensuction("replay", f"l/{data['recordings'][0]}", "--json", cwd=tmp_path)
    assert json.loads(replayed.stdout)["identical"], replayed.stderr


def test_a_life_of_a_report_that_no_longer_breaks_says_so(tmp_path: Path) -> None:
    """Its own kinds of faults are in the command that plays it."""
    asked = ("simulate", "--faults", "stop", "--cycles", "1", "--play")
    done = opensuction(*asked, ID, "--out", "l", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert f"Life {ID} no longer breaks anything." in done.stdout.splitlines()
    assert "Timeline: l/report.html" in done.stdout.splitlines()
    data = json.loads((tmp_path / "l" / "life.json").read_text())
    assert data["play"] == f"opensuction simulate --play {ID} --faults stop"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            ("--play", "4711@0.1.0"),
            f"this is version {__version__}, which draws another life from the seed 4711 than "
            "0.1.0 did; --play 4711 plays that one",
        ),
        (("--play", "4711@"), "give a seed from 0 on, or seed and version"),
        (("--play", "-1"), "give a seed from 0 on"),
        (("--play", "neonate"), "give a seed from 0 on"),
        (("--play", "1", "--lives", "5"), "leave out --lives"),
        (("--play", "1", "--seed", "0", "--workers", "2"), "leave out --seed, --workers"),
        (("--lives", "0"), "'--lives'"),
        (("--seed", "-1"), "'--seed'"),
        (("--cycles", "0"), "'--cycles'"),
        (("--cycles", "31"), "'--cycles'"),
        (("--workers", "0"), "'--workers'"),
        (("--faults", "kill,plague"), "unknown kind of fault 'plague'"),
        (("--faults", ""), "unknown kind of fault ''"),
    ],
)
def test_what_makes_no_sense_is_one_line_and_nothing_is_written(
    given: tuple[str, ...], words: str, tmp_path: Path
) -> None:
    done = opensuction("simulate", *given, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert words in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def _small_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Memory of 200 MiB, of which the files of two lives take nearly all."""
    memory = tmp_path / "memory"
    memory.mkdir()
    size = ("-o", "size=200m")
    made = subprocess.run(
        ["mount", "-t", "tmpfs", *size, "tmpfs", str(memory)], capture_output=True, check=False
    )
    if made.returncode:
        pytest.skip("this user may not mount a small file system")
    monkeypatch.setattr(simulated_machine, "MEMORY", memory)
    yield
    subprocess.run(["umount", "--lazy", str(memory)], check=True)


@pytest.mark.usefixtures("_small_memory")
def test_memory_that_is_full_after_a_life_keeps_that_life(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In this process, of which the campaign makes no other."""

    def play_and_fill(seed: int, room: Path, **_: object) -> LifeResult:
        found = life.play(life.draw(seed), room)
        (tmp_path / "memory" / "full").write_bytes(bytes(100 * simulated_machine.MIB))
        return found

    monkeypatch.setattr(worker_pool, "spread", spread_here)
    monkeypatch.setattr(lives, "_play", play_and_fill)
    done = opensuction(*FEW, "--lives", "3", "--workers", "1", "--out", "s", cwd=tmp_path)
    assert (done.returncode, "Ended early, after 1 of 3 lives." in done.stdout) == (2, True)
    last = done.stderr.splitlines()[-1]
    assert last.startswith("opensuction: no space for the files of a life: ")
    assert f"MiB are free in {tmp_path / 'memory'}, and it needs 128" in last
    assert last.endswith("1 of 3 lives are finished, and in s/simulate.json")
    found = json.loads((tmp_path / "s" / "simulate.json").read_text())
    assert (found["lives"], found["asked"], found["complete"]) == (1, 3, False)
    assert [one.name for one in (tmp_path / "memory").iterdir()] == ["full"]


@pytest.mark.soak
@pytest.mark.usefixtures("_small_memory")
def test_a_campaign_that_fills_the_memory_keeps_what_is_finished(tmp_path: Path) -> None:
    """A life goes by what it finds at its begin: each of two finds room for itself alone."""
    (tmp_path / "memory" / "full").write_bytes(b"")
    asked = (*FEW, "--lives", "6", "--workers", "2", "--out", "s")
    done = opensuction(*asked, cwd=tmp_path)
    assert done.returncode == 2
    last = done.stderr.splitlines()[-1]
    assert last.startswith("opensuction: no space for the files of a life: ")
    assert f"MiB are free in {tmp_path / 'memory'}, and it needs 128" in last
    found = json.loads((tmp_path / "s" / "simulate.json").read_text())
    assert last.endswith(f"{found['lives']} of 6 lives are finished, and in s/simulate.json")
    assert (found["asked"], found["complete"]) == (6, False)
    assert 1 <= found["lives"] < 6
    assert f"Ended early, after {found['lives']} of 6 lives." in done.stdout
    assert [one.name for one in (tmp_path / "memory").iterdir()] == ["full"]


@pytest.mark.usefixtures("_small_memory")
def test_a_life_for_which_there_is_no_space_from_the_start_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "memory" / "full").write_bytes(b"x" * (100 * simulated_machine.MIB))
    done = opensuction(*FEW, "--lives", "2", "--workers", "1", "--out", "s", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    last = done.stderr.splitlines()[-1]
    assert last.startswith("opensuction: no space for the files of a life: 100 MiB are free in ")
    assert not (tmp_path / "s").exists()


def test_ctrl_c_keeps_the_lives_that_are_finished(tmp_path: Path) -> None:
    asked = (*FEW, "--lives", "100000", "--workers", "1", "--out", "s")
    before = set(simulated_machine.MEMORY.glob(f"{simulated_machine.ROOM}*"))
    with begun(*asked, cwd=tmp_path) as process:
        wait_for("1 of 100000 lives", process.stderr)
        process.send_signal(signal.SIGINT)
        said, words = process.communicate(timeout=120)
    assert process.returncode == 130
    found = json.loads((tmp_path / "s" / "simulate.json").read_text())
    assert found["lives"] >= 1
    assert (found["asked"], found["complete"], found["ok"]) == (100_000, False, True)
    assert words.splitlines()[-1] == (
        f"opensuction: interrupted; {found['lives']} of 100000 lives are finished, and in "
        "s/simulate.json"
    )
    assert f"Ended early, after {found['lives']} of 100000 lives." in said
    # The processes that played are gone, and their files.
    assert set(simulated_machine.MEMORY.glob(f"{simulated_machine.ROOM}*")) <= before


def test_a_broken_life_is_named_by_seed_and_version(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With nobody to be told within no time at all, a controller's death breaks a life."""
    monkeypatch.setattr(life, "TOLD_S", -1.0)
    seed = next(
        seed
        for seed in range(1000)
        if any(
            (one.kind, one.target, one.phase is not None) == ("kill", "control", True)
            for one in life.draw(seed).faults[:1]
        )
    )
    done = opensuction("simulate", "--play", str(seed), "--out", "l", cwd=tmp_path)
    assert done.returncode == 1
    lines = done.stdout.splitlines()
    assert any(
        line.startswith("breaks 'told': nobody is that the drives act on their own, at ")
        for line in lines
    )
    assert any(line.startswith("fewest faults that do so: kill-control@") for line in lines)
    assert f"life {seed}@{__version__}, trace " in done.stdout
    assert "Broken: told" in (tmp_path / "l" / "report.html").read_text()
