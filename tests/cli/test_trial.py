"""The ``trial`` command as its users meet it."""

import errno
import json
import signal
from pathlib import Path
from typing import Any, NoReturn

import pytest

from opensuction.cli import delivery, interruption
from opensuction.evidence import worker_pool
from opensuction.evidence.trial import draw, trial
from opensuction.evidence.trial.trial import Part, PlayedPart
from opensuction.oracle.harm import Harm
from opensuction.twin.fault.fault import Fault
from tests.cli.command import begun, opensuction, wait_for
from tests.evidence.trial.example import BREACH, HARM, STAYS, case

KEYS = {
    "cycles",
    "asked",
    "complete",
    "machines",
    "refused",
    "trial",
    "date_utc",
    "counted",
    "not_counted",
    "bounds",
    "left_inside",
    "command_breaches",
    "violations",
    "false_alarms",
    "false_before_fault",
    "true_alarms",
    "broken_off",
    "said",
    "untold",
    "endpoints",
    "watched_s",
    "workers",
    "wall_s",
    "cycles_per_s",
}
FEW = ("trial", "--cycles", "2", "--cohort", "neonate", "--faults", "none")
WRITTEN = ["trial-parts.jsonl", "trial.json", "trial.md"]


def names(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir())


def invent(monkeypatch: pytest.MonkeyPatch, *cases: Any) -> None:
    """Trials come to these cycles, without a process."""

    def spread(_: Any, tasks: list[Part], *rest: Any) -> None:
        for number, task in enumerate(tasks):
            numbers = draw.list_numbers(task.trial, task.machine, task.cycles)
            chosen = tuple(one for one in cases if one.number in numbers)
            rest[1](number, PlayedPart(task.machine, chosen, ()))

    monkeypatch.setattr(trial, "warm_up", lambda _: None)
    monkeypatch.setattr(worker_pool, "spread", spread)


def test_a_trial_gives_json_a_page_and_its_parts(tmp_path: Path) -> None:
    done = opensuction(*FEW, "--json", "--out", "t", "--workers", "1", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data.keys() >= KEYS
    assert (data["cycles"], data["complete"], data["machines"]) == (2, True, 2)
    assert data["counted"] == {"none": 2, "single": 0, "double": 0}
    assert data["false_alarms"] == data["command_breaches"] == data["left_inside"]["count"] == 0
    spread = data["endpoints"]["neonate"]["suction_s"]
    assert 2.0 < spread["p5"] <= spread["median"] <= spread["p95"] < 6.0
    assert names(tmp_path / "t") == WRITTEN
    assert json.loads((tmp_path / "t" / "trial.json").read_text()) == data
    page = (tmp_path / "t" / "trial.md").read_text()
    assert page.startswith("# Trial: 2 cycles without a fault\n")
    assert "2 cycles without a fault on 2 drawn machines; 1 process" in done.stderr


def test_what_was_broken_is_shown_with_what_plays_it_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = case(3, Fault.PUMP_LOST)._replace(breaches=(HARM,), commands=(BREACH,))
    left = case(2, Fault.GEAR_LOST)._replace(left_inside=STAYS)
    invent(monkeypatch, case(1, Fault.LINE_LEAK), left, broken)
    done = opensuction("trial", "--cycles", "3", "--seed", "7", "--out", "t", cwd=tmp_path)
    assert done.returncode == 1
    words = " ".join(done.stdout.split())
    assert "3: pump-lost, adult-icu by travel: force 0.4, limit 0.3" in words
    assert "opensuction trial --play 3 --faults single --seed 7" in words
    assert "1 of 3 cycles; 1 of them nothing could have prevented, 1 were told high" in words
    data = json.loads((tmp_path / "t" / "trial.json").read_text())
    assert data["command_breaches"] == 1
    assert [(one["number"], one["bound"]) for one in data["violations"]] == [
        (3, "a bound"),
        (3, "force"),
    ]


def test_what_two_faults_break_is_counted_and_not_claimed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = (Fault.PUMP_LOST, Fault.LINE_LEAK)
    invent(monkeypatch, case(1, *pair)._replace(breaches=(HARM,)))
    done = opensuction(
        "trial", "--cycles", "1", "--faults", "double", "--json", "--out", "t", cwd=tmp_path
    )
    assert done.returncode == 0
    assert json.loads(done.stdout)["bounds"]["double"]["broken"] == 1


def test_what_is_said_and_not_so_is_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    true = case(2)._replace(true_alarms=("SPO2_LOW",))
    invent(monkeypatch, case(1)._replace(false_alarms=("LINE_CLOGGED",)), true)
    done = opensuction(*FEW, "--out", "t", cwd=tmp_path)
    assert done.returncode == 1
    assert "1: adult-icu by travel: LINE_CLOGGED" in done.stdout
    data = json.loads((tmp_path / "t" / "trial.json").read_text())
    assert (data["false_alarms"], data["true_alarms"]) == (1, 1)
    assert [one["number"] for one in data["said"]] == [1, 2]


def test_a_worst_value_that_is_no_number_is_null(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = case(1, Fault.PUMP_LOST)._replace(breaches=(Harm("force", float("nan"), 0.3, "N"),))
    invent(monkeypatch, lost)
    done = opensuction("trial", "--cycles", "1", "--json", "--out", "t", cwd=tmp_path)
    assert json.loads(done.stdout)["violations"][0]["worst"] is None
    assert "| no number | 0.3 |" in (tmp_path / "t" / "trial.md").read_text()


def test_one_cycle_can_be_played_again(tmp_path: Path) -> None:
    done = opensuction(
        *("trial", "--play", "4", "--cohort", "neonate", "--json", "--out", "c"), cwd=tmp_path
    )
    data = json.loads(done.stdout)
    assert data["trial"]["number"] == 4
    assert data["trial"]["play"] == "opensuction trial --play 4 --faults single --cohort neonate"
    (fault,) = data["faults"]
    assert fault["at_s"] is not None
    assert data["patient"] == "neonate"
    assert names(tmp_path / "c") == ["cycle.json", "report.html"]
    assert done.returncode in (0, 1)  # as that cycle ended


def test_an_interruption_before_the_first_cycle_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(_: object) -> NoReturn:
        raise interruption.Stopped(signal.SIGTERM)

    monkeypatch.setattr(trial, "warm_up", stop)
    done = opensuction(*FEW, "--out", "t", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (143, "")
    assert done.stderr.splitlines()[-1] == "opensuction: terminated; nothing was written"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.soak
def test_a_signal_while_the_core_is_compiled_leaves_nothing(tmp_path: Path) -> None:
    environment = {"OPENSUCTION_CACHE_DIR": str(tmp_path / "cache")}
    (tmp_path / "work").mkdir()
    few = ("trial", "--cycles", "60", "--out", "t")
    with begun(*few, cwd=tmp_path / "work", environment=environment) as process:
        wait_for("Compiling", process.stderr)
        process.send_signal(signal.SIGTERM)
        _, words = process.communicate(timeout=20)
    assert process.returncode == 143
    assert words.splitlines()[-1] == "opensuction: terminated; nothing was written"
    assert list((tmp_path / "work").iterdir()) == []


def test_a_full_disk_is_one_line_and_keeps_what_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    invent(monkeypatch, case(1), case(2))
    keep = trial.keep

    def fill(folder: Path, played: PlayedPart) -> None:
        if played.machine:
            raise OSError(errno.ENOSPC, "No space left on device", str(folder / trial.NAME))
        keep(folder, played)

    monkeypatch.setattr(trial, "keep", fill)
    done = opensuction(*FEW, "--out", "t", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (74, "")
    assert done.stderr.splitlines()[-1] == (
        "opensuction: t/trial-parts.jsonl: no space left on device; 1 of 2 cycles are kept; go on "
        "with: opensuction trial --resume --out t"
    )
    monkeypatch.setattr(trial, "keep", keep)
    done = opensuction("trial", "--resume", "--out", "t", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert names(tmp_path / "t") == WRITTEN


@pytest.mark.parametrize("left", [1, 2])
def test_who_goes_on_and_is_stopped_at_once_loses_nothing(
    left: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the core is compiled, or, where no cycle is left, while its page is written."""
    invent(monkeypatch, case(1), case(2))
    assert opensuction(*FEW, "--out", "t", cwd=tmp_path).returncode == 0
    log = tmp_path / "t" / trial.NAME
    kept = b"".join(log.read_bytes().splitlines(keepends=True)[: 1 + left])
    log.write_bytes(kept)

    def stop(*_: object) -> NoReturn:
        raise interruption.Stopped(signal.SIGTERM)

    monkeypatch.setattr(trial, "warm_up", stop)
    monkeypatch.setattr(delivery, "write", stop)
    done = opensuction("trial", "--resume", "--out", "t", cwd=tmp_path)
    assert done.returncode == 143
    assert f"terminated; {left} of 2 cycles are kept; go on with: " in done.stderr
    assert log.read_bytes() == kept


@pytest.mark.parametrize("arguments", [(*FEW, "--force"), ("trial", "--resume"), FEW])
def test_two_commands_never_play_one_trial(
    arguments: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    invent(monkeypatch, case(1), case(2))
    said = []

    def meanwhile(_: object) -> None:
        said.append(opensuction(*arguments, "--out", "t", cwd=tmp_path))

    monkeypatch.setattr(trial, "warm_up", meanwhile)
    assert opensuction(*FEW, "--out", "t", cwd=tmp_path).returncode == 0
    (second,) = said
    assert (second.returncode, second.stderr.count("\n")) == (2, 1)
    assert "--out t: another command writes into it" in second.stderr
    assert set(trial.read(tmp_path / "t").parts) == {0, 1}


def test_processes_that_die_again_and_again_leave_what_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def spread(_: Any, tasks: list[Part], *rest: Any) -> None:
        rest[1](0, PlayedPart(tasks[0].machine, (case(1),), ()))
        raise worker_pool.WorkerLostError("3 processes died over the same task")

    monkeypatch.setattr(trial, "warm_up", lambda _: None)
    monkeypatch.setattr(worker_pool, "spread", spread)
    done = opensuction(*FEW, "--json", "--out", "t", cwd=tmp_path)
    assert done.returncode == 1
    data = json.loads(done.stdout)
    assert (data["cycles"], data["asked"], data["complete"]) == (1, 2, False)
    assert "3 processes died over the same task; 1 of 2 cycles are kept; go on" in done.stderr
    assert "**Not complete:** 1 of 2 cycles." in (tmp_path / "t" / "trial.md").read_text()


def test_processes_that_die_over_the_first_cycles_leave_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def spread(*_: Any) -> None:
        raise worker_pool.WorkerLostError("3 processes died over the same task")

    monkeypatch.setattr(trial, "warm_up", lambda _: None)
    monkeypatch.setattr(worker_pool, "spread", spread)
    done = opensuction(*FEW, "--json", "--out", "t", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    said = [line for line in done.stderr.splitlines() if line.startswith("opensuction: ")]
    assert said == ["opensuction: 3 processes died over the same task; nothing was written"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--cycles", "0"), "'--cycles': Input should be greater than or equal to 1"),
        (("--cycles", "-3"), "'--cycles': Input should be greater than or equal to 1"),
        ((), "--cycles is missing"),
        (("--cycles", "9", "--cohort", "adults"), "adult-icu"),
        (("--cycles", "9", "--faults", "triple"), "double"),
        (("--cycles", "9", "--compensation", "best"), "preview"),
        (("--cycles", "9", "--workers", "0"), "--workers"),
        (("--cycles", "9", "--preoxygenation", "maybe"), "confirmed"),
        (("--play", "0"), "--play"),
        (("--play", "3", "--cycles", "9"), "--play"),
        (("--resume",), "--out"),
        (("--resume", "--out", "nowhere"), "holds no trial"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(
    arguments: tuple[str, ...], word: str, tmp_path: Path
) -> None:
    done = opensuction("trial", *arguments, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert word in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_something_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    invent(monkeypatch, case(1), case(2))
    (tmp_path / "t").mkdir()
    (tmp_path / "t" / "mine.txt").write_text("mine")
    done = opensuction(*FEW, "--out", "t", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "not empty" in done.stderr
    assert opensuction(*FEW, "--out", "t", "--force", cwd=tmp_path).returncode == 0
    assert names(tmp_path / "t") == ["mine.txt", *WRITTEN]
    again = opensuction(*FEW, "--out", "t", cwd=tmp_path)
    assert (again.returncode, again.stderr.count("\n")) == (2, 1)
    assert "--resume" in again.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--cycles", "3"), "--cycles 2, not 3"),
        (("--seed", "5"), "--seed 1, not 5"),
        (("--faults", "double"), "--faults none, not double"),
    ],
)
def test_another_trial_is_not_gone_on_with(
    arguments: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    invent(monkeypatch, case(1), case(2))
    assert opensuction(*FEW, "--out", "t", cwd=tmp_path).returncode == 0
    before = (tmp_path / "t" / trial.NAME).read_bytes()
    done = opensuction("trial", "--resume", "--out", "t", *arguments, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert words in done.stderr
    assert (tmp_path / "t" / trial.NAME).read_bytes() == before


def test_a_trial_of_other_sources_is_not_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    invent(monkeypatch, case(1), case(2))
    assert opensuction(*FEW, "--out", "t", cwd=tmp_path).returncode == 0
    monkeypatch.setattr(trial, "hash_sources", lambda: "0123456789abcdef")
    done = opensuction("trial", "--resume", "--out", "t", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "other sources" in done.stderr
